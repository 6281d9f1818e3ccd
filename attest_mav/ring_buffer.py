"""A queue for values that come and go with every sample.

Compiled, an access is a call of C; each one to the standard library's deque would go through Python.
"""

from typing import Final, Generic, TypeVar, cast

from mypy_extensions import i64

Value = TypeVar("Value")

LEAST_SLOTS: Final = 8
"""A power of two, as every later number of slots."""


class RingBuffer(Generic[Value]):
    """Values in order of arrival; the oldest one leaves first. The number of slots doubles when all are taken."""

    def __init__(self) -> None:
        self.count: i64 = 0
        """Values in the buffer."""
        self._slots: list[Value | None] = [None] * LEAST_SLOTS
        self._mask: i64 = LEAST_SLOTS - 1
        self._first: i64 = 0

    @property
    def oldest(self) -> Value:
        """The value that came first. IndexError if there is none."""
        return self.at(0)

    @property
    def newest(self) -> Value:
        """The value that came last. IndexError if there is none."""
        return self.at(self.count - 1)

    def at(self, index: i64) -> Value:
        """The value with this place in the order, the oldest one's is 0. IndexError if there is none."""
        if index < 0 or index >= self.count:
            raise IndexError(f"place {index} of {self.count} values")
        return cast("Value", self._slots[(self._first + index) & self._mask])

    def append(self, value: Value) -> None:
        """Take the next value."""
        if self.count > self._mask:
            self._grow()
        self._slots[(self._first + self.count) & self._mask] = value
        self.count += 1

    def pop_oldest(self) -> Value:
        """Give the oldest value away. IndexError if there is none."""
        value = self.at(0)
        self._slots[self._first] = None
        self._first = (self._first + 1) & self._mask
        self.count -= 1
        return value

    def clear(self) -> None:
        """Forget all values."""
        self._slots = [None] * LEAST_SLOTS
        self._mask = LEAST_SLOTS - 1
        self._first = self.count = 0

    def _grow(self) -> None:
        """Double the slots; the oldest value comes first in them."""
        slots, first = self._slots, self._first
        empty: list[Value | None] = [None] * len(slots)
        self._slots = slots[first:] + slots[:first] + empty
        self._mask = 2 * self._mask + 1
        self._first = 0

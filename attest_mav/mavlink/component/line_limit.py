"""One line a kind and minute: whatever others do to us as often as they like is told once, and then counted."""

from typing import Final

MINUTE_NS: Final = 60_000_000_000
MAX_KINDS: Final = 64
"""Kinds remembered; beyond that the one told longest ago is forgotten."""


class LineLimit:
    """Lets ``allowed`` lines of each kind through in a minute."""

    def __init__(self, allowed: int = 1) -> None:
        self._allowed: Final = allowed
        self._began_ns: Final[dict[str, int]] = {}
        self._counts: Final[dict[str, int]] = {}

    def suffix(self, kind: str, now_ns: int) -> str | None:
        """What to add to the line that is to be told now, None where it is not to be told.

        The first line of a new minute names the number of those that were left out before it.
        """
        began_ns = self._began_ns.get(kind)
        if began_ns is not None and 0 <= now_ns - began_ns < MINUTE_NS:
            self._counts[kind] += 1
            return "" if self._counts[kind] <= self._allowed else None
        left_out = max(self._counts.pop(kind, 0) - self._allowed, 0)
        self._began_ns.pop(kind, None)
        self._began_ns[kind] = now_ns
        self._counts[kind] = 1
        if len(self._began_ns) > MAX_KINDS:
            oldest = next(iter(self._began_ns))
            del self._began_ns[oldest], self._counts[oldest]
        return f" ({left_out} more such lines were left out)" if left_out else ""

"""The base of all records: plain classes whose constructor takes their fields by name, and which are set once.

Records that are made and freed at every sample have ``free_list_len=1``: compiled, the last one that was freed lends
its memory to the next one.
"""

from inspect import signature
from typing import Any

from mypy_extensions import mypyc_attr


@mypyc_attr(acyclic=True, allow_interpreted_subclasses=True)
class Record:
    """Pickles and copies as the call that makes the record again: its fields cannot be set one by one.

    Each argument of a constructor has a field of its name.
    """

    def __reduce__(self) -> tuple[Any, ...]:
        """The class, and the values of its constructor's arguments."""
        kind = type(self)
        return kind, tuple([getattr(self, name) for name in signature(kind).parameters])

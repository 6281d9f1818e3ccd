"""Use of the receiver on all lanes, and whether usual values may be updated at present."""

from enum import IntEnum
from typing import Final


class Standing(IntEnum):
    """How a lane stands."""

    NEW = 0
    """Its filter has no attitude yet, or has lost it."""
    GOOD = 1
    """Its attitude is one of the set."""
    ASIDE = 2
    """Its sensor is at fault: the filter does not run, the readings are compared with a lane in good standing."""


class Situation:
    """Is given to every lane, and replaced when it changes."""

    def __init__(self, calm: bool = True, receiver_used: bool = True, fix_shift_s: float = 0.0) -> None:
        self.calm: Final = calm
        """Nothing is disputed, nothing contradicts."""
        self.receiver_used: Final = receiver_used
        """Whether the filters take velocity fixes."""
        self.fix_shift_s: Final = fix_shift_s
        """By how much fixes are older than they say, beside the delay that the filter estimates, s."""

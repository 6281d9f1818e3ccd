"""Whether an attitude has proven itself: fixes that fit it one after another since its alignment.

An alignment in motion can end far off. Until the attitude is proven, a fix that does not fit speaks against it and not
against the receiver: the filter uses the fix, with the variance that its own gate gives, or aligns again.
"""

from typing import Final

PROVING_FIXES: Final = 15
"""So many fixes in a row that fit prove an attitude."""


class ProvingFixes:
    """Counts the fixes since an alignment."""

    def __init__(self) -> None:
        self.done = False
        """True once the attitude is proven; one that is proven stays so until its filter aligns again."""
        self._fits = 0

    def take(self, fits: bool) -> None:
        """Take the next fix: whether it is within the gate."""
        self._fits = self._fits + 1 if fits else 0
        self.done = self.done or self._fits >= PROVING_FIXES

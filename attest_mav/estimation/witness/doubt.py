"""Doubt: times in which nothing is published and no verdict is given, because all lanes were contradicted just now."""

from typing import Final

FIX_DOUBT_NS: Final = 600_000_000
"""After a fix that contradicts all lanes."""
FAR_GATES: Final = 0.5
"""Two fixes in a row beyond this share of their gate on all lanes make doubt."""
FAR_ALONE_GATES: Final = 0.7
"""One fix beyond this share does. Noise of a healthy receiver exceeds half of the gate every minute or few, hardly ever
twice in a row, and this share hardly ever."""
FIELD_DOUBT_NS: Final = 1_400_000_000
"""The first time of a field residual; one that stays is the field's own."""
FIELD_CLEAR_NS: Final = 2_000_000_000
"""A residual that was absent for so long is a new one when it comes again."""
PROBATION_FIXES: Final = 20
"""Four seconds at 5 Hz: a wrong gyro shows in the innovations of a manoeuvre only, and two seconds may have none."""
PROBATION_INNOVATION: Final = 0.15
PROBATION_USUALS: Final = 4.0
"""After all gyros were found to have stepped, so many fixes in a row must be within both limits, m/s."""


class Doubt:
    """Instants are those of the sensor's clock, ns."""

    def __init__(self) -> None:
        self._fix_until_ns = -1
        self._was_far = False
        """Whether the newest fix was beyond ``FAR_GATES``."""
        self._field_until_ns = -1
        self._field_seen_ns = -2 * FIELD_CLEAR_NS
        self._probation = 0
        """Fixes still to come; 0 without probation."""

    def active(self, now_ns: int) -> bool:
        """True while there is doubt."""
        return now_ns < self._fix_until_ns or now_ns < self._field_until_ns or self._probation > 0

    def take_fix(self, share: float, now_ns: int) -> None:
        """Take the next fix. share: of the gate, the least of all lanes."""
        is_far = share > FAR_GATES
        if share > FAR_ALONE_GATES or (is_far and self._was_far):
            self.fix_contradicts(now_ns)
        self._was_far = is_far

    def fix_contradicts(self, now_ns: int) -> None:
        """A fix contradicts all lanes."""
        self._fix_until_ns = now_ns + FIX_DOUBT_NS

    def fix_is_explained(self) -> None:
        """The contradicting fix is explained: the doubt ends."""
        self._fix_until_ns = -1

    def field_contradicts(self, now_ns: int) -> None:
        """The field's residual is beyond its limit on all lanes."""
        if now_ns - self._field_seen_ns > FIELD_CLEAR_NS:
            self._field_until_ns = now_ns + FIELD_DOUBT_NS
        self._field_seen_ns = now_ns

    def begin_probation(self) -> None:
        """All gyros have stepped."""
        self._probation = PROBATION_FIXES

    def fix_on_probation(self, innovation: float, usual: float, field_fits: bool) -> None:
        """A fix after that: its innovation, and the usual one, m/s."""
        if self._probation > 0:
            fits = innovation < max(PROBATION_INNOVATION, PROBATION_USUALS * usual) and field_fits
            self._probation = self._probation - 1 if fits else PROBATION_FIXES

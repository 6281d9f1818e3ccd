"""The form of the trim in ATTITUDE_QUATERNION where the firmware's version, which decides, is not known.

ATTITUDE carries the same attitude in a form that is the same in all versions. Of the forms that are possible the right
one makes both messages agree.
"""

from collections.abc import Sequence
from typing import Final

from attest_mav.algebra import norm, q_conj, q_mul
from attest_mav.estimation.body_frames import TrimForm, without_trim
from attest_mav.estimation.timebase import wrapped_difference_ns
from attest_mav.samples import AttitudeSample
from attest_mav.types import Quat, Vec3

TOGETHER_NS: Final = 5_000_000
"""Messages of one burst have time stamps that differ by no more."""
ENOUGH: Final = 0.02
"""rad: the sums of differences must lie so far apart for a decision; it takes several pairs at a trim of a degree."""


class TrimFormFit:
    """Sums up, for each form, how far the two messages are apart."""

    def __init__(self) -> None:
        self._sums: Final[dict[TrimForm, float]] = {}
        self._decided: TrimForm | None = None
        self._t_ns = -1
        self._attitude: Quat = (1.0, 0.0, 0.0, 0.0)

    def remember(self, t_ns: int, q_nb: Quat) -> None:
        """Take the IMU's attitude by the newest ATTITUDE."""
        self._t_ns, self._attitude = t_ns, q_nb

    def judge(self, sample: AttitudeSample, forms: Sequence[TrimForm], trim: Vec3) -> TrimForm:
        """The form that fits best; the first one while there is no telling."""
        if self._decided is not None:
            return self._decided if self._decided in forms else forms[0]
        if self._t_ns < 0 or abs(wrapped_difference_ns(sample.t_ns, self._t_ns)) > TOGETHER_NS:
            return forms[0]
        for form in forms:
            theirs = without_trim(form, trim, sample.q_nb, (0.0, 0.0, 0.0))
            self._sums[form] = self._sums.get(form, 0.0) + _apart(theirs, self._attitude)
        ordered = sorted(forms, key=lambda form: self._sums[form])
        if self._sums[ordered[1]] - self._sums[ordered[0]] > ENOUGH:
            self._decided = ordered[0]
        return ordered[0]


def _apart(a: Quat, b: Quat) -> float:
    """Size of the rotation between two attitudes that are near each other, rad."""
    _, x, y, z = q_mul(q_conj(a), b)
    return 2.0 * norm((x, y, z))

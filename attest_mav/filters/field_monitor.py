"""Whether the magnetometer shows the Earth's field: by its strength and its inclination, against their usual values.

As in VQF (Laidig and Seel, Information Fusion 91, 2023), limits as parameters. A field that was rejected for long is
that of a new place, or the first reference was wrong: it becomes the reference.

The flight filter monitors the field in ``velocity_aided/aids/magnetometer``, with the same two quantities and another
answer: the size of the disturbance instead of yes or no, and limits that grow with the tilt's sigma. The lane's
``StuckMagnetometer`` looks at repetition, not at the field.
"""

from math import asin, exp, radians
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import clamp, dot, down_in_body, norm
from attest_mav.plausible import is_field
from attest_mav.record import Record
from attest_mav.types import Quat, Vec3


class FieldLimits:
    """How a field is judged."""

    def __init__(
        self, smoothing_s: float, strength: float, inclination: float, learning_s: float, patience_s: float
    ) -> None:
        self.smoothing_s: Final = smoothing_s
        """Time constant of the field that is compared, s."""
        self.strength: Final = strength
        """Largest distance of its strength from the reference, as a share of it."""
        self.inclination: Final = inclination
        """The same of its inclination, rad."""
        self.learning_s: Final = learning_s
        """Time constant with which the reference follows an accepted field, s."""
        self.patience_s: Final = patience_s
        """Rejected for this long (accepted time counts double against it), a field is a new reference, s."""


VQF_LIMITS: Final = FieldLimits(0.05, 0.1, radians(10.0), 20.0, 60.0)
"""Those of VQF's authors."""


@mypyc_attr(acyclic=True)
class FieldMonitor(Record):
    """The monitor after a reading."""

    def __init__(
        self,
        strength: float,
        inclination: float,
        usual_strength: float,
        usual_inclination: float,
        rejected_s: float,
        is_earths_field: bool,
    ) -> None:
        self.strength: Final = strength
        """Of the field lately, in the unit of the readings."""
        self.inclination: Final = inclination
        """The same, rad below the horizontal."""
        self.usual_strength: Final = usual_strength
        """Of the reference."""
        self.usual_inclination: Final = usual_inclination
        """Of the reference, rad."""
        self.rejected_s: Final = rejected_s
        """For how long the field has been rejected, s."""
        self.is_earths_field: Final = is_earths_field
        """Whether the last reading was accepted."""

    def without_reading(self) -> "FieldMonitor":
        """The monitor after a sample without a usable field."""
        return FieldMonitor(
            self.strength, self.inclination, self.usual_strength, self.usual_inclination, self.rejected_s, False
        )


def monitored(
    before: FieldMonitor | None, q: Quat, mag: Vec3 | None, dt_s: float, limits: FieldLimits
) -> FieldMonitor | None:
    """The monitor after one more reading at this attitude, whose heading does not matter; None before the first."""
    if mag is None or not is_field(mag):
        return None if before is None else before.without_reading()
    length = norm(mag)
    inclination_now = asin(clamp(dot(down_in_body(q), mag) / length, -1.0, 1.0))
    if before is None:
        return FieldMonitor(length, inclination_now, length, inclination_now, 0.0, True)
    share = 1.0 - exp(-dt_s / limits.smoothing_s)
    strength = before.strength + share * (length - before.strength)
    inclination = before.inclination + share * (inclination_now - before.inclination)
    return _judged(before, strength, inclination, dt_s, limits)


def _judged(
    before: FieldMonitor, strength: float, inclination: float, dt_s: float, limits: FieldLimits
) -> FieldMonitor:
    """The monitor with the field of late compared with the reference."""
    off_strength, off_inclination = strength - before.usual_strength, inclination - before.usual_inclination
    if abs(off_strength) < limits.strength * before.usual_strength and abs(off_inclination) < limits.inclination:
        share = 1.0 - exp(-dt_s / limits.learning_s)
        return FieldMonitor(
            strength,
            inclination,
            before.usual_strength + share * off_strength,
            before.usual_inclination + share * off_inclination,
            clamp(before.rejected_s - 2.0 * dt_s, 0.0, limits.patience_s),
            True,
        )
    rejected_s = before.rejected_s + dt_s
    if rejected_s < limits.patience_s:
        return FieldMonitor(strength, inclination, before.usual_strength, before.usual_inclination, rejected_s, False)
    return FieldMonitor(strength, inclination, strength, inclination, 0.0, True)

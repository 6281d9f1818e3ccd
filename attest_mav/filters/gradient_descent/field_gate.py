"""Whether the magnetometer shows the Earth's field: by its strength and its dip, against what they have been so far.

As in VQF (Laidig and Seel, Information Fusion 91, 2023). A field that was rejected for long is that of a new place, or
the first reference was wrong: it becomes the reference.
"""

from math import asin, exp, radians
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import clamp, dot, down_in_body, norm
from attest_mav.types import Quat, Vec3

SMOOTHING_S: Final = 0.05
"""Time constant of what is compared."""
STRENGTH_GATE: Final = 0.1
"""Largest distance from the reference, as a share of it."""
INCLINATION_GATE: Final = radians(10.0)
"""The same for the dip, rad."""
LEARNING_S: Final = 20.0
"""Time constant with which the reference follows a field that is believed."""
PATIENCE_S: Final = 60.0
"""Rejected for this long (time in which it was believed counts double against it), a field is a new reference."""
MAX_FIELD: Final = 1e9
"""A reading of this length or more is not a field (NaN and infinity fail the same test)."""


@mypyc_attr(acyclic=True)
class FieldMonitor:
    """What is known after a reading.

    strength, dip: of the field lately, in the unit of the readings and rad below the horizontal. usual_strength,
    usual_dip: the reference; the strength is 0 before the first reading. rejected_s: for how long. believed: whether
    the last reading was.
    """

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
        self.inclination: Final = inclination
        self.usual_strength: Final = usual_strength
        self.usual_inclination: Final = usual_inclination
        self.rejected_s: Final = rejected_s
        self.is_earths_field: Final = is_earths_field


def initial_monitor() -> FieldMonitor:
    """Before the first reading."""
    return FieldMonitor(0.0, 0.0, 0.0, 0.0, 0.0, False)


def monitored(before: FieldMonitor, q: Quat, mag: Vec3 | None, dt_s: float) -> FieldMonitor:
    """After one more reading at this attitude (its heading does not matter); without one nothing is learned."""
    length = 0.0 if mag is None else norm(mag)
    if mag is None or not 0.0 < length < MAX_FIELD:
        return FieldMonitor(
            before.strength,
            before.inclination,
            before.usual_strength,
            before.usual_inclination,
            before.rejected_s,
            False,
        )
    inclination_now = asin(clamp(dot(down_in_body(q), mag) / length, -1.0, 1.0))
    if before.usual_strength == 0.0:
        return FieldMonitor(length, inclination_now, length, inclination_now, 0.0, True)
    share = 1.0 - exp(-dt_s / SMOOTHING_S)
    strength = before.strength + share * (length - before.strength)
    inclination = before.inclination + share * (inclination_now - before.inclination)
    off_strength, off_inclination = strength - before.usual_strength, inclination - before.usual_inclination
    if abs(off_strength) < STRENGTH_GATE * before.usual_strength and abs(off_inclination) < INCLINATION_GATE:
        learning_share = 1.0 - exp(-dt_s / LEARNING_S)
        usual_strength = before.usual_strength + learning_share * off_strength
        rejected_s = clamp(before.rejected_s - 2.0 * dt_s, 0.0, PATIENCE_S)
        return FieldMonitor(
            strength,
            inclination,
            usual_strength,
            before.usual_inclination + learning_share * off_inclination,
            rejected_s,
            True,
        )
    rejected_s = before.rejected_s + dt_s
    if rejected_s < PATIENCE_S:
        return FieldMonitor(strength, inclination, before.usual_strength, before.usual_inclination, rejected_s, False)
    return FieldMonitor(strength, inclination, strength, inclination, 0.0, True)

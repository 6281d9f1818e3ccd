"""The magnetic field as evidence between the autopilot's attitude and ours, by all magnetometers of the vehicle.

A magnetometer is a device of its own: whether the gyro or the accelerometer of its message is at fault, and whether
its lane is the selected one, does not matter.
"""

from collections.abc import Mapping
from typing import Final

from attest_mav.estimation.field_evidence import FieldEvidence, FieldReading
from attest_mav.types import Quat

FOR_US: Final = 3.0
AGAINST_US: Final = 0.0
"""The field is for our attitude from evidence of the first on, until it falls below the second."""


class FieldSupport:
    """Log-likelihood ratios of the field between our attitude and one source of the autopilot's."""

    def __init__(self) -> None:
        self._compasses: Final[dict[str, FieldEvidence]] = {}
        """The evidence of each magnetometer, by the name of its inertial message."""
        self._for_us = False
        self._has_agreed = False

    def note_agreement(self) -> None:
        """Tilt and heading of both are near, with or without a reading of the field."""
        self._has_agreed = True

    def take(self, readings: Mapping[str, FieldReading], lane: str, turn: Quat, agree: bool, now_ns: int) -> None:
        """Take the newest reading of each magnetometer; those beside the attitude of another lane tell nothing.

        turn: NED rotation from this lane's attitude to the autopilot's. agree: they are near.
        """
        for name, reading in readings.items():
            if reading.lane != lane:
                continue
            evidence = self._compasses.get(name)
            if evidence is None:
                evidence = self._compasses[name] = FieldEvidence()
            evidence.take(reading, turn, agree)
        total = sum([one.ratio for one in self._compasses.values() if one.speaks(now_ns)])
        self._for_us = total > (AGAINST_US if self._for_us else FOR_US)

    def forbids(self, now_ns: int, by_heading: bool) -> bool:
        """Whether the field leaves no disagreement with ours; by_heading: the headings differ too.

        A difference of tilt alone that the field does not show needs no support of the field. Any other one needs that
        of all magnetometers together. Where the headings differ, none of them may be for the autopilot's either: one
        of two that contradict each other is wrong, and nothing tells which. Iron turns with the vehicle, so that the
        direction from before tells less and less: one that was for the autopilot's beyond doubt stays so.
        """
        speaking = [one for one in self._compasses.values() if one.speaks(now_ns)]
        if not speaking:
            return False
        if by_heading:
            return not self._for_us or any(one.has_refuted or one.ratio < -FOR_US for one in speaking)
        return not self._for_us and any(one.shows_difference for one in speaking)

    def tells_no_heading(self, lane: str) -> bool:
        """Whether the headings have never agreed, and nothing but the velocity, or iron, can have led to this lane's.

        There has been no reading of its field, or one that cannot be the Earth's. From an unknown heading the velocity
        can lead to a wrong one, off by up to half a turn, which a linear covariance does not show.
        """
        compass = self._compasses.get(lane)
        return not self._has_agreed and (compass is None or compass.is_foreign)

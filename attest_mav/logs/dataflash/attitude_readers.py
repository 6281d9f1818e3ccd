"""The readers of attitudes: ATT, AHR2, DCM and the estimators' own records, and the simulator's truth."""

from math import isfinite
from typing import Final

from attest_mav.algebra import is_finite, q_from_euler, q_unit
from attest_mav.logs.dataflash.reader import COMPONENT, SYSTEM, RecordReader
from attest_mav.logs.dataflash.units import Column
from attest_mav.mavlink.decode.attitude_readers import is_attitude
from attest_mav.samples import AttitudeSample, Sample
from attest_mav.types import AttitudeForm, AttitudeRole, Quat, Vec3
from attest_mav.vehicle_reports import EstimatorSample
from attest_mav.vehicle_settings import Estimator

ANGLES: Final = [Column(name, "deg") for name in ("Roll", "Pitch", "Yaw")]
QUATERNION: Final = [Column(f"Q{index}") for index in range(1, 5)]
ESTIMATORS: Final = {int(one): one for one in Estimator}


class EulerReader(RecordReader):
    """A record with roll, pitch and yaw; ATT since 4.0 also names the estimator that made them (AEKF)."""

    def __init__(self, source: str, role: AttitudeRole) -> None:
        super().__init__([*ANGLES, Column("AEKF")])
        self._source: Final = source
        self._role: Final = role
        self._estimator: Estimator | None = None

    def read(self, t_ns: int, numbers: list[float], texts: list[str]) -> list[Sample]:
        """One AttitudeSample, and before it an EstimatorSample where the estimator is another one."""
        euler: Vec3 = (numbers[1], numbers[2], numbers[3])
        if not is_finite(euler):
            return []
        q_nb = q_from_euler(euler[0], euler[1], euler[2])
        attitude = AttitudeSample(
            self._source, SYSTEM, COMPONENT, t_ns, t_ns, q_nb, None, self._role, AttitudeForm.EULER, euler
        )
        estimator = ESTIMATORS.get(int(numbers[4])) if isfinite(numbers[4]) else None
        if estimator is None or estimator == self._estimator:
            return [attitude]
        self._estimator = estimator
        return [EstimatorSample(self._source, SYSTEM, COMPONENT, t_ns, estimator), attitude]


class QuaternionReader(RecordReader):
    """A record with a quaternion, or before 3.6 with roll, pitch and yaw in its place (SIM)."""

    def __init__(self, source: str, role: AttitudeRole) -> None:
        super().__init__([*ANGLES, *QUATERNION])
        self._source: Final = source
        self._role: Final = role

    def read(self, t_ns: int, numbers: list[float], texts: list[str]) -> list[Sample]:
        """One AttitudeSample."""
        euler: Vec3 = (numbers[1], numbers[2], numbers[3])
        q: Quat = (numbers[4], numbers[5], numbers[6], numbers[7])
        if not isfinite(q[0]) and is_finite(euler):
            q = q_from_euler(euler[0], euler[1], euler[2])
        if not is_attitude(q):
            return []
        form = AttitudeForm.QUATERNION
        return [AttitudeSample(self._source, SYSTEM, COMPONENT, t_ns, t_ns, q_unit(q), None, self._role, form)]

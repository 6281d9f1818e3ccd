"""The readers of attitudes: ATTITUDE and its like, ATTITUDE_QUATERNION, SIM_STATE."""

from typing import Final

from attest_mav.algebra import is_finite, q_from_euler, q_norm, q_unit
from attest_mav.mavlink.decode.reader import Reader
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import Frame
from attest_mav.samples import AttitudeSample, Sample
from attest_mav.types import (
    NO_TIME,
    AttitudeForm,
    AttitudeRole,
    Quat,
    Vec3,
)


class AttitudeReader(Reader):
    """ATTITUDE, AHRS2 and SIMSTATE: roll, pitch and yaw, with or without time and rates."""

    def __init__(self, dialect: Dialect, name: str, time: str, rates: tuple[str, ...], role: AttitudeRole) -> None:
        super().__init__(name)
        self._role: Final = role
        self._has_time: Final = bool(time)
        self._has_rates: Final = bool(rates)
        names = [time] if time else []
        self._fields: Final = dialect.layout(name).pick(*names, "roll", "pitch", "yaw", *rates)

    def read(self, frame: Frame) -> list[Sample]:
        """One AttitudeSample."""
        values = self._fields.unpack(frame.payload)
        first = 1 if self._has_time else 0
        euler: Vec3 = (values[first], values[first + 1], values[first + 2])
        rates: Vec3 | None = (values[-3], values[-2], values[-1]) if self._has_rates else None
        if not is_finite(euler) or not (rates is None or is_finite(rates)):
            return self.refuse(frame, "a value is not finite")
        t_ns: int = values[0] * 1_000_000 if self._has_time else NO_TIME
        q = q_from_euler(euler[0], euler[1], euler[2])
        return [
            AttitudeSample(
                self.name,
                frame.system,
                frame.component,
                t_ns,
                frame.rx_ns,
                q,
                rates,
                self._role,
                AttitudeForm.EULER,
                euler,
            )
        ]


class QuaternionReader(Reader):
    """ATTITUDE_QUATERNION. Its q and rates are the body's; repr_offset_q is for display and is never applied."""

    def __init__(self, dialect: Dialect) -> None:
        super().__init__("ATTITUDE_QUATERNION")
        self._fields: Final = dialect.layout(self.name).pick(
            "time_boot_ms", "q1", "q2", "q3", "q4", "rollspeed", "pitchspeed", "yawspeed"
        )

    def read(self, frame: Frame) -> list[Sample]:
        """One AttitudeSample."""
        values = self._fields.unpack(frame.payload)
        q: Quat = (values[1], values[2], values[3], values[4])
        rates: Vec3 = (values[5], values[6], values[7])
        if not is_attitude(q) or not is_finite(rates):
            return self.refuse(frame, f"{q} is no attitude, or a rate is not finite")
        q = q_unit(q)
        t_ns: int = values[0] * 1_000_000
        role, form = AttitudeRole.AUTOPILOT, AttitudeForm.QUATERNION
        return [AttitudeSample(self.name, frame.system, frame.component, t_ns, frame.rx_ns, q, rates, role, form)]


class SimStateReader(Reader):
    """SIM_STATE: a simulator's truth, by its quaternion, or by roll, pitch and yaw where that is zero."""

    def __init__(self, dialect: Dialect) -> None:
        super().__init__("SIM_STATE")
        self._fields: Final = dialect.layout(self.name).pick(
            "q1", "q2", "q3", "q4", "roll", "pitch", "yaw", "xgyro", "ygyro", "zgyro"
        )

    def read(self, frame: Frame) -> list[Sample]:
        """One AttitudeSample."""
        values = self._fields.unpack(frame.payload)
        q: Quat = (values[0], values[1], values[2], values[3])
        euler: Vec3 = (values[4], values[5], values[6])
        rates: Vec3 = (values[7], values[8], values[9])
        if q == (0.0, 0.0, 0.0, 0.0) and is_finite(euler):
            q = q_from_euler(euler[0], euler[1], euler[2])
        if not is_attitude(q) or not is_finite(rates):
            return self.refuse(frame, f"{q} is no attitude, or a rate is not finite")
        role, q = AttitudeRole.TRUTH, q_unit(q)
        return [AttitudeSample(self.name, frame.system, frame.component, NO_TIME, frame.rx_ns, q, rates, role)]


def is_attitude(q: Quat) -> bool:
    """Whether q is a unit quaternion but for rounding: not zero, not NaN, not something else."""
    return 0.9 < q_norm(q) < 1.1

"""One reader for each kind of message but the inertial ones: payload to samples, in SI units and radians."""

from abc import abstractmethod
from math import cos, isfinite, nan, radians, sin
from typing import Final

from attest_mav.algebra import is_finite, q_from_euler, q_norm, q_unit
from attest_mav.mavlink.constants import (
    GPS_FIX_TYPE_3D_FIX,
    MAV_AUTOPILOT_INVALID,
    MAV_COMP_ID_AUTOPILOT1,
    MAV_LANDED_STATE_IN_AIR,
    MAV_LANDED_STATE_LANDING,
    MAV_LANDED_STATE_ON_GROUND,
    MAV_LANDED_STATE_TAKEOFF,
    MAV_MODE_FLAG_SAFETY_ARMED,
    UINT8_MAX,
    UINT16_MAX,
)
from attest_mav.mavlink.decode.boot_clock import BootClock, time_refusal
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import Frame
from attest_mav.types import (
    NO_TIME,
    AirDataSample,
    AirspeedSource,
    AttitudeForm,
    AttitudeRole,
    AttitudeSample,
    ClockSample,
    HeartbeatSample,
    LandedSample,
    PositionSample,
    Quat,
    Sample,
    Vec3,
    VehicleKind,
    VelocityOrigin,
    VelocitySample,
)

CENTI: Final = 1e-2
MILLI: Final = 1e-3

POOR_HDOP: Final = 2.5
FEW_SATELLITES: Final = 6
"""A receiver with a larger dilution of precision or fewer satellites has a poor velocity even if it does not say so."""
SIGMA_PER_HDOP: Final = 0.4
"""m/s: uncertainty of such a velocity for each unit of the dilution."""

KINDS: Final = {
    **dict.fromkeys((1, 19, 20, 21, 22, 23, 24, 25), VehicleKind.WING),
    **dict.fromkeys((2, 3, 4, 13, 14, 15, 29, 35, 43), VehicleKind.ROTARY),
    **dict.fromkeys((10, 11), VehicleKind.SURFACE),
}
"""MAV_TYPE to how such a vehicle moves: aeroplanes and the VTOL kinds; copters; ground vehicles and surface boats."""

LANDED_IN_AIR: Final = (MAV_LANDED_STATE_IN_AIR, MAV_LANDED_STATE_TAKEOFF, MAV_LANDED_STATE_LANDING)


class Reader:
    """Reads one kind of message. refusal: why the last one gave no sample, or empty; refused: how many gave none."""

    def __init__(self, name: str) -> None:
        self.name: Final = name
        self.refusal = ""
        self.refused = 0

    @abstractmethod
    def read(self, frame: Frame) -> list[Sample]:
        """The samples in one frame of this kind."""

    def refuse(self, frame: Frame, reason: str) -> list[Sample]:
        """No samples, and the reason."""
        self.refused += 1
        self.refusal = f"{self.name} of system {frame.system}: {reason}"
        return []


class HeartbeatReader(Reader):
    """HEARTBEAT; keeps the MAV_AUTOPILOT of every system that has one.

    The autopilot component's own word counts most: other components of a system may claim another autopilot.
    """

    def __init__(self, dialect: Dialect) -> None:
        super().__init__("HEARTBEAT")
        self.autopilots: Final[dict[int, int]] = {}
        self._fields: Final = dialect.layout(self.name).pick(
            "custom_mode", "type", "autopilot", "base_mode", "system_status"
        )

    def read(self, frame: Frame) -> list[Sample]:
        """One HeartbeatSample."""
        mode, vehicle_type, autopilot, base_mode, status = self._fields.unpack(frame.payload)
        if autopilot != MAV_AUTOPILOT_INVALID and (
            frame.component == MAV_COMP_ID_AUTOPILOT1 or frame.system not in self.autopilots
        ):
            self.autopilots[frame.system] = autopilot
        armed = base_mode & MAV_MODE_FLAG_SAFETY_ARMED != 0
        return [
            HeartbeatSample(
                self.name,
                frame.system,
                frame.component,
                frame.rx_ns,
                vehicle_type,
                autopilot,
                armed,
                status,
                KINDS.get(vehicle_type, VehicleKind.UNKNOWN),
                mode,
            )
        ]


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
        if q == (0.0, 0.0, 0.0, 0.0):
            q = q_from_euler(euler[0], euler[1], euler[2])
        if not is_attitude(q) or not is_finite(rates):
            return self.refuse(frame, f"{q} is no attitude, or a rate is not finite")
        role, q = AttitudeRole.TRUTH, q_unit(q)
        return [AttitudeSample(self.name, frame.system, frame.component, NO_TIME, frame.rx_ns, q, rates, role)]


class GpsReader(Reader):
    """GPS_RAW_INT with a 3-D fix: velocity over ground from speed and course, where both are known, and position."""

    def __init__(self, dialect: Dialect, boot_clock: BootClock) -> None:
        super().__init__("GPS_RAW_INT")
        self._boot_clock: Final = boot_clock
        self._fields: Final = dialect.layout(self.name).pick(
            "time_usec", "lat", "lon", "alt", "eph", "vel", "cog", "fix_type", "satellites_visible", "vel_acc"
        )

    def read(self, frame: Frame) -> list[Sample]:
        """A PositionSample and, where speed and course are known, a VelocitySample before it."""
        time, lat, lon, alt, eph, vel, cog, fix, satellites, vel_acc = self._fields.unpack(frame.payload)
        if fix < GPS_FIX_TYPE_3D_FIX:
            return self.refuse(frame, f"no 3-D fix (fix type {fix})")
        t_ns = self._boot_clock.since_boot_ns(frame.system, time)
        if t_ns < 0:
            return self.refuse(frame, time_refusal(t_ns, time))
        samples: list[Sample] = []
        if vel != UINT16_MAX and (cog != UINT16_MAX or vel == 0):
            speed: float = vel * CENTI
            course = radians(cog * CENTI)
            v_ned = (speed * cos(course), speed * sin(course), 0.0)
            samples.append(
                VelocitySample(
                    self.name,
                    frame.system,
                    frame.component,
                    t_ns,
                    frame.rx_ns,
                    v_ned,
                    False,
                    VelocityOrigin.RECEIVER,
                    receiver_sigma(vel_acc * MILLI, eph, satellites),
                )
            )
        samples.append(
            PositionSample(
                self.name, frame.system, frame.component, t_ns, frame.rx_ns, lat * 1e-7, lon * 1e-7, alt * 1e-3
            )
        )
        return samples


def receiver_sigma(reported: float, eph: int, satellites: int) -> float | None:
    """Uncertainty of a receiver's velocity, m/s an axis; None where nothing speaks against a good one.

    reported: vel_acc, m/s, 0 where it is not known. eph: dilution of precision times 100.
    """
    hdop = eph * CENTI if eph != UINT16_MAX else 0.0
    few = satellites != UINT8_MAX and 0 < satellites < FEW_SATELLITES
    poor = SIGMA_PER_HDOP * max(hdop, POOR_HDOP) if hdop > POOR_HDOP or few else 0.0
    sigma = max(reported, poor)
    return sigma if sigma > 0.0 else None


class LandedReader(Reader):
    """EXTENDED_SYS_STATE: on the ground, or not; an undefined state tells nothing."""

    def __init__(self, dialect: Dialect) -> None:
        super().__init__("EXTENDED_SYS_STATE")
        self._fields: Final = dialect.layout(self.name).pick("landed_state")

    def read(self, frame: Frame) -> list[Sample]:
        """One LandedSample."""
        (state,) = self._fields.unpack(frame.payload)
        on_ground = state == MAV_LANDED_STATE_ON_GROUND
        if not (on_ground or state in LANDED_IN_AIR):
            return []
        return [LandedSample(self.name, frame.system, frame.component, frame.rx_ns, on_ground)]


class VelocityReader(Reader):
    """GLOBAL_POSITION_INT (cm/s) and LOCAL_POSITION_NED (m/s): the autopilot's own velocity estimate."""

    def __init__(self, dialect: Dialect, name: str, unit: float) -> None:
        super().__init__(name)
        self._unit: Final = unit
        self._fields: Final = dialect.layout(name).pick("time_boot_ms", "vx", "vy", "vz")

    def read(self, frame: Frame) -> list[Sample]:
        """One VelocitySample."""
        time, vx, vy, vz = self._fields.unpack(frame.payload)
        unit = self._unit
        v_ned: Vec3 = (vx * unit, vy * unit, vz * unit)
        if not is_finite(v_ned):
            return self.refuse(frame, "a velocity is not finite")
        t_ns: int = time * 1_000_000
        origin = VelocityOrigin.ESTIMATOR
        return [VelocitySample(self.name, frame.system, frame.component, t_ns, frame.rx_ns, v_ned, True, origin)]


class HudReader(Reader):
    """VFR_HUD: airspeed, groundspeed, climb; NaN for one that the autopilot does not know."""

    def __init__(self, dialect: Dialect) -> None:
        super().__init__("VFR_HUD")
        self._fields: Final = dialect.layout(self.name).pick("airspeed", "groundspeed", "climb")

    def read(self, frame: Frame) -> list[Sample]:
        """One AirDataSample."""
        values = self._fields.unpack(frame.payload)
        airspeed, groundspeed, climb = finite_or_nan(values[0]), finite_or_nan(values[1]), finite_or_nan(values[2])
        if not (isfinite(airspeed) or isfinite(groundspeed) or isfinite(climb)):
            return self.refuse(frame, "none of its speeds is finite")
        return [
            AirDataSample(
                self.name,
                frame.system,
                frame.component,
                frame.rx_ns,
                airspeed,
                groundspeed,
                climb,
                AirspeedSource.REPORTED,
            )
        ]


class ClockReader(Reader):
    """SYSTEM_TIME, from which the boot clock learns."""

    def __init__(self, dialect: Dialect, boot_clock: BootClock) -> None:
        super().__init__("SYSTEM_TIME")
        self._boot_clock: Final = boot_clock
        self._fields: Final = dialect.layout(self.name).pick("time_unix_usec", "time_boot_ms")

    def read(self, frame: Frame) -> list[Sample]:
        """One ClockSample."""
        unix_us, boot_ms = self._fields.unpack(frame.payload)
        self._boot_clock.learn(frame.system, unix_us, boot_ms)
        t_ns: int = boot_ms * 1_000_000
        return [ClockSample(self.name, frame.system, frame.component, t_ns, frame.rx_ns, unix_us)]


def finite_or_nan(value: float) -> float:
    """The value, NaN for an infinite one too."""
    return value if isfinite(value) else nan


def is_attitude(q: Quat) -> bool:
    """Whether q is a unit quaternion but for rounding: not zero, not NaN, not something else."""
    return 0.9 < q_norm(q) < 1.1

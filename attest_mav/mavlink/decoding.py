"""Frames to samples: SI units, radians, body FRD and NED. All unit conversion of the package is here and below.

What an inertial message means depends on the autopilot that sent it (``units``), so the inertial messages of a system
are refused until a HEARTBEAT has told its MAV_AUTOPILOT. Refusals are results, not errors: counted, with a reason.
"""

from abc import abstractmethod
from math import cos, isfinite, radians, sin
from typing import Final

from attest_mav.algebra import is_finite, q_from_euler, q_mul, q_norm, q_unit, rotate_back
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.frame import Frame
from attest_mav.mavlink.imu import ImuLane
from attest_mav.mavlink.units import INVALID, RawScales, unit_row
from attest_mav.types import (
    NO_TIME,
    AirDataSample,
    AttitudeSample,
    ClockSample,
    HeartbeatSample,
    PositionSample,
    Quat,
    Sample,
    Vec3,
    VelocitySample,
)

ARMED: Final = 128
"""MAV_MODE_FLAG_SAFETY_ARMED in base_mode."""

AUTOPILOT_COMPONENT: Final = 1
"""MAV_COMP_ID_AUTOPILOT1."""

FIX_3D: Final = 3
"""GPS_FIX_TYPE_3D_FIX; everything above is better."""

NOT_KNOWN_U16: Final = 65535
"""What GPS_RAW_INT writes into a uint16 field it does not know."""

UPDATED_ACCEL: Final = 0x007
UPDATED_GYRO: Final = 0x038
UPDATED_MAG: Final = 0x1C0
"""Bits of HIGHRES_IMU.fields_updated; a group is new when all three of its bits are set."""

LATEST_US: Final = 1 << 53
"""Microseconds that no vehicle reaches (285 years); less keeps nanoseconds within 64 bits."""

_CENTI: Final = 1e-2


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
        self._fields: Final = dialect.layout(self.name).pick("type", "autopilot", "base_mode", "system_status")

    def read(self, frame: Frame) -> list[Sample]:
        """One HeartbeatSample."""
        vehicle_type, autopilot, base_mode, status = self._fields.unpack(frame.payload)
        if autopilot != INVALID and (frame.component == AUTOPILOT_COMPONENT or frame.system not in self.autopilots):
            self.autopilots[frame.system] = autopilot
        armed = base_mode & ARMED != 0
        return [
            HeartbeatSample(
                self.name, frame.system, frame.component, frame.rx_ns, vehicle_type, autopilot, armed, status
            )
        ]


class ImuReader(Reader):
    """RAW_IMU, SCALED_IMU, SCALED_IMU2, SCALED_IMU3 and HIGHRES_IMU: one ImuLane for each sensor of each sender.

    RAW_IMU and HIGHRES_IMU carry the sensor's number; above 0 it becomes part of the source: ``RAW_IMU#1``.
    """

    def __init__(self, dialect: Dialect, name: str, autopilots: dict[int, int], raw_scales: RawScales | None) -> None:
        super().__init__(name)
        self.lanes: Final[dict[int, ImuLane]] = {}
        self._autopilots: Final = autopilots
        self._raw_scales: Final = raw_scales
        layout = dialect.layout(name)
        time = "time_usec" if "time_usec" in layout.fields else "time_boot_ms"
        vectors = [f"{axis}{sensor}" for sensor in ("acc", "gyro", "mag") for axis in "xyz"]
        tail = [field for field in ("fields_updated", "id") if field in layout.fields]
        self._fields: Final = layout.pick(time, *vectors, *tail)
        self._time_unit_ns: Final = 1000 if time == "time_usec" else 1_000_000
        self._has_id: Final = "id" in tail
        self._has_updates: Final = "fields_updated" in tail

    def read(self, frame: Frame) -> list[Sample]:
        """The samples of one reading, and of earlier ones that the start-up checks had held back."""
        values = self._fields.unpack(frame.payload)
        number: int = values[-1] if self._has_id else 0
        field_sent = True
        if self._has_updates:
            updated: int = values[10]
            if updated & UPDATED_ACCEL != UPDATED_ACCEL or updated & UPDATED_GYRO != UPDATED_GYRO:
                return self.refuse(frame, "fields_updated says that accelerometer or gyro are not new")
            field_sent = updated & UPDATED_MAG == UPDATED_MAG
        time: int = values[0]
        if time >= LATEST_US:
            return self.refuse(frame, f"its time is impossible ({time})")
        lane = self.lanes.get((frame.system << 16) | (frame.component << 8) | number)
        if lane is None:
            lane = self._open_lane(frame, number)
            if lane is None:
                return []
        accel: Vec3 = (values[1], values[2], values[3])
        gyro: Vec3 = (values[4], values[5], values[6])
        field: Vec3 = (values[7], values[8], values[9])
        return lane.accept(time * self._time_unit_ns, frame.rx_ns, accel, gyro, field, field_sent)

    def _open_lane(self, frame: Frame, number: int) -> ImuLane | None:
        """The lane of a sensor seen for the first time; None, and a refusal, while its units are not known."""
        autopilot = self._autopilots.get(frame.system)
        if autopilot is None:
            self.refuse(frame, "its autopilot is not known yet (no HEARTBEAT so far), so its units are not either")
            return None
        row = unit_row(self.name, autopilot, self._raw_scales)
        if row is None:
            self.refuse(
                frame,
                f"autopilot {autopilot} sends true raw values, whose units nobody knows: configure the scales of "
                "RAW_IMU, or use SCALED_IMU or HIGHRES_IMU",
            )
            return None
        self.refusal = ""
        source = f"{self.name}#{number}" if number > 0 else self.name
        lane = ImuLane(source, frame.system, frame.component, row)
        self.lanes[(frame.system << 16) | (frame.component << 8) | number] = lane
        return lane


class AttitudeReader(Reader):
    """ATTITUDE, AHRS2 and SIMSTATE: roll, pitch and yaw, with or without time and rates."""

    def __init__(self, dialect: Dialect, name: str, time: str, rates: tuple[str, ...]) -> None:
        super().__init__(name)
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
        return [AttitudeSample(self.name, frame.system, frame.component, t_ns, frame.rx_ns, q, rates)]


class QuaternionReader(Reader):
    """ATTITUDE_QUATERNION. repr_offset_q, where it is set, turns attitude and rates into the body frame of display."""

    def __init__(self, dialect: Dialect) -> None:
        super().__init__("ATTITUDE_QUATERNION")
        self._fields: Final = dialect.layout(self.name).pick(
            "time_boot_ms", "q1", "q2", "q3", "q4", "rollspeed", "pitchspeed", "yawspeed", "repr_offset_q"
        )

    def read(self, frame: Frame) -> list[Sample]:
        """One AttitudeSample."""
        values = self._fields.unpack(frame.payload)
        q: Quat = (values[1], values[2], values[3], values[4])
        rates: Vec3 = (values[5], values[6], values[7])
        offset: Quat = (values[8], values[9], values[10], values[11])
        if not is_attitude(q) or not is_finite(rates):
            return self.refuse(frame, f"{q} is no attitude, or a rate is not finite")
        q = q_unit(q)
        if is_attitude(offset):
            offset = q_unit(offset)
            q = q_mul(q, offset)
            rates = rotate_back(offset, rates)
        t_ns: int = values[0] * 1_000_000
        return [AttitudeSample(self.name, frame.system, frame.component, t_ns, frame.rx_ns, q, rates)]


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
        return [AttitudeSample(self.name, frame.system, frame.component, NO_TIME, frame.rx_ns, q_unit(q), rates)]


class GpsReader(Reader):
    """GPS_RAW_INT with a 3-D fix: velocity over ground from speed and course, where both are known, and position."""

    def __init__(self, dialect: Dialect) -> None:
        super().__init__("GPS_RAW_INT")
        self._fields: Final = dialect.layout(self.name).pick("time_usec", "lat", "lon", "alt", "vel", "cog", "fix_type")

    def read(self, frame: Frame) -> list[Sample]:
        """A PositionSample and, where speed and course are known, a VelocitySample before it."""
        time, lat, lon, alt, vel, cog, fix = self._fields.unpack(frame.payload)
        if fix < FIX_3D:
            return self.refuse(frame, f"no 3-D fix (fix type {fix})")
        if time >= LATEST_US:
            return self.refuse(frame, f"its time is impossible ({time})")
        t_ns: int = time * 1000
        samples: list[Sample] = []
        if vel != NOT_KNOWN_U16 and (cog != NOT_KNOWN_U16 or vel == 0):
            speed: float = vel * _CENTI
            course = radians(cog * _CENTI)
            v_ned = (speed * cos(course), speed * sin(course), 0.0)
            samples.append(VelocitySample(self.name, frame.system, frame.component, t_ns, frame.rx_ns, v_ned, False))
        samples.append(
            PositionSample(
                self.name, frame.system, frame.component, t_ns, frame.rx_ns, lat * 1e-7, lon * 1e-7, alt * 1e-3
            )
        )
        return samples


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
        return [VelocitySample(self.name, frame.system, frame.component, t_ns, frame.rx_ns, v_ned, True)]


class HudReader(Reader):
    """VFR_HUD: airspeed, groundspeed, climb."""

    def __init__(self, dialect: Dialect) -> None:
        super().__init__("VFR_HUD")
        self._fields: Final = dialect.layout(self.name).pick("airspeed", "groundspeed", "climb")

    def read(self, frame: Frame) -> list[Sample]:
        """One AirDataSample."""
        airspeed, groundspeed, climb = self._fields.unpack(frame.payload)
        if not isfinite(airspeed + groundspeed + climb):
            return self.refuse(frame, "a speed is not finite")
        return [AirDataSample(self.name, frame.system, frame.component, frame.rx_ns, airspeed, groundspeed, climb)]


class ClockReader(Reader):
    """SYSTEM_TIME."""

    def __init__(self, dialect: Dialect) -> None:
        super().__init__("SYSTEM_TIME")
        self._fields: Final = dialect.layout(self.name).pick("time_unix_usec", "time_boot_ms")

    def read(self, frame: Frame) -> list[Sample]:
        """One ClockSample."""
        unix_us, boot_ms = self._fields.unpack(frame.payload)
        t_ns: int = boot_ms * 1_000_000
        return [ClockSample(self.name, frame.system, frame.component, t_ns, frame.rx_ns, unix_us)]


class Decoder:
    """Turns frames into samples; learns on the way which autopilot each system has.

    wanted: the ids of the messages it understands, for the framer. raw_scales: the meaning of RAW_IMU on autopilots
    other than ArduPilot; None refuses it there.
    """

    def __init__(self, dialect: Dialect, raw_scales: RawScales | None = None) -> None:
        heartbeat = HeartbeatReader(dialect)
        self.autopilots: Final = heartbeat.autopilots
        """MAV_AUTOPILOT by system id, as learned so far."""
        self._imu: Final = [
            ImuReader(dialect, name, heartbeat.autopilots, raw_scales)
            for name in ("RAW_IMU", "SCALED_IMU", "SCALED_IMU2", "SCALED_IMU3", "HIGHRES_IMU")
        ]
        others: list[Reader] = [
            heartbeat,
            AttitudeReader(dialect, "ATTITUDE", "time_boot_ms", ("rollspeed", "pitchspeed", "yawspeed")),
            AttitudeReader(dialect, "AHRS2", "", ()),
            AttitudeReader(dialect, "SIMSTATE", "", ("xgyro", "ygyro", "zgyro")),
            QuaternionReader(dialect),
            SimStateReader(dialect),
            GpsReader(dialect),
            VelocityReader(dialect, "GLOBAL_POSITION_INT", _CENTI),
            VelocityReader(dialect, "LOCAL_POSITION_NED", 1.0),
            HudReader(dialect),
            ClockReader(dialect),
        ]
        self._readers: Final[dict[int, Reader]] = {dialect.id_of(reader.name): reader for reader in others}
        for imu in self._imu:
            self._readers[dialect.id_of(imu.name)] = imu
        self.wanted: Final = frozenset(self._readers)

    def decode(self, frame: Frame) -> list[Sample]:
        """The samples in a frame; none for a message it does not understand or refuses."""
        reader = self._readers.get(frame.message_id)
        if reader is None:
            return []
        samples = reader.read(frame)
        if samples:
            reader.refusal = ""
        return samples

    @property
    def refusals(self) -> dict[str, str]:
        """Why a source gives no samples at present, by source; ``RAW_IMU magnetometer`` for a missing field alone."""
        reasons = {reader.name: reader.refusal for reader in self._readers.values() if reader.refusal}
        for lane in self._lanes():
            if lane.refusal:
                reasons[lane.source] = lane.refusal
            if lane.field_refusal:
                reasons[f"{lane.source} magnetometer"] = lane.field_refusal
        return reasons

    @property
    def refused(self) -> dict[str, int]:
        """How many messages gave no sample, by source."""
        counts = {reader.name: reader.refused for reader in self._readers.values() if reader.refused}
        for lane in self._lanes():
            if lane.refused:
                counts[lane.source] = counts.get(lane.source, 0) + lane.refused
        return counts

    @property
    def notes(self) -> dict[str, str]:
        """What a user should know about a source, by source."""
        return {lane.source: lane.note for lane in self._lanes() if lane.note}

    @property
    def independent(self) -> dict[str, bool]:
        """Whether an inertial source owes nothing to the autopilot's estimator, by source."""
        return {lane.source: lane.row.independent for lane in self._lanes()}

    def _lanes(self) -> list[ImuLane]:
        return [lane for reader in self._imu for lane in reader.lanes.values()]


def is_attitude(q: Quat) -> bool:
    """Whether q is a unit quaternion but for rounding: not zero, not NaN, not something else."""
    return 0.9 < q_norm(q) < 1.1

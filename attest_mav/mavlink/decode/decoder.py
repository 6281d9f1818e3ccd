"""Frames to samples: SI units, radians, body FRD and NED. All unit conversion of the package is here and below.

What an inertial message means depends on the autopilot that sent it (``units``), so the inertial messages of a system
are refused until a HEARTBEAT has given its MAV_AUTOPILOT. Refusals are results, not errors: counted, with a reason.
"""

from typing import Final

from attest_mav.mavlink.constants import INERTIAL_MESSAGES
from attest_mav.mavlink.decode.attitude_readers import AttitudeReader, QuaternionReader, SimStateReader
from attest_mav.mavlink.decode.autopilot_parameters import ParameterReader
from attest_mav.mavlink.decode.boot_clock import BootClock
from attest_mav.mavlink.decode.firmware import AutopilotVersionReader, StatusTextReader
from attest_mav.mavlink.decode.imu_reader import ImuReader
from attest_mav.mavlink.decode.motion_readers import CENTI, GpsReader, HudReader, VelocityReader
from attest_mav.mavlink.decode.reader import Reader
from attest_mav.mavlink.decode.self_report_readers import EkfStatusReader, EstimatorStatusReader, SensorHealthReader
from attest_mav.mavlink.decode.sensor_reader import SensorReader
from attest_mav.mavlink.decode.units import RawScales
from attest_mav.mavlink.decode.vehicle_readers import ClockReader, HeartbeatReader, LandedReader
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import Frame
from attest_mav.samples import Sample
from attest_mav.types import AttitudeRole

MAGNETOMETER: Final = " magnetometer"
"""Marks the refusal of a message's field alone."""


def of_message(name: str) -> tuple[str, str]:
    """The keys of ``Decoder.refusals`` that are about the message of that name, and not about one like it."""
    return (name, name + MAGNETOMETER)


class Decoder:
    """Turns frames into samples; learns on the way which autopilot each system has.

    wanted: the ids of the messages it understands, for the framer. raw_scales: the meaning of RAW_IMU on autopilots
    other than ArduPilot; None refuses it there.
    """

    def __init__(self, dialect: Dialect, raw_scales: RawScales | None = None) -> None:
        heartbeat = HeartbeatReader(dialect)
        boot_clock = BootClock()
        self.autopilots: Final = heartbeat.autopilots
        """MAV_AUTOPILOT by system id, as learned so far."""
        self._imu: Final = [
            ImuReader(dialect, name, heartbeat.autopilots, boot_clock, raw_scales) for name in INERTIAL_MESSAGES
        ]
        others: list[Reader] = [
            heartbeat,
            AttitudeReader(
                dialect, "ATTITUDE", "time_boot_ms", ("rollspeed", "pitchspeed", "yawspeed"), AttitudeRole.AUTOPILOT
            ),
            AttitudeReader(dialect, "AHRS2", "", (), AttitudeRole.SECONDARY),
            AttitudeReader(dialect, "AHRS3", "", (), AttitudeRole.SECONDARY),
            AttitudeReader(dialect, "SIMSTATE", "", ("xgyro", "ygyro", "zgyro"), AttitudeRole.TRUTH),
            QuaternionReader(dialect),
            SimStateReader(dialect),
            GpsReader(dialect, boot_clock),
            VelocityReader(dialect, "GLOBAL_POSITION_INT", CENTI),
            VelocityReader(dialect, "LOCAL_POSITION_NED", 1.0),
            HudReader(dialect),
            LandedReader(dialect),
            ClockReader(dialect, boot_clock),
            ParameterReader(dialect),
            AutopilotVersionReader(dialect),
            StatusTextReader(dialect),
            EkfStatusReader(dialect),
            EstimatorStatusReader(dialect),
            SensorHealthReader(dialect),
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
        for sensor in self._sensors():
            if sensor.refusal:
                reasons[sensor.source] = sensor.refusal
            if sensor.field_refusal:
                reasons[sensor.source + MAGNETOMETER] = sensor.field_refusal
        return reasons

    @property
    def refused(self) -> dict[str, int]:
        """How many messages gave no sample, by source."""
        counts = {reader.name: reader.refused for reader in self._readers.values() if reader.refused}
        for sensor in self._sensors():
            if sensor.refused:
                counts[sensor.source] = counts.get(sensor.source, 0) + sensor.refused
        return counts

    @property
    def notes(self) -> dict[str, str]:
        """What a user should know about a source, by source."""
        return {sensor.source: sensor.note for sensor in self._sensors() if sensor.note}

    @property
    def independent(self) -> dict[str, bool]:
        """Whether an inertial source owes nothing to the autopilot's estimator, by source."""
        return {sensor.source: sensor.row.independent for sensor in self._sensors()}

    def _sensors(self) -> list[SensorReader]:
        return [sensor for reader in self._imu for sensor in reader.sensors.values()]

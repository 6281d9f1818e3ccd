"""The readers of the second pass: those of the plan's streams, and of all that aids a filter or tells a frame."""

from collections.abc import Mapping
from typing import Final

from attest_mav.estimation.body_frames import CORE_QUATERNIONS
from attest_mav.logs.dataflash.attitude_readers import EulerReader, QuaternionReader
from attest_mav.logs.dataflash.error_readers import ErrorReader
from attest_mav.logs.dataflash.motion_readers import Accuracy, AccuracyReader, AirspeedReader, GpsReader, OriginReader
from attest_mav.logs.dataflash.reader import COMPONENT, SYSTEM, RecordReader
from attest_mav.logs.dataflash.roles import DATAFLASH_ROLES
from attest_mav.logs.dataflash.sensor_readers import Compass, ImuReader, MagReader
from attest_mav.logs.dataflash.streams import SENSORS
from attest_mav.logs.dataflash.survey import Survey
from attest_mav.logs.dataflash.vehicle_readers import (
    ArmReader,
    EstimatorReader,
    EventReader,
    ModeReader,
    ParameterReader,
    TextReader,
    VersionReader,
)
from attest_mav.logs.source import Plan
from attest_mav.mavlink.decode.sensor_reader import SensorReader
from attest_mav.mavlink.decode.units import DATAFLASH_IMU
from attest_mav.types import AttitudeRole


class FlightReaders:
    """All readers for a plan, with the vehicle as the survey found it at the begin. counts: records by stream."""

    def __init__(self, plan: Plan, survey: Survey, counts: Mapping[str, int]) -> None:
        self.readers: Final[dict[str, RecordReader]] = {}
        """By the names of their streams."""
        self.sensors: Final[dict[str, SensorReader]] = {}
        """The inertial sensors of the plan, by the same names."""
        compasses = {name: Compass() for name in SENSORS["MAG"]}
        for name in (plan.imu, *plan.other_sensors):
            self.sensors[name] = SensorReader(name, SYSTEM, COMPONENT, DATAFLASH_IMU)
            compass = compass_of(name, counts)
            self.readers[name] = ImuReader(self.sensors[name], compasses[compass])
            self.readers[compass] = MagReader(compasses[compass])
        for name in plan.messages.difference(self.sensors):
            self.readers[name] = attitude_reader(name)
        self._add_motion(survey)
        self._add_vehicle(survey)

    def _add_motion(self, survey: Survey) -> None:
        accuracy = Accuracy()
        receiver = survey.receiver
        self.readers[receiver] = GpsReader(receiver, accuracy)
        self.readers[SENSORS["GPA"][SENSORS["GPS"].index(receiver)]] = AccuracyReader(accuracy)
        self.readers["ARSP"] = AirspeedReader("ARSP")
        if not survey.facts.velocities:
            self.readers["ORGN"] = OriginReader("ORGN")

    def _add_vehicle(self, survey: Survey) -> None:
        state = survey.begin()
        self.readers["MODE"] = ModeReader(state)
        self.readers["EV"] = EventReader(state)
        self.readers["ARM"] = ArmReader("ARM", "ArmState", state)
        self.readers["STAT"] = ArmReader("STAT", "Armed", state)
        self.readers["PARM"] = ParameterReader()
        self.readers["MSG"] = TextReader()
        self.readers["VER"] = VersionReader()
        self.readers["ERR"] = ErrorReader()
        for name in ("XKF4", "NKF4"):
            self.readers[name] = EstimatorReader(name)
        self.readers.setdefault("AHR2", attitude_reader("AHR2"))


def compass_of(imu: str, counts: Mapping[str, int]) -> str:
    """The compass that goes with an inertial sensor: that with the same number, else the first one."""
    number = SENSORS["IMU"].index(imu)
    compasses = SENSORS["MAG"]
    return compasses[number] if number < len(compasses) and counts.get(compasses[number]) else compasses[0]


def attitude_reader(name: str) -> RecordReader:
    """The reader of a stream of attitudes."""
    if name in DATAFLASH_ROLES.truth:
        return QuaternionReader(name, AttitudeRole.TRUTH)
    if name in CORE_QUATERNIONS:
        return QuaternionReader(name, AttitudeRole.SECONDARY)
    return EulerReader(name, AttitudeRole.AUTOPILOT if name in DATAFLASH_ROLES.autopilot else AttitudeRole.SECONDARY)

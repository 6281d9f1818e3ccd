"""Parameters of autopilots that carry a setting of the vehicle (``Setting``): their names, units and plausible values.

ArduPilot sends every parameter as a float. PX4 sends an integer one bit by bit in the place of the float.

PX4's IMU_GYRO_CUTOFF is left out. By PX4's documentation it filters the input of the controllers, not that of the
estimators. The inertial messages carry the input of the estimators: means over some milliseconds, without a low-pass
that would need a correction.
"""

from math import nan, pi
from typing import Final

from attest_mav.mavlink.constants import MAV_AUTOPILOT_ARDUPILOTMEGA as ARDUPILOT
from attest_mav.mavlink.constants import MAV_AUTOPILOT_PX4 as PX4
from attest_mav.mavlink.constants import MAV_PARAM_TYPE_INT32, UINT16_MAX
from attest_mav.mavlink.decode.reader import Reader
from attest_mav.mavlink.decode.vehicle_kinds import vehicle_kind
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import Frame
from attest_mav.record import Record
from attest_mav.samples import Sample
from attest_mav.types import VehicleKind
from attest_mav.vehicle_reports import ParameterSample
from attest_mav.vehicle_settings import ACCELEROMETERS, MAGNETOMETERS, SensorSettings, Setting, VehicleSettings

DEGREE: Final = pi / 180.0
WORD: Final = float(1 << 31)
"""Above the largest bit field."""
LARGEST_OFFSET: Final = 100.0
"""m/s^2 or gauss: of a sensor."""


class Parameter(Record):
    """One parameter. ``autopilot``: MAV_AUTOPILOT.

    unit: one unit of the parameter in units of the setting. low, high: plausible range besides 0, in the parameter's
    unit. zero_is_default: 0 stands for a value that the autopilot does not send. planes_only: other vehicles are not
    asked for it.
    """

    def __init__(
        self,
        name: str,
        autopilot: int,
        setting: Setting,
        unit: float,
        low: float,
        high: float,
        zero_is_default: bool = False,
        planes_only: bool = False,
    ) -> None:
        self.name: Final = name
        self.autopilot: Final = autopilot
        self.setting: Final = setting
        self.unit: Final = unit
        self.low: Final = low
        self.high: Final = high
        self.zero_is_default: Final = zero_is_default
        self.planes_only: Final = planes_only

    def value(self, number: float) -> float | None:
        """The setting for a number of the parameter: NaN for the autopilot's default, None for an implausible one."""
        if number == 0.0:
            return nan if self.zero_is_default else 0.0
        return number * self.unit if self.low <= number <= self.high else None


def _of_planes(name: str, setting: Setting, unit: float, low: float, high: float) -> Parameter:
    """A parameter that only ArduPilot's planes have."""
    return Parameter(name, ARDUPILOT, setting, unit, low, high, planes_only=True)


def _of_sensor(autopilot: int, sensor: SensorSettings, device: str, offset: str, unit: float) -> list[Parameter]:
    """The parameters of one sensor. offset: their name with AXIS for the axis. unit: below 0 for one that is added."""
    parameters = [Parameter(device, autopilot, sensor.device, 1.0, -WORD, WORD)]
    largest = LARGEST_OFFSET / abs(unit)
    for axis, setting in zip("XYZ", sensor.offset, strict=True):
        parameters.append(Parameter(offset.replace("AXIS", axis), autopilot, setting, unit, -largest, largest))
    return parameters


def _of_sensors() -> list[Parameter]:
    """The parameters of all sensors. ArduPilot adds the offset of a compass, in milligauss; PX4 counts from 0."""
    parameters: list[Parameter] = []
    for place in range(len(ACCELEROMETERS)):
        accel, mag, number = ACCELEROMETERS[place], MAGNETOMETERS[place], "" if place == 0 else str(place + 1)
        parameters += _of_sensor(ARDUPILOT, accel, f"INS_ACC{number}_ID", f"INS_ACC{number}OFFS_AXIS", 1.0)
        parameters += _of_sensor(ARDUPILOT, mag, f"COMPASS_DEV_ID{number}", f"COMPASS_OFS{number}_AXIS", -1e-3)
        parameters += _of_sensor(PX4, accel, f"CAL_ACC{place}_ID", f"CAL_ACC{place}_AXISOFF", 1.0)
        parameters += _of_sensor(PX4, mag, f"CAL_MAG{place}_ID", f"CAL_MAG{place}_AXISOFF", 1.0)
    return parameters


PARAMETERS: Final = (
    Parameter("INS_GYRO_FILTER", ARDUPILOT, Setting.LOW_PASS_HZ, 1.0, 1.0, 1000.0),
    Parameter("INS_ACCEL_FILTER", ARDUPILOT, Setting.ACCEL_LOW_PASS_HZ, 1.0, 1.0, 1000.0),
    Parameter("GPS1_DELAY_MS", ARDUPILOT, Setting.FIX_DELAY_S, 1e-3, 0.0, 1000.0, zero_is_default=True),
    Parameter("GPS_DELAY_MS", ARDUPILOT, Setting.FIX_DELAY_S, 1e-3, 0.0, 1000.0, zero_is_default=True),
    Parameter("EKF2_GPS_DELAY", PX4, Setting.FIX_DELAY_S, 1e-3, 0.0, 1000.0),
    Parameter("SENS_GPS0_DELAY", PX4, Setting.FIX_DELAY_S, 1e-3, 0.0, 1000.0),
    Parameter("AHRS_TRIM_X", ARDUPILOT, Setting.TRIM_X, 1.0, -pi, pi),
    Parameter("AHRS_TRIM_Y", ARDUPILOT, Setting.TRIM_Y, 1.0, -pi, pi),
    Parameter("AHRS_TRIM_Z", ARDUPILOT, Setting.TRIM_Z, 1.0, -pi, pi),
    Parameter("AHRS_EKF_TYPE", ARDUPILOT, Setting.ESTIMATOR, 1.0, 1.0, 11.0),
    Parameter("COMPASS_DEC", ARDUPILOT, Setting.DECLINATION, 1.0, -pi, pi),
    Parameter("EKF2_MAG_DECL", PX4, Setting.DECLINATION, DEGREE, -180.0, 180.0),
    Parameter("COMPASS_AUTODEC", ARDUPILOT, Setting.AUTO_DECLINATION, 1.0, 1.0, 1.0),
    _of_planes("PTCH_TRIM_DEG", Setting.PITCH_TRIM, DEGREE, -45.0, 45.0),
    _of_planes("TRIM_PITCH_CD", Setting.PITCH_TRIM, 0.01 * DEGREE, -4500.0, 4500.0),
    _of_planes("FLIGHT_OPTIONS", Setting.FLIGHT_OPTIONS, 1.0, 1.0, WORD),
    _of_planes("Q_ENABLE", Setting.HOVERS, 1.0, 1.0, 2.0),
    _of_planes("Q_TRIM_PITCH", Setting.HOVER_PITCH_TRIM, DEGREE, -45.0, 45.0),
    _of_planes("Q_TAILSIT_ENABLE", Setting.TAILSITTER, 1.0, 1.0, 2.0),
    _of_planes("Q_FRAME_CLASS", Setting.HOVER_FRAME, 1.0, 1.0, 255.0),
    Parameter("AHRS_ORIENTATION", ARDUPILOT, Setting.BOARD_ORIENTATION, 1.0, 1.0, 255.0),
    Parameter("SENS_BOARD_ROT", PX4, Setting.BOARD_ORIENTATION, 1.0, 1.0, 255.0),
    *_of_sensors(),
)
"""ArduPilot 4.6 gave GPS_DELAY_MS its new name, and 4.5 TRIM_PITCH_CD (in hundredths); of PX4's two delays the second
is the newer. AHRS_TRIM is limited to 10 degrees where the autopilot calibrates it, and not where a user sets it.

ArduPilot's n-th accelerometer and n-th compass are those of its n-th inertial message: it puts the parameters of its
compasses into their order of priority when it boots. Offsets apply before scale factors, and those of accelerometers
before the rotation of the board. (AP_InertialSensor_Backend.cpp, AP_Compass_Backend.cpp, AP_Compass.cpp; PX4's
sensor_calibration.)"""

ROVER_LOW_PASS_HZ: Final = 4.0
"""ArduPilot's default of INS_GYRO_FILTER on ground vehicles and boats, Hz; 20 on all others."""
ROVER_DELAY_SIGMA_S: Final = 0.03
"""Uncertainty of the delay of that default, s: 4 Hz are late by 56 ms, 20 Hz by 11 ms, 2 Hz by 113 ms."""


def facts_of_firmware(autopilot: int, vehicle_type: int) -> VehicleSettings:
    """The settings that every vehicle with this MAV_AUTOPILOT and MAV_TYPE has before it sends any."""
    if autopilot == PX4:
        return VehicleSettings(low_pass_hz=0.0)
    if autopilot == ARDUPILOT and vehicle_kind(vehicle_type) == VehicleKind.SURFACE:
        assumed = VehicleSettings(low_pass_hz=ROVER_LOW_PASS_HZ)
        return assumed.updated(Setting.LOW_PASS_DELAY_SIGMA_S, ROVER_DELAY_SIGMA_S)
    return VehicleSettings()


def names_of(setting: Setting, autopilot: int, is_plane: bool = True) -> list[str]:
    """The parameters in which an autopilot (MAV_AUTOPILOT) may send a setting; empty where its vehicle has none."""
    return [
        one.name
        for one in PARAMETERS
        if one.setting == setting and one.autopilot == autopilot and (is_plane or not one.planes_only)
    ]


def parameters_of(autopilot: int) -> tuple[Parameter, ...]:
    """The parameters of one autopilot (MAV_AUTOPILOT)."""
    return tuple([one for one in PARAMETERS if one.autopilot == autopilot])


def parameter_bytes() -> frozenset[bytes]:
    """All names as PARAM_VALUE carries them, without the zeros behind them."""
    return frozenset([one.name.encode() for one in PARAMETERS])


class ParameterReader(Reader):
    """PARAM_VALUE of the parameters above; other parameters give no sample."""

    def __init__(self, dialect: Dialect) -> None:
        super().__init__("PARAM_VALUE")
        self._fields: Final = dialect.layout(self.name).pick("param_value", "param_index", "param_id", "param_type")
        self._known: Final = {one.name.encode(): one for one in PARAMETERS}

    def read(self, frame: Frame) -> list[Sample]:
        """One ParameterSample. A name of 16 characters has no zero behind it."""
        number, index, name, kind = self._fields.unpack(frame.payload)
        parameter = self._known.get(name.split(b"\0", 1)[0])
        if parameter is None:
            return []
        if kind == MAV_PARAM_TYPE_INT32 and parameter.autopilot == PX4:
            number = float(int.from_bytes(frame.payload[:4], "little", signed=True))
        value = parameter.value(number)
        if value is None:
            expected = f"0, or {parameter.low:g} to {parameter.high:g}"
            return self.refuse(frame, f"{parameter.name} is {number:g}; expected {expected}")
        return [
            ParameterSample(
                self.name,
                frame.system,
                frame.component,
                frame.rx_ns,
                parameter.name,
                parameter.setting,
                value,
                index != UINT16_MAX,
            )
        ]

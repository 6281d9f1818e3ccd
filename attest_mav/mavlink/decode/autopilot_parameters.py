"""Parameters of autopilots that carry a setting of the vehicle (``Setting``): their names, units and plausible values.

ArduPilot sends every parameter as a float. PX4 sends an integer one bit by bit in the place of the float.

PX4's IMU_GYRO_CUTOFF is left out. By PX4's documentation it filters the input of the controllers, not that of the
estimators. The inertial messages carry the input of the estimators: means over some milliseconds, without a low-pass
that would need a correction.
"""

from dataclasses import dataclass
from math import nan
from typing import Final

from attest_mav.mavlink.constants import MAV_AUTOPILOT_ARDUPILOTMEGA, MAV_AUTOPILOT_PX4, MAV_PARAM_TYPE_INT32
from attest_mav.mavlink.decode.readers import Reader
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import Frame
from attest_mav.types import ParameterSample, Sample, Setting, VehicleSettings


@dataclass(frozen=True)
class Parameter:
    """One parameter. ``autopilot``: MAV_AUTOPILOT.

    unit: one unit of the parameter in units of the setting. low, high: plausible range besides 0, in the parameter's
    unit. zero_is_default: 0 stands for a value that the autopilot does not send.
    """

    name: str
    autopilot: int
    setting: Setting
    unit: float
    low: float
    high: float
    zero_is_default: bool = False

    def value(self, number: float) -> float | None:
        """The setting for a number of the parameter: NaN for the autopilot's default, None for an implausible one."""
        if number == 0.0:
            return nan if self.zero_is_default else 0.0
        return number * self.unit if self.low <= number <= self.high else None


PARAMETERS: Final = (
    Parameter("INS_GYRO_FILTER", MAV_AUTOPILOT_ARDUPILOTMEGA, Setting.LOW_PASS_HZ, 1.0, 1.0, 1000.0),
    Parameter(
        "GPS1_DELAY_MS", MAV_AUTOPILOT_ARDUPILOTMEGA, Setting.FIX_DELAY_S, 1e-3, 0.0, 1000.0, zero_is_default=True
    ),
    Parameter(
        "GPS_DELAY_MS", MAV_AUTOPILOT_ARDUPILOTMEGA, Setting.FIX_DELAY_S, 1e-3, 0.0, 1000.0, zero_is_default=True
    ),
    Parameter("EKF2_GPS_DELAY", MAV_AUTOPILOT_PX4, Setting.FIX_DELAY_S, 1e-3, 0.0, 1000.0),
    Parameter("SENS_GPS0_DELAY", MAV_AUTOPILOT_PX4, Setting.FIX_DELAY_S, 1e-3, 0.0, 1000.0),
)
"""ArduPilot 4.6 gave GPS_DELAY_MS its new name; of PX4's two the second is the newer."""


def facts_of_firmware(autopilot: int) -> VehicleSettings:
    """The settings that every vehicle with this MAV_AUTOPILOT has before it sends any."""
    return VehicleSettings(low_pass_hz=0.0) if autopilot == MAV_AUTOPILOT_PX4 else VehicleSettings()


def names_of(setting: Setting, autopilot: int) -> list[str]:
    """The parameters in which an autopilot (MAV_AUTOPILOT) may send a setting; empty where it has none."""
    return [one.name for one in PARAMETERS if one.setting == setting and one.autopilot == autopilot]


def parameter_bytes() -> frozenset[bytes]:
    """All names as PARAM_VALUE carries them, without the zeros behind them."""
    return frozenset([one.name.encode() for one in PARAMETERS])


def quantity(setting: Setting) -> str:
    """Name of the setting for people."""
    return "gyro low-pass" if setting == Setting.LOW_PASS_HZ else "GPS delay"


def with_unit(setting: Setting, value: float) -> str:
    """A value of the setting with its unit, for people."""
    return f"{value:g} Hz" if setting == Setting.LOW_PASS_HZ else f"{value:g} s"


class ParameterReader(Reader):
    """PARAM_VALUE of the parameters above; other parameters give no sample."""

    def __init__(self, dialect: Dialect) -> None:
        super().__init__("PARAM_VALUE")
        self._fields: Final = dialect.layout(self.name).pick("param_value", "param_id", "param_type")
        self._known: Final = {one.name.encode(): one for one in PARAMETERS}

    def read(self, frame: Frame) -> list[Sample]:
        """One ParameterSample. A name of 16 characters has no zero behind it."""
        number, name, kind = self._fields.unpack(frame.payload)
        parameter = self._known.get(name.split(b"\0", 1)[0])
        if parameter is None:
            return []
        if kind == MAV_PARAM_TYPE_INT32 and parameter.autopilot == MAV_AUTOPILOT_PX4:
            number = float(int.from_bytes(frame.payload[:4], "little", signed=True))
        value = parameter.value(number)
        if value is None:
            expected = f"0, or {parameter.low:g} to {parameter.high:g}"
            return self.refuse(frame, f"{parameter.name} is {number:g}; expected {expected}")
        return [
            ParameterSample(
                self.name, frame.system, frame.component, frame.rx_ns, parameter.name, parameter.setting, value
            )
        ]

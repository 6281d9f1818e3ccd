"""The autopilot's parameters: read by name or number, and set. ArduPilot has the trim of its attitude among them."""

from dataclasses import replace
from math import radians
from struct import pack, unpack

from attest_mav.mavlink.constants import MAV_PARAM_TYPE_INT8, MAV_PARAM_TYPE_INT32, MAV_PARAM_TYPE_REAL32
from attest_mav.sim.personality import ARDUPILOT, PX4, Parameter, Personality
from attest_mav.sim.settings import SimSettings
from attest_mav.types import Vec3

TRIM_NAMES = ("AHRS_TRIM_X", "AHRS_TRIM_Y", "AHRS_TRIM_Z")
OF_PLANES = (
    Parameter("PTCH_TRIM_DEG", 0.0, MAV_PARAM_TYPE_REAL32),
    Parameter("FLIGHT_OPTIONS", 0.0, MAV_PARAM_TYPE_INT32),
    Parameter("Q_ENABLE", 0.0, MAV_PARAM_TYPE_INT8),
)
"""ArduPilot's planes: no pitch trim, no hover."""

FIRST_DEVICE = 2753028
"""Of the sensors' devices; each further one has the next number."""
OF_SENSORS = {
    ARDUPILOT.name: (
        ("INS_ACC_ID", "INS_ACCOFFS_{}"),
        ("COMPASS_DEV_ID", "COMPASS_OFS_{}"),
        ("INS_ACC2_ID", "INS_ACC2OFFS_{}"),
        ("COMPASS_DEV_ID2", "COMPASS_OFS2_{}"),
    ),
    PX4.name: (
        ("CAL_ACC0_ID", "CAL_ACC0_{}OFF"),
        ("CAL_MAG0_ID", "CAL_MAG0_{}OFF"),
        ("CAL_ACC1_ID", "CAL_ACC1_{}OFF"),
        ("CAL_MAG1_ID", "CAL_MAG1_{}OFF"),
    ),
}
"""The device and the offset of each sensor, by firmware."""
BOARD = {ARDUPILOT.name: "AHRS_ORIENTATION", PX4.name: "SENS_BOARD_ROT"}
"""The rotation from the board to the body."""


def of_sensors(personality: Personality) -> list[Parameter]:
    """Devices and offsets of the sensors, which are calibrated to zero, and the board that lies as the body."""
    parameters = [Parameter(BOARD[personality.name], 0.0, MAV_PARAM_TYPE_INT32)]
    for place, (device, offset) in enumerate(OF_SENSORS[personality.name]):
        parameters.append(Parameter(device, float(FIRST_DEVICE + place), MAV_PARAM_TYPE_INT32))
        parameters += [Parameter(offset.format(axis), 0.0, MAV_PARAM_TYPE_REAL32) for axis in "XYZ"]
    return parameters


class ParameterTable:
    """All parameters of one vehicle. A value that is set is saved: a restart keeps it."""

    def __init__(self, personality: Personality, settings: SimSettings, is_plane: bool) -> None:
        self.parameters = [*personality.parameters, *of_sensors(personality)]
        self._packs_integers = personality.name == PX4.name
        if personality.name == ARDUPILOT.name:
            named = zip(TRIM_NAMES, settings.trim, strict=True)
            self.parameters += [Parameter(name, angle, MAV_PARAM_TYPE_REAL32) for name, angle in named]
            declination = radians(settings.earth.declination_deg)
            self.parameters.append(Parameter("COMPASS_DEC", declination, MAV_PARAM_TYPE_REAL32))
            self.parameters += OF_PLANES if is_plane else ()
        else:
            self.parameters.append(Parameter("EKF2_MAG_DECL", settings.earth.declination_deg, MAV_PARAM_TYPE_REAL32))

    @property
    def trim(self) -> Vec3:
        """The trim of the reported attitude, rad; zero for a firmware that has none."""
        by_name = {one.name: one.value for one in self.parameters}
        x, y, z = (by_name.get(name, 0.0) for name in TRIM_NAMES)
        return (x, y, z)

    def index_of(self, name: str) -> int:
        """The number of a parameter, -1 for one that does not exist."""
        return next((index for index, one in enumerate(self.parameters) if one.name == name), -1)

    def told(self, index: int) -> float:
        """The value as PARAM_VALUE carries it: PX4's integers bit by bit in the place of the float."""
        one = self.parameters[index]
        if self._packs_integers and one.kind == MAV_PARAM_TYPE_INT32:
            return float(unpack("<f", pack("<i", int(one.value)))[0])
        return one.value

    def set(self, index: int, value: float) -> None:
        """Give a parameter another value."""
        self.parameters[index] = replace(self.parameters[index], value=value)

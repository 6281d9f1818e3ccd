"""The autopilot's parameters: read by name or number, and set. ArduPilot has the trim of its attitude among them."""

from dataclasses import replace
from math import radians

from attest_mav.mavlink.constants import MAV_PARAM_TYPE_INT8, MAV_PARAM_TYPE_INT32, MAV_PARAM_TYPE_REAL32
from attest_mav.sim.personality import ARDUPILOT, Parameter, Personality
from attest_mav.sim.settings import SimSettings
from attest_mav.types import Vec3

TRIM_NAMES = ("AHRS_TRIM_X", "AHRS_TRIM_Y", "AHRS_TRIM_Z")
OF_PLANES = (
    Parameter("PTCH_TRIM_DEG", 0.0, MAV_PARAM_TYPE_REAL32),
    Parameter("FLIGHT_OPTIONS", 0.0, MAV_PARAM_TYPE_INT32),
    Parameter("Q_ENABLE", 0.0, MAV_PARAM_TYPE_INT8),
)
"""ArduPilot's planes: no pitch trim, no hover."""


class ParameterTable:
    """All parameters of one vehicle. A value that is set is saved: a restart keeps it."""

    def __init__(self, personality: Personality, settings: SimSettings, is_plane: bool) -> None:
        self.parameters = list(personality.parameters)
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

    def set(self, index: int, value: float) -> None:
        """Give a parameter another value."""
        self.parameters[index] = replace(self.parameters[index], value=value)

"""The autopilot's parameters: read by name or number, and set. ArduPilot has the trim of its attitude among them."""

from dataclasses import replace

from attest_mav.mavlink.constants import MAV_PARAM_TYPE_REAL32
from attest_mav.sim.personality import ARDUPILOT, Parameter, Personality
from attest_mav.types import Vec3

TRIM_NAMES = ("AHRS_TRIM_X", "AHRS_TRIM_Y", "AHRS_TRIM_Z")


class ParameterTable:
    """All parameters of one vehicle. A value that is set is saved: a restart keeps it."""

    def __init__(self, personality: Personality, trim: Vec3) -> None:
        self.parameters = list(personality.parameters)
        if personality is ARDUPILOT:
            named = zip(TRIM_NAMES, trim, strict=True)
            self.parameters += [Parameter(name, angle, MAV_PARAM_TYPE_REAL32) for name, angle in named]

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

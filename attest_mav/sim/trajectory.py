"""The interface of trajectories. All of them stand still for ``STILL_S`` seconds first, so that a filter can align."""

from abc import ABC, abstractmethod
from math import radians
from typing import Final

from attest_mav.mavlink.constants import MAV_TYPE_QUADROTOR
from attest_mav.sim.motion import Motion
from attest_mav.types import Vec3

STILL_S: Final = 6.0
"""How long every vehicle stands still at the start."""


class Trajectory(ABC):
    """A motion that is a function of time: no state, any order of calls. Time is in seconds from the start."""

    flies = True
    is_plane = False
    vehicle_type: int = MAV_TYPE_QUADROTOR
    """MAV_TYPE."""

    @abstractmethod
    def at(self, t_s: float) -> Motion:
        """The motion at time ``t_s``."""

    @abstractmethod
    def position(self, t_s: float) -> Vec3:
        """Position in NED from the start, m; its derivative is the velocity of ``at``."""


class Still(Trajectory):
    """On the ground, rolled 2 degrees, pitched -1, nose at 60 degrees."""

    flies = False

    def __init__(self) -> None:
        self.motion = Motion((radians(2.0), radians(-1.0), radians(60.0)), (0.0,) * 3, (0.0,) * 3, (0.0,) * 3)

    def at(self, t_s: float) -> Motion:
        """See ``Trajectory``."""
        return self.motion

    def position(self, t_s: float) -> Vec3:
        """See ``Trajectory``."""
        return (0.0, 0.0, 0.0)

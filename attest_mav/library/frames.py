"""Axes of body and world: the package's own, and the two that robots and sensor boards use.

Roll, pitch and quaternions of different conventions must not be mixed, so readings are turned into the package's axes
(forward, right, down; north, east, down) before a filter sees them, and attitudes are turned back.
"""

from dataclasses import dataclass
from math import sqrt
from typing import Final

from attest_mav.algebra import q_conj, q_mul
from attest_mav.errors import ArgumentError
from attest_mav.types import Quat, Vec3

_HALF_TURN: Final[Quat] = (0.0, 1.0, 0.0, 0.0)
"""About the x axis: y and z change their signs."""
_SWAP: Final[Quat] = (0.0, sqrt(0.5), sqrt(0.5), 0.0)
"""About the axis between x and y: they change places, and z its sign."""
_NONE: Final[Quat] = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Frames:
    """A convention of axes, and how it becomes the package's own."""

    name: str
    """Body and world, as users write them."""
    body: Quat
    """Turns body vectors of the convention into FRD."""
    world: Quat
    """Turns world vectors of the convention into NED."""

    def attitude(self, q_nb: Quat) -> Quat:
        """The attitude (FRD to NED) as one of the convention, body to world."""
        return q_mul(q_conj(self.world), q_mul(q_nb, self.body))

    def body_vector(self, v: Vec3) -> Vec3:
        """A vector in the convention's body as one in FRD; the inverse is the same, for each is half a turn."""
        return v if self.body == _NONE else (v[0], -v[1], -v[2])

    def world_vector(self, v: Vec3) -> Vec3:
        """A vector in the convention's world as one in NED."""
        if self.world == _NONE:
            return v
        return (v[0], -v[1], -v[2]) if self.world == _HALF_TURN else (v[1], v[0], -v[2])


FRD_NED: Final = Frames("FRD/NED", _NONE, _NONE)
"""Forward, right, down in north, east, down: the package's own, and MAVLink's."""
FLU_ENU: Final = Frames("FLU/ENU", _HALF_TURN, _SWAP)
"""Forward, left, up in east, north, up: ROS (REP 103), VQF. The yaw is zero towards the east."""
FLU_NWU: Final = Frames("FLU/NWU", _HALF_TURN, _HALF_TURN)
"""Forward, left, up in north, west, up: imufusion's default, Madgwick's code."""


def frames_named(name: str) -> Frames:
    """The convention of that name; ArgumentError lists the names if there is none."""
    known = {one.name: one for one in (FRD_NED, FLU_ENU, FLU_NWU)}
    if name not in known:
        raise ArgumentError(f"unknown frames {name!r}; expected one of {', '.join(known)}")
    return known[name]

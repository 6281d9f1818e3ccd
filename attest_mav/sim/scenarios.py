"""The motions by the names users type. Each begins with ``trajectory.STILL_S`` seconds of standing still.

still
    On the ground, slightly tilted, for ever.
hover
    A copter holding its place in gusts: up to seven degrees of tilt, slow yaw.
coordinated-turns
    A plane: take-off run, climb, then 540 degree turns to the right at 30 and to the left at 45 degrees of bank,
    with short straights between.
square
    A copter flying a 40 m square, nose on track: up to 18 degrees of tilt, and 90 degree yaws at the corners.
rover
    On level ground, turning to and fro on nearly one spot at up to 6 rad/s.
tumbling
    Turning over and over about all axes, at up to about 3 rad/s, while moving a little.
"""

from random import Random
from typing import Final

from attest_mav.errors import UsageError
from attest_mav.sim.copters import Hover, Square, Tumbling
from attest_mav.sim.plane import CoordinatedTurns
from attest_mav.sim.rover import Spins
from attest_mav.sim.trajectory import Still, Trajectory

SCENARIOS: Final = ("still", "hover", "coordinated-turns", "square", "rover", "tumbling")


def check_scenario(name: str) -> None:
    """UsageError lists the names there are, unless this is one of them."""
    if name not in SCENARIOS:
        raise UsageError(f"unknown scenario {name[:40]!r}: expected one of {', '.join(SCENARIOS)}")


def make_trajectory(name: str, seed: int) -> Trajectory:
    """The trajectory of that name; UsageError lists the names there are. Only ``hover`` depends on the seed."""
    check_scenario(name)
    if name == "still":
        return Still()
    if name == "hover":
        return Hover(Random(f"hover {seed}"))  # noqa: S311  # a simulation, no secret
    if name == "coordinated-turns":
        return CoordinatedTurns()
    if name == "square":
        return Square()
    if name == "rover":
        return Spins()
    return Tumbling()

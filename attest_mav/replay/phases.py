"""The phases of a flight over log time: from the autopilot's own words (armed, on the ground) and from the motion.

A phase is told afterwards, by the whole log: the first seconds off the ground are the take-off and the last ones the
landing.
"""

from array import array
from bisect import bisect_right
from enum import IntEnum
from math import exp
from typing import Final

from attest_mav.algebra import hypotenuse
from attest_mav.samples import AirDataSample, Sample, VelocitySample
from attest_mav.types import VelocityOrigin
from attest_mav.vehicle_reports import HeartbeatSample, LandedSample

FRESH_S: Final = 3.0
"""A velocity older than this tells nothing."""
NEAR_GROUND_S: Final = 10.0
"""So long after leaving the ground is the take-off, and so long before reaching it the landing."""
CLIMB_SPEED: Final = 1.0
"""m/s: vertical speed of a climb or a descent."""
HOVER_SPEED: Final = 2.0
"""m/s: ground speed below which an armed vehicle off the ground hovers."""
TURN_RATE: Final = 0.15
"""rad/s (9 deg/s): mean rate about the vertical of the body in a turn."""
TURN_S: Final = 1.0
"""Time constant of that mean, s."""


class Phase(IntEnum):
    """What the vehicle does."""

    UNKNOWN = 0
    GROUND = 1
    TAKE_OFF = 2
    CLIMB = 3
    DESCENT = 4
    TURN = 5
    HOVER = 6
    CRUISE = 7
    LANDING = 8

    @property
    def words(self) -> str:
        """The phase for people."""
        return self.name.lower().replace("_", "-")


class FlightPhases:
    """Follows a flight; ``at`` tells the phase of any time of it."""

    def __init__(self) -> None:
        self._armed: bool | None = None
        self._on_ground: bool | None = None
        self._horizontal = 0.0
        self._climb = 0.0
        self._moved_s = -FRESH_S
        self._turn_rate = 0.0
        self._rate_s = 0.0
        self._begins_s: Final = array("d")
        self._phases: Final = array("b")
        self._newest: Phase | None = None

    def take(self, sample: Sample, elapsed_s: float) -> None:
        """Take what the vehicle says of itself, or a receiver of its motion, at this log time."""
        if isinstance(sample, HeartbeatSample):
            self._armed = sample.armed
        elif isinstance(sample, LandedSample):
            self._on_ground = sample.on_ground
        elif isinstance(sample, VelocitySample):
            if sample.origin == VelocityOrigin.RECEIVER or elapsed_s - self._moved_s > FRESH_S:
                north, east, down = sample.v_ned
                self._moved(hypotenuse(north, east), -down if sample.vertical_known else self._climb, elapsed_s)
        elif isinstance(sample, AirDataSample):
            self._moved(self._horizontal, sample.climb, self._moved_s)

    def _moved(self, horizontal: float, climb: float, elapsed_s: float) -> None:
        self._horizontal, self._climb, self._moved_s = horizontal, climb, elapsed_s

    def turn(self, rate: float, elapsed_s: float) -> None:
        """Take the rate about the body's vertical, rad/s, of an inertial sample."""
        share = 1.0 - exp(min(0.0, self._rate_s - elapsed_s) / TURN_S)
        self._turn_rate += share * (rate - self._turn_rate)
        self._rate_s = elapsed_s
        now = self._now(elapsed_s)
        if now != self._newest:
            self._newest = now
            self._begins_s.append(elapsed_s)
            self._phases.append(now)

    def at(self, elapsed_s: float) -> Phase:
        """The phase at a log time."""
        index = bisect_right(self._begins_s, elapsed_s) - 1
        if index < 0:
            return Phase.UNKNOWN
        phase = Phase(self._phases[index])
        if phase in {Phase.UNKNOWN, Phase.GROUND}:
            return phase
        if self._is_ground_between(elapsed_s - NEAR_GROUND_S, elapsed_s):
            return Phase.TAKE_OFF
        return Phase.LANDING if self._is_ground_between(elapsed_s, elapsed_s + NEAR_GROUND_S) else phase

    def _is_ground_between(self, begin_s: float, end_s: float) -> bool:
        """Whether the vehicle stood in some of this time."""
        first = max(0, bisect_right(self._begins_s, begin_s) - 1)
        return Phase.GROUND in self._phases[first : bisect_right(self._begins_s, end_s)]

    def _now(self, elapsed_s: float) -> Phase:
        """The phase by what is known now, with the take-off and the landing still part of the flight."""
        if self._armed is False or (self._on_ground is True and self._armed is not None):
            return Phase.GROUND
        if elapsed_s - self._moved_s > FRESH_S:
            return Phase.GROUND if self._on_ground is True else Phase.UNKNOWN
        if self._on_ground is True and self._horizontal < HOVER_SPEED:
            return Phase.GROUND
        if abs(self._climb) > CLIMB_SPEED:
            return Phase.CLIMB if self._climb > 0.0 else Phase.DESCENT
        if abs(self._turn_rate) > TURN_RATE:
            return Phase.TURN
        return Phase.HOVER if self._horizontal < HOVER_SPEED else Phase.CRUISE

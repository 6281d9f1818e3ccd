"""The beginnings of the stretches of a flight: attitude and velocity there, with their sigmas."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from attest_mav.algebra import q_conj, q_exp, q_mul
from attest_mav.filters.velocity_aided.aids.zero_motion import VELOCITY_SIGMA
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.smoothing.backward import smoothed_of
from attest_mav.smoothing.forward import Restart
from attest_mav.smoothing.model import START_SIGMA, UNKNOWN_SPEED
from attest_mav.smoothing.parts import Part, Parts
from attest_mav.smoothing.readings import Fixes, Stretch
from attest_mav.smoothing.rotations import Array, matrices
from attest_mav.smoothing.tables import RUN, Table
from attest_mav.types import Quat

FIX_NEAR_S: Final = 2.0
"""A fix so near to the beginning of a stretch tells the velocity there, s."""


class Starts:
    """The velocities that are assumed in a flight: at the beginnings of its stretches, and where no fix tells them."""

    def __init__(self, parts: Parts, parameters: FlightParameters) -> None:
        self._parts: Final = parts
        self._fixes: Final = parts.recording.fixes
        self._parameters: Final = parameters
        stretches = parts.recording.stretches
        self._stretches: Final = {int(np.searchsorted(parts.nodes, one.begin)): one for one in stretches}

    def restarts(self, part: Part, known: Table | None) -> dict[int, Restart]:
        """The beginnings of stretches in a part, by node of it. known: smoothed states of an earlier pass."""
        last = part.first + len(part.rows) - 1
        return {
            node - part.first: self._restart(part, node - part.first, one, known)
            for node, one in self._stretches.items()
            if part.first <= node <= last
        }

    def zero_velocity(self, part: Part, dt_s: Array) -> Array:
        """Sigma of a zero velocity for each node, m/s: of a vehicle that stands, or moves about a place."""
        without = self._without_fixes(part.node_s)
        place = self._parameters.place_noise / np.sqrt(np.append(dt_s[:1], dt_s))
        moving = np.where(part.readings.stays[part.rows] & without, place, np.inf)
        out: Array = np.where(part.readings.at_rest[part.rows] & without, VELOCITY_SIGMA, moving)
        return out

    def _without_fixes(self, node_s: Array) -> NDArray[np.bool_]:
        """For each node whether no fix lies near."""
        fix_s = self._fixes.t_s
        if not len(fix_s):
            return np.ones(len(node_s), dtype=np.bool_)
        place = np.searchsorted(fix_s, node_s)
        before = node_s - fix_s[np.maximum(place - 1, 0)]
        behind = fix_s[np.minimum(place, len(fix_s) - 1)] - node_s
        out: NDArray[np.bool_] = np.minimum(np.abs(before), np.abs(behind)) > FIX_NEAR_S
        return out

    def _restart(self, part: Part, node: int, stretch: Stretch, known: Table | None) -> Restart:
        """Attitude and velocity at the beginning of a stretch."""
        fixes, row = self._fixes, int(part.rows[node])
        attitude = matrices(np.array(self._turned_back(stretch)))
        if known is not None:
            attitude = smoothed_of(known.rows(part.first + node, part.first + node + 1)).attitude[0]
        sigma = np.array(START_SIGMA)
        velocity = np.zeros(3)
        near = _fix_from(fixes, float(part.readings.t_s[row]))
        if near is not None:
            velocity = fixes.velocity[near]
        elif not part.readings.at_rest[row] and not part.readings.stays[row]:
            sigma[3:] = UNKNOWN_SPEED
        return Restart(attitude, velocity, np.diag(sigma**2))

    def _turned_back(self, stretch: Stretch) -> Quat:
        """The attitude at the beginning of a stretch by that at the reading where it was aligned."""
        turn: Quat = (1.0, 0.0, 0.0, 0.0)
        for begin in range(stretch.begin + 1, stretch.aligned + 1, RUN):
            steps = self._parts.steps.rows(begin, min(begin + RUN, stretch.aligned + 1))
            for x, y, z in (0.5 * steps["dt_s"][:, np.newaxis] * steps["rate"]).tolist():
                turn = q_mul(turn, q_exp((x, y, z)))
        return q_mul(stretch.q_nb, q_conj(turn))


def _fix_from(fixes: Fixes, time_s: float) -> int | None:
    """The first fix from a time on, s; None where it is not near."""
    near = int(np.searchsorted(fixes.t_s, time_s))
    return near if near < len(fixes.t_s) and fixes.t_s[near] - time_s < FIX_NEAR_S else None

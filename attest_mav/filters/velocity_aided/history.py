"""A short history of velocity gains, so that a fix can be compared with the velocity of the time it belongs to.

Only differences are ever taken, so corrections of the velocity leave the history valid; those of the attitude turn
it by the correction, which within its length is negligible.
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, scale, sub
from attest_mav.types import Vec3

LENGTH_NS: Final = 600_000_000
"""The oldest fix that can be used is about this old: message age plus receiver delay."""
SPACING_NS: Final = 8_000_000
"""Faster samples are not all kept."""
FUTURE_NS: Final = 50_000_000
"""A velocity without delay is newer than the low-passed sensors: by this much at most it is taken for theirs."""


@mypyc_attr(acyclic=True)
class HistoryPoint:
    """``gain``: integral of the specific force in NED from some origin to ``t_ns``, m/s."""

    def __init__(self, t_ns: int, delta_velocity: Vec3) -> None:
        self.t_ns: Final = t_ns
        self.delta_velocity: Final = delta_velocity


@mypyc_attr(acyclic=True)
class DeltaVelocityHistory:
    """``points`` are old to new, at most ``LENGTH_NS / SPACING_NS`` and two; ``head`` is the present."""

    def __init__(self, points: tuple[HistoryPoint, ...], newest: HistoryPoint) -> None:
        self.points: Final = points
        self.newest: Final = newest


@mypyc_attr(acyclic=True)
class Lookback:
    """What happened since an instant: the gain of specific force, m/s, its age, and the force of then, m/s^2; NED."""

    def __init__(self, delta_velocity: Vec3, age_s: float, specific_force: Vec3) -> None:
        self.delta_velocity: Final = delta_velocity
        self.age_s: Final = age_s
        self.specific_force: Final = specific_force


def empty_history(t_ns: int) -> DeltaVelocityHistory:
    """An empty history that begins now."""
    return DeltaVelocityHistory((), HistoryPoint(t_ns, (0.0, 0.0, 0.0)))


def appended(history: DeltaVelocityHistory, t_ns: int, delta_velocity: Vec3) -> DeltaVelocityHistory:
    """The history with one more step, whose specific force integrates to ``push`` (NED, m/s).

    A clock that does not go on, as one of 32 bits that has wrapped, begins a new one.
    """
    if t_ns <= history.newest.t_ns:
        return empty_history(t_ns)
    points = history.points
    if not points or history.newest.t_ns - points[-1].t_ns >= SPACING_NS:
        points = (*points, history.newest)
        while len(points) > 1 and t_ns - points[1].t_ns > LENGTH_NS:
            points = points[1:]
    return DeltaVelocityHistory(points, HistoryPoint(t_ns, add(history.newest.delta_velocity, delta_velocity)))


def look_back(history: DeltaVelocityHistory, t_ns: int) -> Lookback | None:
    """What happened since ``t_ns``, None if that is before the history. The near future counts as now."""
    newer = history.newest
    if t_ns > newer.t_ns:
        if t_ns > newer.t_ns + FUTURE_NS:
            return None
        t_ns = newer.t_ns
    for i in range(len(history.points) - 1, -1, -1):
        older = history.points[i]
        if older.t_ns <= t_ns:
            span_s = (newer.t_ns - older.t_ns) * 1e-9
            specific_force = scale(sub(newer.delta_velocity, older.delta_velocity), 1.0 / span_s)
            then = add(older.delta_velocity, scale(specific_force, (t_ns - older.t_ns) * 1e-9))
            return Lookback(
                sub(history.newest.delta_velocity, then), (history.newest.t_ns - t_ns) * 1e-9, specific_force
            )
        newer = older
    return None

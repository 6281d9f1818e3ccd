"""The delta-velocity history: a delayed fix is compared with the velocity of the time it belongs to.

Only differences are ever taken, so corrections of the velocity leave the history valid; those of the attitude turn it
by the correction, which within its length is negligible. (For delayed measurements see Groves, Principles of GNSS,
Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., chapter 3.)
"""

from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, scale, sub
from attest_mav.record import Record
from attest_mav.types import Vec3

LENGTH_NS: Final = 600_000_000
"""Age of the oldest fix that can be used, ns: message age plus receiver delay."""
SPACING_NS: Final = 8_000_000
"""Least time between two points, ns: faster samples are not all kept."""
CHUNK: Final = 8
"""Points that are kept together: a step copies the references to so many at most, and not those to all."""
FUTURE_NS: Final = 50_000_000
"""How far in the future a fix may lie and count as of now, ns: the low-passed sensors are late themselves."""


@mypyc_attr(acyclic=True, free_list_len=1)
class HistoryPoint(Record):
    """The integral of the specific force up to one instant."""

    def __init__(self, t_ns: int, delta_velocity: Vec3) -> None:
        self.t_ns: Final = t_ns
        """Sensor clock, ns."""
        self.delta_velocity: Final = delta_velocity
        """Integral of the specific force from the history's origin, m/s, in axes that do not turn."""


@mypyc_attr(acyclic=True, free_list_len=1)
class DeltaVelocityHistory(Record):
    """The last 0.6 s of integrated specific force. A point is followed by the next one, and the last by the newest."""

    def __init__(
        self,
        chunks: tuple[tuple[HistoryPoint, ...], ...],
        recent: tuple[HistoryPoint, ...],
        newest: HistoryPoint,
        oldest_ns: int,
    ) -> None:
        self.chunks: Final = chunks
        """Points old to new, ``CHUNK`` of them in each."""
        self.recent: Final = recent
        """The points behind them, at most ``CHUNK``."""
        self.newest: Final = newest
        """The present."""
        self.oldest_ns: Final = oldest_ns
        """A point that is followed by an older one than this does not count, ns."""


@mypyc_attr(acyclic=True)
class Lookback(Record):
    """The motion between an instant and now."""

    def __init__(self, delta_velocity: Vec3, age_s: float, specific_force: Vec3) -> None:
        self.delta_velocity: Final = delta_velocity
        """Integral of the specific force since the instant, m/s."""
        self.age_s: Final = age_s
        """Age of the instant, s."""
        self.specific_force: Final = specific_force
        """Specific force at the instant, m/s^2."""


def empty_history(t_ns: int) -> DeltaVelocityHistory:
    """A history that begins now."""
    return DeltaVelocityHistory((), (), HistoryPoint(t_ns, (0.0, 0.0, 0.0)), t_ns - LENGTH_NS)


def appended(history: DeltaVelocityHistory, t_ns: int, delta_velocity: Vec3) -> DeltaVelocityHistory:
    """The history with one more step, whose specific force integrates to ``delta_velocity``, m/s.

    A clock that does not go on, as one of 32 bits that has wrapped, begins a new one.
    """
    before, recent = history.newest, history.recent
    if t_ns <= before.t_ns:
        return empty_history(t_ns)
    newest = HistoryPoint(t_ns, add(before.delta_velocity, delta_velocity))
    if recent and before.t_ns - recent[-1].t_ns < SPACING_NS:
        return DeltaVelocityHistory(history.chunks, recent, newest, history.oldest_ns)
    oldest_ns = t_ns - LENGTH_NS
    if len(recent) < CHUNK:
        return DeltaVelocityHistory(history.chunks, recent + (before,), newest, oldest_ns)  # noqa: RUF005 - one copy less
    chunks = _counting(history.chunks, oldest_ns) + (recent,)  # noqa: RUF005
    return DeltaVelocityHistory(chunks, (before,), newest, oldest_ns)


def _counting(chunks: tuple[tuple[HistoryPoint, ...], ...], oldest_ns: int) -> tuple[tuple[HistoryPoint, ...], ...]:
    """The chunks from the first one on that holds a point which counts."""
    first = 0
    while first + 1 < len(chunks) and chunks[first + 1][0].t_ns < oldest_ns:
        first += 1
    return chunks[first:]


def look_back(history: DeltaVelocityHistory, t_ns: int) -> Lookback | None:
    """The motion since ``t_ns``, None if that is before the history. The near future counts as now."""
    newer = history.newest
    if t_ns > newer.t_ns:
        if t_ns > newer.t_ns + FUTURE_NS:
            return None
        t_ns = newer.t_ns
    for index in range(len(history.chunks), -1, -1):
        points = history.recent if index == len(history.chunks) else history.chunks[index]
        for i in range(len(points) - 1, -1, -1):
            older = points[i]
            if older.t_ns <= t_ns:
                return _between(older, newer, history, t_ns)
            newer = older
    return None


def _between(older: HistoryPoint, newer: HistoryPoint, history: DeltaVelocityHistory, t_ns: int) -> Lookback | None:
    """The motion since an instant between two points, None where the older one does not count."""
    if newer.t_ns < history.oldest_ns:
        return None
    newest = history.newest
    span_s = (newer.t_ns - older.t_ns) * 1e-9
    specific_force = scale(sub(newer.delta_velocity, older.delta_velocity), 1.0 / span_s)
    then = add(older.delta_velocity, scale(specific_force, (t_ns - older.t_ns) * 1e-9))
    return Lookback(sub(newest.delta_velocity, then), (newest.t_ns - t_ns) * 1e-9, specific_force)

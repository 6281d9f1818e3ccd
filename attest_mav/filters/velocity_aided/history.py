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
class Point:
    """``gain``: integral of the specific force in NED from some origin to ``t_ns``, m/s."""

    def __init__(self, t_ns: int, gain: Vec3) -> None:
        self.t_ns: Final = t_ns
        self.gain: Final = gain


@mypyc_attr(acyclic=True)
class Track:
    """``points`` are old to new, at most ``LENGTH_NS / SPACING_NS`` and two; ``head`` is the present."""

    def __init__(self, points: tuple[Point, ...], head: Point) -> None:
        self.points: Final = points
        self.head: Final = head


@mypyc_attr(acyclic=True)
class Since:
    """What happened since an instant: the gain of specific force, m/s, its age, and the force of then, m/s^2; NED."""

    def __init__(self, gain: Vec3, age_s: float, force: Vec3) -> None:
        self.gain: Final = gain
        self.age_s: Final = age_s
        self.force: Final = force


def begun(t_ns: int) -> Track:
    """An empty history that begins now."""
    return Track((), Point(t_ns, (0.0, 0.0, 0.0)))


def longer(track: Track, t_ns: int, push: Vec3) -> Track:
    """The history with one more step, whose specific force integrates to ``push`` (NED, m/s).

    A clock that does not go on, as one of 32 bits that has wrapped, begins a new one.
    """
    if t_ns <= track.head.t_ns:
        return begun(t_ns)
    points = track.points
    if not points or track.head.t_ns - points[-1].t_ns >= SPACING_NS:
        points = (*points, track.head)
        while len(points) > 1 and t_ns - points[1].t_ns > LENGTH_NS:
            points = points[1:]
    return Track(points, Point(t_ns, add(track.head.gain, push)))


def since(track: Track, t_ns: int) -> Since | None:
    """What happened since ``t_ns``, None if that is before the history. The near future counts as now."""
    newer = track.head
    if t_ns > newer.t_ns:
        if t_ns > newer.t_ns + FUTURE_NS:
            return None
        t_ns = newer.t_ns
    for i in range(len(track.points) - 1, -1, -1):
        older = track.points[i]
        if older.t_ns <= t_ns:
            span_s = (newer.t_ns - older.t_ns) * 1e-9
            force = scale(sub(newer.gain, older.gain), 1.0 / span_s)
            then = add(older.gain, scale(force, (t_ns - older.t_ns) * 1e-9))
            return Since(sub(track.head.gain, then), (track.head.t_ns - t_ns) * 1e-9, force)
        newer = older
    return None

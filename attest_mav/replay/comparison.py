"""Attitudes of one source against the reference, sample by sample."""

from collections import deque
from math import nan
from typing import Final, Protocol

from attest_mav.algebra import heading_between, tilt_between
from attest_mav.estimation.timebase import WRAP_NS
from attest_mav.replay.consistency import Consistency
from attest_mav.replay.metrics import SURE, ErrorColumns
from attest_mav.replay.track import MEMORY_NS, AttitudeTrack
from attest_mav.types import North, Quat


class Attitude:
    """One attitude to be compared.

    elapsed_s: log time, from the first inertial sample. counted: it is past the time left out of the figures.
    tilt_sigma, heading_sigma: what its source says of its own errors, 1-sigma, rad; NaN when nothing. velocity_nis,
    field_nis: its normalised innovations squared, as in ``Estimate``.
    """

    def __init__(
        self,
        t_ns: int,
        elapsed_s: float,
        q_nb: Quat,
        north: North,
        tilt_sigma: float,
        heading_sigma: float,
        counted: bool,
        velocity_nis: float = nan,
        field_nis: float = nan,
    ) -> None:
        self.t_ns: Final = t_ns % WRAP_NS  # 32-bit clocks wrap, others do not: here all do
        self.elapsed_s: Final = elapsed_s
        self.q_nb: Final = q_nb
        self.north: Final = north
        self.tilt_sigma: Final = tilt_sigma
        self.heading_sigma: Final = heading_sigma
        self.counted: Final = counted
        self.velocity_nis: Final = velocity_nis
        self.field_nis: Final = field_nis


class Row:
    """One attitude with its errors (rad), None where there is nothing to compare it with."""

    def __init__(self, name: str, attitude: Attitude, tilt: float | None, heading: float | None) -> None:
        self.name: Final = name
        self.attitude: Final = attitude
        self.tilt: Final = tilt
        self.heading: Final = heading


class RowSink(Protocol):
    """Where rows go, in order of time for each name."""

    def write(self, row: Row) -> None:
        """Take one row."""


class Comparison:
    """Compares the attitudes of one source with the reference at their times, as both arrive.

    An attitude waits until the reference has passed it, and no longer than the reference's memory lasts.
    """

    def __init__(self, name: str, track: AttitudeTrack, sink: RowSink | None = None) -> None:
        self.name: Final = name
        self.errors: Final = ErrorColumns()
        self.consistency: Final = Consistency()
        self._track: Final = track
        self._sink: Final = sink
        self._waiting: Final[deque[Attitude]] = deque()

    def add(self, attitude: Attitude) -> None:
        """Take the next attitude of the source."""
        waiting = self._waiting
        while waiting and not 0 <= attitude.t_ns - waiting[0].t_ns <= MEMORY_NS:
            self._compare(waiting.popleft())
        waiting.append(attitude)
        self.settle()

    def settle(self) -> None:
        """Compare what the reference has reached; to be called when it has grown."""
        waiting = self._waiting
        while waiting and self._track.reaches(waiting[0].t_ns):
            self._compare(waiting.popleft())

    def finish(self) -> None:
        """The log has ended: nothing is worth waiting for."""
        while self._waiting:
            self._compare(self._waiting.popleft())

    def _compare(self, attitude: Attitude) -> None:
        if attitude.counted:
            self.consistency.take_step(attitude.tilt_sigma, attitude.velocity_nis, attitude.field_nis)
        tilt: float | None = None
        heading: float | None = None
        truth = self._track.at(attitude.t_ns)
        if truth is not None:
            tilt = tilt_between(attitude.q_nb, truth)
            if attitude.north != North.RELATIVE:
                heading = heading_between(attitude.q_nb, truth)
            if attitude.counted:
                self._count(attitude, tilt, heading)
        if self._sink is not None:
            self._sink.write(Row(self.name, attitude, tilt, heading))

    def _count(self, attitude: Attitude, tilt: float, heading: float | None) -> None:
        """Make the errors (rad) part of the figures."""
        self.errors.add(tilt, heading, attitude.tilt_sigma < SURE)
        self.consistency.tilt.add(tilt, attitude.tilt_sigma)
        if heading is not None:
            self.consistency.heading.add(heading, attitude.heading_sigma)

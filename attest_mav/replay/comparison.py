"""Attitudes of one filter or autopilot against the reference, sample by sample."""

from typing import Final, Protocol

from mypy_extensions import mypyc_attr

from attest_mav.algebra import heading_between, tilt_between
from attest_mav.estimation.timebase import WRAP_NS
from attest_mav.innovation import Innovation
from attest_mav.record import Record
from attest_mav.replay.consistency import Consistency
from attest_mav.replay.metrics import SURE, ErrorColumns
from attest_mav.replay.peaks import Peak
from attest_mav.replay.reference_track import MEMORY_NS, Lack, ReferenceTrack
from attest_mav.replay.steady_tilt import SteadyTilt
from attest_mav.ring_buffer import RingBuffer
from attest_mav.types import North, Quat


@mypyc_attr(acyclic=True, free_list_len=1)  # as Sample
class Attitude(Record):
    """One attitude to be compared. Sigmas and innovations are those of ``Estimate``."""

    def __init__(
        self,
        t_ns: int,
        elapsed_s: float,
        q_nb: Quat,
        north: North,
        tilt_sigma: float,
        heading_sigma: float,
        counted: bool,
        innovations: tuple[Innovation, ...] = (),
        unix_s: float | None = None,
    ) -> None:
        self.t_ns: Final = t_ns % WRAP_NS  # 32-bit clocks wrap, others do not: here all do
        """Sensor clock, ns."""
        self.elapsed_s: Final = elapsed_s
        """Log time, from the first inertial sample, s."""
        self.q_nb: Final = q_nb
        self.north: Final = north
        self.tilt_sigma: Final = tilt_sigma
        """Standard deviation of the tilt, rad; NaN if unknown."""
        self.heading_sigma: Final = heading_sigma
        """Standard deviation of the heading, rad; NaN if unknown."""
        self.counted: Final = counted
        """True after the time that is left out of the figures."""
        self.innovations: Final = innovations
        """Of the aids that had something to say in this step."""
        self.unix_s: Final = unix_s
        """UTC, s since 1970; None before the log has told it."""


@mypyc_attr(acyclic=True)  # as Sample
class ComparedAttitude(Record):
    """One attitude with its errors against the reference."""

    def __init__(
        self, name: str, attitude: Attitude, tilt: float | None, heading: float | None, reference: Quat | None = None
    ) -> None:
        self.name: Final = name
        """Filter or autopilot."""
        self.attitude: Final = attitude
        self.tilt: Final = tilt
        """Tilt error, rad; None without a reference at that time."""
        self.heading: Final = heading
        """Heading error, rad; None as above, or if the heading does not refer to true north as the reference does."""
        self.reference: Final = reference
        """The reference at that time, body to NED; None without one."""


class ComparisonSink(Protocol):
    """Takes compared attitudes, for each name in order of time."""

    def write(self, compared: ComparedAttitude) -> None:
        """Take the next one."""


class Comparison:
    """Compares the attitudes of one filter or autopilot with the reference at their times, as both arrive.

    An attitude waits until the reference has passed its time, at most for the memory of the reference.
    """

    def __init__(
        self,
        name: str,
        reference: ReferenceTrack,
        sink: ComparisonSink | None = None,
        steady_tilt: SteadyTilt | None = None,
    ) -> None:
        """steady_tilt: collects the counted tilt errors in the body, where they may show a trim."""
        self.name: Final = name
        self.errors: Final = ErrorColumns()
        self.consistency: Final = Consistency()
        self.steady_tilt: Final = steady_tilt
        self.tilt_peak: Final = Peak()
        """Of the counted errors, as in ``errors``."""
        self.heading_peak: Final = Peak()
        self.outside = 0
        """Counted attitudes before the first or after the last sample of the reference."""
        self.uneven = 0
        """Counted attitudes where the reference could not be bridged between its samples."""
        self._reference: Final = reference
        self._sink: Final = sink
        self._waiting: Final[RingBuffer[Attitude]] = RingBuffer()

    def add(self, attitude: Attitude) -> None:
        """Take the next attitude."""
        waiting = self._waiting
        while waiting.count > 0 and not 0 <= attitude.t_ns - waiting.oldest.t_ns <= MEMORY_NS:
            self._compare(waiting.pop_oldest())
        waiting.append(attitude)
        self.settle()

    def settle(self) -> None:
        """Compare the attitudes that the reference has passed; to be called when the reference has grown."""
        waiting = self._waiting
        while waiting.count > 0 and self._reference.reaches(waiting.oldest.t_ns):
            self._compare(waiting.pop_oldest())

    def finish(self) -> None:
        """Compare the attitudes that still wait: the log has ended."""
        while self._waiting.count > 0:
            self._compare(self._waiting.pop_oldest())

    def _compare(self, attitude: Attitude) -> None:
        if attitude.counted:
            self.consistency.take_step(attitude.tilt_sigma, attitude.innovations)
        tilt: float | None = None
        heading: float | None = None
        knot = self._reference.at(attitude.t_ns)
        if knot is not None:
            tilt = tilt_between(attitude.q_nb, knot.q_nb)
            if attitude.north == North.TRUE:
                heading = heading_between(attitude.q_nb, knot.q_nb)
            if attitude.counted:
                self._count(attitude, tilt, heading)
                if self.steady_tilt is not None:
                    self.steady_tilt.add(attitude.q_nb, knot.q_nb)
        elif attitude.counted:
            self._miss(attitude)
        if self._sink is not None:
            truth = None if knot is None else knot.q_nb
            self._sink.write(ComparedAttitude(self.name, attitude, tilt, heading, truth))

    def _miss(self, attitude: Attitude) -> None:
        """Count an attitude that has no reference."""
        if self._reference.lack(attitude.t_ns) == Lack.UNEVEN:
            self.uneven += 1
        else:
            self.outside += 1

    def _count(self, attitude: Attitude, tilt: float, heading: float | None) -> None:
        """Add the errors (rad) to the figures."""
        self.errors.add(tilt, heading, attitude.tilt_sigma < SURE)
        self.tilt_peak.take(tilt, attitude.elapsed_s)
        self.consistency.tilt.add(tilt, attitude.tilt_sigma)
        if heading is not None:
            self.heading_peak.take(heading, attitude.elapsed_s)
            self.consistency.heading.add(heading, attitude.heading_sigma)

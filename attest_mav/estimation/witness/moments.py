"""The last seconds of a lane: samples and inputs, and now and then a state, so that they can be run again."""

from collections.abc import Iterator
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.estimation.witness.flight_state import velocity_of
from attest_mav.filters.base import FilterInputs, FilterState
from attest_mav.record import Record
from attest_mav.ring_buffer import RingBuffer
from attest_mav.samples import ImuSample
from attest_mav.types import Vec3

LENGTH_NS: Final = 11_000_000_000
"""How far back a lane can be run again."""
STATE_SPACING_NS: Final = 100_000_000
"""A state is kept so often: to run again from an instant begins at the last one before it. All of them would be most
of the daemon's memory."""


@mypyc_attr(acyclic=True)  # as Sample
class Instant(Record):
    """One sample of a lane. Its inputs have the newest fix as it came, used or not."""

    def __init__(self, t_ns: int, dt_s: float, sample: ImuSample, inputs: FilterInputs) -> None:
        self.t_ns: Final = t_ns
        self.dt_s: Final = dt_s
        """The step that led here, s."""
        self.sample: Final = sample
        self.inputs: Final = inputs


@mypyc_attr(acyclic=True, free_list_len=1)
class Moment(Instant):
    """The newest sample of a lane."""

    def __init__(
        self, t_ns: int, dt_s: float, sample: ImuSample, inputs: FilterInputs, before: FilterState, state: FilterState
    ) -> None:
        super().__init__(t_ns, dt_s, sample, inputs)
        self.before: Final = before
        """The state before the step."""
        self.state: Final = state
        """The state after it."""


@mypyc_attr(acyclic=True, free_list_len=1)
class PastInstant(Instant):
    """A sample that is remembered."""

    def __init__(
        self,
        t_ns: int,
        dt_s: float,
        sample: ImuSample,
        inputs: FilterInputs,
        velocity: Vec3,
        before: FilterState | None,
    ) -> None:
        super().__init__(t_ns, dt_s, sample, inputs)
        self.velocity: Final = velocity
        """The filter's own velocity after the step, NED, m/s."""
        self.before: Final = before
        """The state before the step where it is kept, else None."""


class Moments:
    """A ring of instants, at most ``LENGTH_NS`` long; the first of them has a state."""

    def __init__(self) -> None:
        self.newest: Moment | None = None
        """The last moment."""
        self._ring: Final[RingBuffer[PastInstant]] = RingBuffer()
        self._kept_ns = 0
        self._last_ns = 0

    def append(self, moment: Moment) -> None:
        """Take the next moment. A clock that goes back begins anew."""
        ring, t_ns = self._ring, moment.t_ns
        if ring.count > 0 and t_ns <= self._last_ns:
            ring.clear()
        self._last_ns = t_ns
        is_kept = ring.count == 0 or t_ns - self._kept_ns >= STATE_SPACING_NS
        if is_kept:
            self._kept_ns = t_ns
        velocity = velocity_of(moment.state)
        before = moment.before if is_kept else None
        ring.append(PastInstant(t_ns, moment.dt_s, moment.sample, moment.inputs, velocity, before))
        self.newest = moment
        oldest = ring.oldest
        while t_ns - oldest.t_ns > LENGTH_NS or oldest.before is None:
            ring.pop_oldest()
            oldest = ring.oldest

    @property
    def oldest(self) -> PastInstant | None:
        """The first instant that is remembered."""
        return self._ring.oldest if self._ring.count > 0 else None

    def since(self, t_ns: int) -> Iterator[PastInstant]:
        """The instants from the last kept state before an instant on, or from the first one, old to new."""
        ring = self._ring
        first = 0
        for index in range(ring.count - 1, -1, -1):
            past = ring.at(index)
            if past.before is not None and past.t_ns <= t_ns:
                first = index
                break
        for index in range(first, ring.count):
            yield ring.at(index)

    def around(self, t_ns: int) -> tuple[PastInstant | None, PastInstant | None]:
        """The last instant before one and the first one from it on; None where there is none."""
        after: PastInstant | None = None
        for index in range(self._ring.count - 1, -1, -1):
            past = self._ring.at(index)
            if past.t_ns < t_ns:
                return past, after
            after = past
        return None, after

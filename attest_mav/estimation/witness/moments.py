"""The last seconds of a lane: samples, inputs and states, so that any moment can be run again."""

from collections import deque
from collections.abc import Iterator
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.filters.base import FilterInputs, FilterState
from attest_mav.samples import ImuSample

LENGTH_NS: Final = 11_000_000_000
"""How far back a moment can be run again."""


@mypyc_attr(acyclic=True)  # as Sample
class Moment:
    """One sample of a lane. Its inputs have the newest fix as it came, used or not."""

    def __init__(
        self, t_ns: int, dt_s: float, sample: ImuSample, inputs: FilterInputs, before: FilterState, state: FilterState
    ) -> None:
        self.t_ns: Final = t_ns
        self.dt_s: Final = dt_s
        """The step that led here, s."""
        self.sample: Final = sample
        self.inputs: Final = inputs
        self.before: Final = before
        """The state before the step."""
        self.state: Final = state
        """The state after it."""


class Moments:
    """A ring of references, at most ``LENGTH_NS`` long."""

    def __init__(self) -> None:
        self._ring: Final[deque[Moment]] = deque()

    def append(self, moment: Moment) -> None:
        """Take the next moment. A clock that goes back begins anew."""
        ring = self._ring
        if ring and moment.t_ns <= ring[-1].t_ns:
            ring.clear()
        ring.append(moment)
        while moment.t_ns - ring[0].t_ns > LENGTH_NS:
            ring.popleft()

    def clear(self) -> None:
        """Forget everything."""
        self._ring.clear()

    @property
    def newest(self) -> Moment | None:
        """The last moment."""
        return self._ring[-1] if self._ring else None

    @property
    def oldest(self) -> Moment | None:
        """The first moment that is remembered."""
        return self._ring[0] if self._ring else None

    def since(self, t_ns: int) -> Iterator[Moment]:
        """The moments from an instant on, old to new."""
        for moment in self._ring:
            if moment.t_ns >= t_ns:
                yield moment

    def around(self, t_ns: int) -> tuple[Moment | None, Moment | None]:
        """The last moment before an instant and the first one from it on; None where there is none."""
        after: Moment | None = None
        for moment in reversed(self._ring):
            if moment.t_ns < t_ns:
                return moment, after
            after = moment
        return None, after

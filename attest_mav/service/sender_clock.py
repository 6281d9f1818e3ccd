"""Tells the vehicle's messages from those of another sender with the same ids, by the clock of the inertial samples.

A second vehicle, a replayed capture and a stale buffer come with inertial samples whose times the lane does not
believe. Whatever else arrives with them is not believed either: a message that carries a time must fit the clock of
the lane, and one without a time must not follow a sample of another clock.
"""

from typing import Final

from attest_mav.estimation.lane import Lane
from attest_mav.estimation.timebase import wrapped_difference_ns
from attest_mav.samples import Sample
from attest_mav.types import NO_TIME

NEAR_NS: Final = 2_000_000_000
"""Two messages of one clock that arrive together differ by at most this in their time stamps."""
WITH_NS: Final = 200_000_000
"""Messages that arrive within this after an inertial sample of another clock, with none of the lane's own since, come
with it."""


class SenderClock:
    """Decides on the messages of one vehicle that are not inertial."""

    def __init__(self) -> None:
        self._fitting: Final[set[str]] = set()

    def is_of(self, lane: Lane, sample: Sample) -> bool:
        """Whether a sample belongs to the sender of this lane's samples.

        A message whose time never fitted carries another clock, such as UNIX time: its time says nothing.
        """
        if lane.timebase.strayed_rx_ns >= 0 and sample.rx_ns - lane.timebase.strayed_rx_ns < WITH_NS:
            return False
        if sample.t_ns == NO_TIME:
            return True
        apart_ns = wrapped_difference_ns(sample.rx_ns - sample.t_ns, lane.timebase.difference_ns)
        if abs(apart_ns) <= NEAR_NS:
            self._fitting.add(sample.source)
            return True
        return sample.source not in self._fitting

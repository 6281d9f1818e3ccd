"""Notices two senders with the same ids, by their sequence numbers and by their clocks.

One sender has one run of sequence numbers and one difference between its clock and the host's. Two senders with the
same ids show two runs, or two differences, that alternate. Frames that come late belong to the same run a little
behind its head, so runs count as two only where they are far apart.
"""

from collections import deque
from typing import Final

SPAN_NS: Final = 5_000_000_000
"""Alternations are counted over this time."""
MIN_ALTERNATIONS: Final = 20
"""Fewer alternations within ``SPAN_NS`` are jumps of one sender: losses, late frames, a clock that was set."""
REACH: Final = 16
"""A sequence number at most this far ahead of a run continues it: frames between them were lost or are not read."""
NEAR: Final = 64
"""Runs this near to each other are one, with late frames."""
SAME_CLOCK_NS: Final = 1_500_000_000
"""Differences of clocks this near to each other are one: frames that come up to a second late show other ones too."""
STANDING_NS: Final = 500_000_000
"""Two clocks are there until they have not alternated for this long: messages of the one are then not taken for those
of the other."""
REMEMBERED_NS: Final = 10_000_000_000
"""Two senders are told for so long after the last sign of them."""


class _Alternation:
    """Counts how often frames change between two series."""

    def __init__(self) -> None:
        self._changes_ns: Final[deque[int]] = deque(maxlen=MIN_ALTERNATIONS)
        self.last = 0
        """The series of the newest frame."""

    def take(self, series: int, now_ns: int) -> bool:
        """A frame belongs to series 0 or 1; True where it changes between them, once more than one sender can."""
        if series == self.last:
            return False
        self.last = series
        changes_ns = self._changes_ns
        changes_ns.append(now_ns)
        return len(changes_ns) == MIN_ALTERNATIONS and now_ns - changes_ns[0] <= SPAN_NS


class SequenceRuns:
    """The runs of sequence numbers of one pair of ids on one link."""

    def __init__(self) -> None:
        self._heads: Final = [-1, -1]
        self._alternation: Final = _Alternation()

    def take(self, sequence: int, now_ns: int) -> bool:
        """Take a number; True where two runs alternate."""
        heads = self._heads
        series = 1
        for number in (0, 1):
            if heads[number] >= 0 and 0 < (sequence - heads[number]) & 0xFF <= REACH:
                series = number
                break
        else:
            series = 0 if heads[0] < 0 else 1
        heads[series] = sequence
        alternates = self._alternation.take(series, now_ns)
        apart = (heads[0] - heads[1]) & 0xFF
        return alternates and NEAR < apart < 256 - NEAR


class Clocks:
    """The two newest differences between the clocks of one pair of ids and the host's.

    A clock that was set, or that began anew with its autopilot, leaves a difference behind that comes no more.
    """

    def __init__(self) -> None:
        self._offsets: Final[list[int]] = []
        self._alternation: Final = _Alternation()

    def take(self, t_ns: int, now_ns: int) -> bool:
        """Take the time of a message; True where two clocks alternate."""
        offsets, offset_ns = self._offsets, now_ns - t_ns
        for series, known_ns in enumerate(offsets):
            if abs(offset_ns - known_ns) < SAME_CLOCK_NS:
                offsets[series] = offset_ns
                return self._alternation.take(series, now_ns)
        if len(offsets) < 2:
            offsets.append(offset_ns)
            series = len(offsets) - 1
        else:
            series = 1 - self._alternation.last
            offsets[series] = offset_ns
        return self._alternation.take(series, now_ns)


class IdentityWatch:
    """Everything that tells two senders with the vehicle's ids apart, on all links."""

    def __init__(self) -> None:
        self._runs: Final[dict[int, SequenceRuns]] = {}
        self._clocks: Final = Clocks()
        self._evidence = ""
        self._seen_ns = self._clocks_ns = -REMEMBERED_NS

    def frame(self, link: int, sequence: int, now_ns: int) -> None:
        """Take a frame of the vehicle's ids that is no copy of an earlier one."""
        runs = self._runs.get(link)
        if runs is None:
            runs = self._runs[link] = SequenceRuns()
        if runs.take(sequence, now_ns):
            self._evidence, self._seen_ns = "two runs of sequence numbers", now_ns

    def clock(self, t_ns: int, now_ns: int) -> None:
        """Take the time of an inertial sample."""
        if self._clocks.take(t_ns, now_ns):
            self._evidence, self._seen_ns = "two clocks", now_ns
            self._clocks_ns = now_ns

    def are_two_clocks(self, now_ns: int) -> bool:
        """Whether inertial samples of two clocks come under the same ids."""
        return now_ns - self._clocks_ns < STANDING_NS

    def evidence(self, now_ns: int) -> str:
        """What shows that there are two senders, "" where there is one."""
        return self._evidence if now_ns - self._seen_ns < REMEMBERED_NS else ""

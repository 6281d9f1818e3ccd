"""Whether the samples that come are filtered: the question behind systemd's watchdog.

A vehicle that is off, a sensor that repeats one reading and a link that holds a backlog are no failures of the daemon.
Good samples that make no estimate for long are one, which a new start may mend.
"""

from typing import Final

from attest_mav.service.snapshot import Snapshot

PATIENCE_NS: Final = 20_000_000_000
"""Good samples without an estimate for longer are a failure, ns: ten alignments of a vehicle at rest."""
SILENCE_NS: Final = 2_000_000_000
"""Without a good sample for this long none come, ns."""


class FilterWatch:
    """Looks at snapshots, at least every second."""

    def __init__(self) -> None:
        self._good = 0
        self._good_ns = -SILENCE_NS
        self._since_ns: int | None = None

    def fails(self, now: Snapshot, is_fresh: bool) -> bool:
        """Whether samples come and are not filtered. is_fresh: whether there is an estimate at present."""
        good = good_samples(now)
        if good != self._good:
            self._good, self._good_ns = good, now.now_ns
        comes = now.now_ns - self._good_ns < SILENCE_NS and now.late_by_s == 0.0
        if is_fresh or not comes:
            self._since_ns = None
            return False
        if self._since_ns is None:
            self._since_ns = now.now_ns
        return now.now_ns - self._since_ns > PATIENCE_NS


def good_samples(snapshot: Snapshot) -> int:
    """Inertial samples taken so far, less those that no filter could use."""
    return snapshot.samples - sum(
        lane.repeats + lane.rejected + lane.frozen for lane in snapshot.lanes if lane.is_primary
    )

"""The faults of each inertial stream over a recorded flight, as intervals in log time."""

from typing import Final

from attest_mav.estimation.events import LaneEvent, LaneEventKind

FAULTS: Final = {
    LaneEventKind.FAULTY: "set-aside",
    LaneEventKind.FROZEN: "frozen",
    LaneEventKind.STOPPED: "stopped",
    LaneEventKind.DELAYED: "late",
    LaneEventKind.UNCALIBRATED: "uncalibrated",
}
"""The kind of fault that begins with an event."""
ENDS: Final = {
    LaneEventKind.RETURNED: ("set-aside",),
    LaneEventKind.ALIGNED: ("frozen", "stopped"),
    LaneEventKind.GAP: ("frozen", "stopped"),
    LaneEventKind.RESTARTED: ("frozen", "stopped"),
    LaneEventKind.REBOOTED: ("set-aside", "frozen", "stopped", "late"),
    LaneEventKind.IN_TIME: ("late",),
}
"""The kinds of faults that end with an event."""


class LaneFault:
    """One fault of one stream.

    kind: one of the values of ``FAULTS``. text: the fault in words, with axis and size where they are known. begin_s,
    end_s: log time, s; ``end_s`` is None while the fault goes on.
    """

    def __init__(self, lane: str, kind: str, text: str, begin_s: float) -> None:
        self.lane: Final = lane
        self.kind: Final = kind
        self.text: Final = text
        self.begin_s: Final = begin_s
        self.end_s: float | None = None


class LaneFaults:
    """Follows the events of the lanes of one vehicle."""

    def __init__(self) -> None:
        self.faults: Final[list[LaneFault]] = []
        """All faults, in order of their beginning."""
        self._open: Final[dict[tuple[str, str], LaneFault]] = {}

    def take(self, event: LaneEvent, elapsed_s: float) -> None:
        """Take the next event, which came at this log time."""
        for ended in ENDS.get(event.kind, ()):
            fault = self._open.pop((event.lane, ended), None)
            if fault is not None:
                fault.end_s = elapsed_s
        kind = FAULTS.get(event.kind)
        if kind is not None and (event.lane, kind) not in self._open:
            begun = LaneFault(event.lane, kind, event.text, elapsed_s)
            self._open[event.lane, kind] = begun
            self.faults.append(begun)

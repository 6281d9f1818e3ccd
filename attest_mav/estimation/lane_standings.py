"""The state of each lane in words, by its events: used, aligning, frozen, stopped, or set aside with the fault."""

from typing import Final

from attest_mav.estimation.events import LaneEvent, LaneEventKind

STATES: Final = {
    LaneEventKind.ALIGNED: "used",
    LaneEventKind.RESTARTED: "aligning",
    LaneEventKind.REBOOTED: "aligning",
    LaneEventKind.STOPPED: "stopped",
    LaneEventKind.FROZEN: "frozen",
    LaneEventKind.GAP: "used",
}
"""The state of a lane that begins with each kind of event; other events leave the state as it is."""


class LaneStandings:
    """Follows the events of the lanes of one vehicle."""

    def __init__(self) -> None:
        self.states: tuple[str, ...] = ()
        """One text a lane, such as ``RAW_IMU set aside: gyro x +5.0 degrees per second off``."""
        self._by_lane: Final[dict[str, str]] = {}
        self._aside: Final[set[str]] = set()

    def take(self, event: LaneEvent) -> None:
        """Take the newest event. A lane that is set aside stays so until it returns, or its clock begins again."""
        lane, kind = event.lane, event.kind
        if kind == LaneEventKind.FAULTY:
            self._aside.add(lane)
            self._by_lane[lane] = f"set aside: {event.text}"
        elif kind == LaneEventKind.RETURNED:
            self._aside.discard(lane)
            self._by_lane[lane] = "used"
        elif kind in STATES and (lane not in self._aside or kind == LaneEventKind.REBOOTED):
            self._aside.discard(lane)
            if kind != LaneEventKind.GAP or self._by_lane.get(lane) != "aligning":
                self._by_lane[lane] = STATES[kind]
        self.states = tuple([f"{name} {state}" for name, state in self._by_lane.items()])

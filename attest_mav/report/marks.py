"""Events of a flight as marks on the time axis, in the words of the autopilot or of a lane."""

from dataclasses import dataclass, field
from typing import Final

from attest_mav.estimation.events import LaneEvent
from attest_mav.samples import Sample
from attest_mav.vehicle_reports import EstimatorNewsSample, HeartbeatSample, LandedSample, TextSample

MOST_MARKS: Final = 300
"""Marks of one origin."""
MOST_TEXTS: Final = 100
"""Other texts of the autopilot than those on its estimator."""
TEXTS: Final = "texts"
AUTOPILOT: Final = "autopilot"


@dataclass(frozen=True)
class Mark:
    """One event at one instant of log time."""

    t_s: float
    origin: str
    """``AUTOPILOT``, or the filter whose lane had the event."""
    text: str


@dataclass
class Marks:
    """All marks of a flight, in order of their arrival."""

    marks: list[Mark] = field(default_factory=list)
    left_out: int = 0
    """Events beyond ``MOST_MARKS`` of their origin, and texts beyond ``MOST_TEXTS``."""
    _counts: dict[str, int] = field(default_factory=dict)
    _armed: bool | None = None
    _mode: int | None = None
    _on_ground: bool | None = None

    def take_vehicle(self, sample: Sample, t_s: float) -> None:
        """Take a sample of the vehicle; most of them are no event."""
        if isinstance(sample, HeartbeatSample):
            self._take_heartbeat(sample, t_s)
        elif isinstance(sample, LandedSample):
            if self._on_ground not in (None, sample.on_ground):
                self._add(t_s, AUTOPILOT, "landed" if sample.on_ground else "took off")
            self._on_ground = sample.on_ground
        elif isinstance(sample, EstimatorNewsSample):
            self._add(t_s, AUTOPILOT, sample.text)
        elif isinstance(sample, TextSample):
            self._add(t_s, AUTOPILOT, sample.text, TEXTS, MOST_TEXTS)

    def take_lane(self, name: str, event: LaneEvent, t_s: float) -> None:
        """Take an event of a lane of this filter."""
        self._add(t_s, name, f"{event.lane}: {event.text}")

    def _take_heartbeat(self, sample: HeartbeatSample, t_s: float) -> None:
        if sample.armed != self._armed and (sample.armed or self._armed):
            self._add(t_s, AUTOPILOT, "armed" if sample.armed else "disarmed")
        if self._mode not in (None, sample.mode):
            self._add(t_s, AUTOPILOT, f"flight mode {sample.mode}")
        self._armed, self._mode = sample.armed, sample.mode

    def _add(self, t_s: float, origin: str, text: str, kind: str = "", most: int = MOST_MARKS) -> None:
        """Keep an event. kind: those that are counted apart, at most ``most`` of them."""
        counted = kind or origin
        count = self._counts[counted] = self._counts.get(counted, 0) + 1
        if count <= most:
            self.marks.append(Mark(t_s, origin, text))
        else:
            self.left_out += 1

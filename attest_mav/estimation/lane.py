"""One lane: one inertial sensor with its time base, its alignment and its filters.

Several filters may run on a lane to be compared; they share the samples and the alignment, nothing else.
"""

from math import atan2, isfinite
from typing import Final

from attest_mav.algebra import (
    is_finite,
    norm,
    q_continuous,
    q_heading,
    q_mul,
    q_norm,
    q_to_euler,
    rotate,
    sub,
)
from attest_mav.estimation.aiding import Aiding, AidSettings
from attest_mav.estimation.alignment import Aligner
from attest_mav.estimation.delay import DelayMeter
from attest_mav.estimation.events import Event, LaneEvent, LaneEventKind
from attest_mav.estimation.sensors import FieldMonitor, FreezeDetector, without_field
from attest_mav.estimation.timebase import StepKind, TimeBase, TimeStep
from attest_mav.filters.base import AttitudeFilter, FilterState, Start
from attest_mav.types import Estimate, ImuSample, North, Quat, Vec3

HEADING_MEMORY_S: Final = 10.0
"""Without a magnetometer for longer the heading is dead-reckoned, and no longer referred to north."""
HEADING_CAPTURE: Final = 0.09
"""rad (5 deg): a heading counts as found again when it is this near to what the field says."""


class Track:
    """One filter on a lane, with its state and what it last put out."""

    def __init__(self, attitude_filter: AttitudeFilter) -> None:
        self.filter: Final = attitude_filter
        self.state: FilterState | None = None
        self.north = North.RELATIVE
        self.output: Quat = (1.0, 0.0, 0.0, 0.0)


class Lane:
    """Samples of one source in, estimates and events out.

    Counters: samples (taken), repeats (same timestamp), late (out of order), gaps, restarts, rejected (not finite),
    frozen (repeated by a frozen sensor).
    """

    def __init__(self, source: str, filters: list[AttitudeFilter], aids: AidSettings) -> None:
        self.source: Final = source
        self.aiding: Final = Aiding(aids)
        self.samples = 0
        self.repeats = 0
        self.late = 0
        self.gaps = 0
        self.restarts = 0
        self.rejected = 0
        self.frozen = 0
        self.last_rx_ns = -1
        """Host time of the last sample that led to an estimate, -1 before the first."""
        self._tracks = [Track(one) for one in filters]
        self._timebase = TimeBase()
        self._aligner = Aligner()
        self._delay = DelayMeter()
        self._freeze = FreezeDetector()
        self._field = FieldMonitor()
        self._aligned = False
        self._is_frozen = False

    @property
    def aligned(self) -> bool:
        """True once the filters run."""
        return self._aligned

    def handle(self, sample: ImuSample) -> list[Event]:
        """Take the next sample of this source. What aids the filters was given to ``aiding`` before."""
        events: list[Event] = []
        if not is_finite(sample.gyro):
            self.rejected += 1
            return events
        step = self._timebase.advance(sample.t_ns)
        if not self._in_order(step, sample, events):
            return events
        self.samples += 1
        if self._freeze.frozen(sample, step.dt_s):
            self._hold_frozen(sample, events)
            return events
        self._is_frozen = False
        if not self._field.usable(sample, norm(sample.gyro) * step.dt_s, step.dt_s) and sample.mag is not None:
            sample = without_field(sample)
        if not self._aligned:
            self._align(sample, step.dt_s, events)
        else:
            self._step(sample, step.dt_s, events)
        if self._aligned:
            self._estimate(sample, step, events)
        return events

    def _in_order(self, step: TimeStep, sample: ImuSample, events: list[Event]) -> bool:
        """Act on what the timestamp means; False when the sample is to be dropped."""
        kind = step.kind
        if kind == StepKind.REPEAT:
            self.repeats += 1
            return False
        if kind == StepKind.LATE:
            self.late += 1
            return False
        if kind == StepKind.GAP:
            self.gaps += 1
            self._tell(events, LaneEventKind.GAP, sample, f"no samples for {step.dt_s:.2f} s")
        elif kind == StepKind.RESTART:
            self.gaps += 1
            text = f"no samples for {step.dt_s:.2f} s: aligning again"
            self._restart(sample, events, LaneEventKind.RESTARTED, text)
        elif kind == StepKind.REBOOT:
            self._restart(sample, events, LaneEventKind.REBOOTED, "the sensor clock went back: aligning again")
            for track in self._tracks:
                track.state = None
        return True

    def _restart(self, sample: ImuSample, events: list[Event], kind: LaneEventKind, text: str) -> None:
        """Begin alignment anew; the filters' last states stay for what can be kept of them."""
        self.restarts += 1
        self._aligned = False
        self._aligner = Aligner()
        if kind == LaneEventKind.REBOOTED:
            self._delay = DelayMeter()
        self._tell(events, kind, sample, text)

    def _hold_frozen(self, sample: ImuSample, events: list[Event]) -> None:
        self.frozen += 1
        if not self._is_frozen:
            self._is_frozen = True
            self._restart(sample, events, LaneEventKind.FROZEN, "the sensor repeats one reading: samples ignored")

    def _align(self, sample: ImuSample, dt_s: float, events: list[Event]) -> None:
        """Feed the aligner; start every filter once it is done."""
        start = self._aligner.add(sample, dt_s, self.aiding.stands)
        if start is None:
            return
        self._aligned = True
        for track in self._tracks:
            own = start if track.state is None else _with_memory(start, track.state, self.aiding.stands is True)
            track.state = track.filter.initial(own)
            track.north = start.north
        manner = "at rest" if start.at_rest else "in motion, or in doubt of it"
        heading = "magnetic heading" if start.north == North.MAGNETIC else "no heading: it starts at zero"
        self._tell(events, LaneEventKind.ALIGNED, sample, f"aligned {manner}, {heading}")

    def _step(self, sample: ImuSample, dt_s: float, events: list[Event]) -> None:
        """One step of every filter; one that leaves the unit sphere sends the lane back to alignment."""
        self.aiding.advance(sample, dt_s)
        for track in self._tracks:
            if track.state is None:
                continue
            aids = self.aiding.aids(sample, track.output, track.north)
            track.state = track.filter.step(track.state, dt_s, sample, aids)
            length = q_norm(track.state.q_nb)
            if not isfinite(length) or length < 0.5:
                track.state = None
                self._restart(sample, events, LaneEventKind.RESTARTED, f"{track.filter.name} failed: aligning again")
                return
            self._judge_heading(track, track.state, sample, events)
        self.aiding.given()

    def _judge_heading(self, track: Track, state: FilterState, sample: ImuSample, events: list[Event]) -> None:
        """Keep ``track.north`` true: lost after a time without field, found when field and heading agree."""
        if track.north == North.MAGNETIC:
            if self._field.absent_s > HEADING_MEMORY_S:
                track.north = North.RELATIVE
                self._tell(events, LaneEventKind.HEADING_LOST, sample, "no magnetometer: the heading drifts")
        elif sample.mag is not None and abs(_field_heading(state.q_nb, sample.mag)) < HEADING_CAPTURE:
            track.north = North.MAGNETIC
            self._tell(events, LaneEventKind.HEADING_FOUND, sample, "the heading is magnetic again")

    def _estimate(self, sample: ImuSample, step: TimeStep, events: list[Event]) -> None:
        """Append every filter's estimate at this sample."""
        self.last_rx_ns = sample.rx_ns
        declination = self.aiding.declination
        delay_s = self._delay.delay_s(step.t_ns, sample.rx_ns)
        for track in self._tracks:
            state = track.state
            if state is None:
                continue
            q_nb, north = state.q_nb, track.north
            if north == North.MAGNETIC and isfinite(declination):
                q_nb, north = q_mul(q_heading(declination), q_nb), North.TRUE
            track.output = q_continuous(q_nb, track.output)
            events.append(
                Estimate(
                    self.source,
                    track.filter.name,
                    step.t_ns,
                    sample.rx_ns,
                    track.output,
                    sub(sample.gyro, state.gyro_bias),
                    north,
                    state.tilt_sigma,
                    state.heading_sigma,
                    step.dt_s,
                    delay_s,
                )
            )

    def _tell(self, events: list[Event], kind: LaneEventKind, sample: ImuSample, text: str) -> None:
        events.append(LaneEvent(self.source, kind, sample.t_ns, sample.rx_ns, text))


def _with_memory(start: Start, before: FilterState, stands: bool) -> Start:
    """The start with what an earlier state still knows: the bias unless it surely stands, the heading if no field."""
    bias = start.gyro_bias if stands else before.gyro_bias
    q_nb = start.q_nb
    if start.north == North.RELATIVE:
        q_nb = q_mul(q_heading(q_to_euler(before.q_nb)[2]), q_nb)
    return Start(q_nb, bias, start.north, start.accel, start.mag, start.at_rest)


def _field_heading(q_nb: Quat, mag: Vec3) -> float:
    """Angle of the levelled field east of the estimate's north, rad: the heading error the field sees."""
    field = rotate(q_nb, mag)
    return atan2(field[1], field[0])

"""One lane: one inertial sensor with its time base, its alignment and its filters.

Several filters may run on a lane to be compared; they share the samples and the alignment, nothing else.
"""

from math import isfinite
from typing import Final

from attest_mav.algebra import is_finite, norm, q_norm
from attest_mav.estimation.alignment import Aligner, ecompass
from attest_mav.estimation.delay import DelayMeter
from attest_mav.estimation.events import Event, LaneEvent, LaneEventKind
from attest_mav.estimation.sensors import FieldMonitor, FreezeDetector
from attest_mav.estimation.timebase import StepKind, TimeBase, TimeStep
from attest_mav.estimation.track import Track, field_heading
from attest_mav.estimation.vehicle import Aiding, AidSettings
from attest_mav.filters.base import AttitudeFilter, FilterState, Start, VehicleFacts
from attest_mav.types import ImuSample, North

HEADING_MEMORY_S: Final = 10.0
"""Without a magnetometer for longer the heading is dead-reckoned, and no longer referred to north."""
HEADING_CAPTURE: Final = 0.09
"""rad (5 deg): a heading counts as found again when it is this near to what the field says."""

MAX_ACCEL: Final = 1e4
"""m/s^2: no reading (NaN and infinity fail the same test)."""


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
        self._tracks = [Track(one) for one in filters]
        self._timebase = TimeBase()
        self._aligner = Aligner()
        self._delay = DelayMeter()
        self._freeze = FreezeDetector()
        self._field = FieldMonitor()
        self._aligned = False
        self._is_frozen = False
        self._frozen_s = 0.0

    @property
    def aligned(self) -> bool:
        """True once the filters run that do not align themselves."""
        return self._aligned

    @property
    def rests_on(self) -> str:
        """What the first filter rests on, see ``FilterState.rests_on``; "" before it runs."""
        state = self._tracks[0].state
        return "" if state is None else state.rests_on

    def inform(self, facts: VehicleFacts) -> None:
        """Tell the filters the vehicle's settings; their states go on."""
        for track in self._tracks:
            track.inform(facts)

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
            self._hold_frozen(sample, step.dt_s, events)
            return events
        # A filter that aligns itself has to know how long it has not seen the motion.
        dt_s = step.dt_s + self._frozen_s
        self._is_frozen, self._frozen_s = False, 0.0
        if not self._field.usable(sample, norm(sample.gyro) * step.dt_s, step.dt_s) and sample.mag is not None:
            sample = sample.with_readings(sample.gyro, sample.accel, None)
        self.aiding.advance(sample, step.dt_s)
        self._step(sample, dt_s, events)
        if not self._aligned:
            self._align(sample, step.dt_s, events)
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

    def _hold_frozen(self, sample: ImuSample, dt_s: float, events: list[Event]) -> None:
        self.frozen += 1
        self._frozen_s += dt_s
        if not self._is_frozen:
            self._is_frozen = True
            self._restart(sample, events, LaneEventKind.FROZEN, "the sensor repeats one reading: samples ignored")

    def _align(self, sample: ImuSample, dt_s: float, events: list[Event]) -> None:
        """Feed the aligner; start every filter once it is done."""
        start = self._aligner.add(sample, dt_s, self.aiding.stands)
        if start is None:
            return
        self._aligned = True
        stands = self.aiding.stands is True
        ordinary = [track for track in self._tracks if not track.filter.aligns_itself]
        for track in ordinary:
            track.begin(start, stands)
        if not ordinary:
            return
        manner = "at rest" if start.at_rest else "in motion, or in doubt of it"
        heading = "magnetic heading" if start.north == North.MAGNETIC else "no heading: it starts at zero"
        self._tell(events, LaneEventKind.ALIGNED, sample, f"aligned {manner}, {heading}")

    def _step(self, sample: ImuSample, dt_s: float, events: list[Event]) -> None:
        """One step of every filter that runs; one that leaves the unit sphere sends the lane back to alignment."""
        for track in self._tracks:
            state = track.state
            if state is None:
                self._begin_by_itself(track, sample)
                continue
            if not self._aligned and not track.filter.aligns_itself:
                continue
            aids = self.aiding.aids(sample, track.output, track.north)
            state = track.filter.step(state, dt_s, sample, aids)
            track.state = state
            length = q_norm(state.q_nb)
            if not isfinite(length) or length < 0.5:
                track.state = None
                self._restart(sample, events, LaneEventKind.RESTARTED, f"{track.filter.name} failed: aligning again")
                return
            self._judge(track, state, sample, events)
        self.aiding.given()

    def _begin_by_itself(self, track: Track, sample: ImuSample) -> None:
        """Start a filter that aligns itself from one reading."""
        if track.filter.aligns_itself and 0.0 < norm(sample.accel) < MAX_ACCEL:
            q_nb, north = ecompass(sample.accel, sample.mag)
            track.begin(Start(q_nb, (0.0, 0.0, 0.0), north, sample.accel, sample.mag, False), stands=False)

    def _judge(self, track: Track, state: FilterState, sample: ImuSample, events: list[Event]) -> None:
        """Keep what the track says of itself true: whether it has settled, and what its heading refers to."""
        own_north = state.referred_to
        if own_north is None:
            self._judge_heading(track, state, sample, events)
        else:
            track.north = own_north
        if track.filter.aligns_itself and state.aligned != track.aligned:
            kind = LaneEventKind.ALIGNED if state.aligned else LaneEventKind.RESTARTED
            text = "has found its attitude" if state.aligned else "has lost its attitude: aligning again"
            self._tell(events, kind, sample, f"{track.filter.name} {text}")
        track.aligned = state.aligned

    def _judge_heading(self, track: Track, state: FilterState, sample: ImuSample, events: list[Event]) -> None:
        """Keep ``track.north`` true: lost after a time without field, found when field and heading agree."""
        if track.north == North.MAGNETIC:
            if self._field.absent_s > HEADING_MEMORY_S:
                track.north = North.RELATIVE
                self._tell(events, LaneEventKind.HEADING_LOST, sample, "no magnetometer: the heading drifts")
        elif sample.mag is not None and abs(field_heading(state.q_nb, sample.mag)) < HEADING_CAPTURE:
            track.north = North.MAGNETIC
            self._tell(events, LaneEventKind.HEADING_FOUND, sample, "the heading is magnetic again")

    def _estimate(self, sample: ImuSample, step: TimeStep, events: list[Event]) -> None:
        """Append every filter's estimate at this sample."""
        delay_s = self._delay.delay_s(step.t_ns, sample.rx_ns)
        declination = self.aiding.field.declination
        for track in self._tracks:
            state = track.state
            runs = self._aligned or track.filter.aligns_itself
            if state is not None and runs and state.aligned:
                events.append(track.estimate(self.source, state, sample, step.t_ns, step.dt_s, delay_s, declination))

    def _tell(self, events: list[Event], kind: LaneEventKind, sample: ImuSample, text: str) -> None:
        events.append(LaneEvent(self.source, kind, sample.t_ns, sample.rx_ns, text))

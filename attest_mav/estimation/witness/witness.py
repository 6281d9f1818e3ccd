"""The witness: holds the set of attitudes that are not refuted, selects one, and sets faulty sensors aside.

The pipeline gives every lane the steps of ``watch``, and calls ``advance`` after each of its samples. The selected
lane changes only when it is set aside, stops, or loses its attitude.
"""

from math import radians
from typing import Final

from attest_mav.estimation.difference import Member
from attest_mav.estimation.events import Event, LaneEvent, LaneEventKind
from attest_mav.estimation.witness.bias_scale import follow_scale
from attest_mav.estimation.witness.compass_readings import CompassReadings
from attest_mav.estimation.witness.dispute import LanePair
from attest_mav.estimation.witness.doubt import Doubt
from attest_mav.estimation.witness.flight_state import accel_bias, on_another_sensor
from attest_mav.estimation.witness.lane_watch import LaneWatch
from attest_mav.estimation.witness.members import candidate_member, is_near, lane_member
from attest_mav.estimation.witness.moments import Moment
from attest_mav.estimation.witness.naming import sensor_text
from attest_mav.estimation.witness.pair_noise import follow_noise, is_due
from attest_mav.estimation.witness.receiver_monitor import ReceiverMonitor
from attest_mav.estimation.witness.situation import Situation, Standing

STOPPED_S: Final = 0.25
STOPPED_STEPS: Final = 3.0
"""A lane has stopped when another one is ahead of it by both."""
ALONE_S: Final = 2.0
"""A sensor that was set aside is used again when every other one has stopped for longer."""
JOINING_TILT: Final = radians(2.0)
"""rad: a new lane joins the set when its sigma is below this, or when there is none in it."""
RETURN_BIAS: Final = radians(0.05)
"""rad/s: of the gyro's bias of a sensor that returns."""


class Witness:
    """Any number of lanes of one vehicle, all with a velocity-aided filter."""

    def __init__(self) -> None:
        self.selected = ""
        """Name of the lane that is shown."""
        self.members: tuple[Member, ...] = ()
        """The other attitudes of the set, beside the selected lane's newest one."""
        self.publishes = False
        """Whether nothing contradicts the selected attitude, so that it may be published."""
        self.compasses: Final = CompassReadings()
        """The newest readings of all magnetometers."""
        self._lanes: Final[dict[str, LaneWatch]] = {}
        self._order: Final[list[LaneWatch]] = []
        """The same lanes, in the order in which they began."""
        self._pairs: Final[list[LanePair]] = []
        self._doubt: Final = Doubt()
        self._receiver: Final = ReceiverMonitor(self._doubt)
        self._doubted = False

    @property
    def doubts(self) -> bool:
        """True while neither agreement nor disagreement can be said."""
        return self._doubted

    def fault_of(self, name: str) -> str:
        """Why this lane stands aside, "" while it does not."""
        lane = self._lanes.get(name)
        return lane.aside_reason if lane is not None and lane.standing == Standing.ASIDE else ""

    def watch(self, name: str) -> LaneWatch:
        """A new lane; the first one is selected until another is better."""
        lane = LaneWatch(name)
        self._pairs.extend([LanePair(other, lane) for other in self._order])
        self._lanes[name] = lane
        self._order.append(lane)
        self.selected = self.selected or name
        return lane

    def advance(self, name: str, events: list[Event]) -> None:
        """Follow a lane to its newest sample; what follows from it is added to the events."""
        lane = self._lanes[name]
        moment = lane.moments.newest
        if moment is None:
            return
        self._judge_standing(lane, moment, events)
        self._compare(lane, moment, events)
        self._select()
        selected = self._lanes[self.selected]
        self.compasses.take(lane, selected)
        if lane is selected and lane.standing == Standing.GOOD:
            disputed = any(pair.dispute is not None for pair in self._pairs)
            good = self._good()
            event = self._receiver.take(lane, good, disputed)
            if event is not None:
                events.append(event)
            if not any(one.field_fits for one in good):
                self._doubt.field_contradicts(moment.t_ns)
            self._form_set(lane, good, moment, disputed)
        elif selected.standing != Standing.GOOD:
            self.members, self.publishes = (), False
        self._set_situation()

    def _good(self) -> list[LaneWatch]:
        return [lane for lane in self._order if lane.standing == Standing.GOOD]

    def _judge_standing(self, lane: LaneWatch, moment: Moment, events: list[Event]) -> None:
        """Whether a lane joins the set, has lost its attitude, is dead, or leaves others behind that have stopped."""
        good = self._good()
        if lane.standing == Standing.ASIDE and not lane.dead.reason and self._is_alone(lane, moment):
            lane.begin_again()
            events.append(_event(lane, moment, LaneEventKind.RETURNED, "the only sensor left: its filter begins again"))
        if lane.standing == Standing.NEW and lane.is_navigating:
            if not good or moment.state.tilt_sigma < JOINING_TILT:
                lane.standing = Standing.GOOD
        elif lane.standing == Standing.GOOD and not lane.is_navigating:
            lane.standing = Standing.NEW
            self._end_disputes(lane)
            for pair in self._pairs:
                pair.has_scale = pair.has_scale and not pair.has(lane)
            self._receiver.abandon(lane)
        if lane.standing == Standing.GOOD and lane.dead.reason and self._another(lane) is not None:
            self._set_aside(lane, moment, lane.dead.reason, events)
        for other in good:
            newest = other.moments.newest
            if other is lane or newest is None or lane.standing != Standing.GOOD:
                continue
            behind_s = (moment.t_ns - newest.t_ns) * 1e-9
            if behind_s > max(STOPPED_S, STOPPED_STEPS * newest.dt_s):
                self._set_aside(other, moment, f"no samples for {behind_s:.2f} s", events)

    def _another(self, lane: LaneWatch) -> LaneWatch | None:
        """Another lane in good standing that is not dead."""
        return next((one for one in self._good() if one is not lane and not one.dead.reason), None)

    def _is_alone(self, lane: LaneWatch, moment: Moment) -> bool:
        """Whether every other sensor has stopped."""
        others = [one.moments.newest for one in self._order if one is not lane]
        return all(newest is None or moment.t_ns - newest.t_ns > ALONE_S * 1e9 for newest in others)

    def _compare(self, lane: LaneWatch, moment: Moment, events: list[Event]) -> None:
        """Compare a lane with every other one."""
        for pair in self._pairs:
            if not pair.has(lane):
                continue
            paired = pair.pair_up()
            standings = (pair.first.standing, pair.second.standing)
            if standings == (Standing.GOOD, Standing.GOOD):
                if paired:
                    follow_scale(pair)
                    self._dispute(pair, moment, events)
                    self._follow_noise(pair)
                self._find_guilt(pair, moment, events)
            elif paired and Standing.ASIDE in standings and Standing.GOOD in standings:
                aside = pair.first if pair.first.standing == Standing.ASIDE else pair.second
                if pair.other(aside).name == self.selected and pair.aside_is_well(aside, moment.t_ns):
                    self._take_back(aside, pair, events)

    def _dispute(self, pair: LanePair, moment: Moment, events: list[Event]) -> None:
        before = pair.dispute
        pair.compare(moment.t_ns)
        if before is None and pair.dispute is not None and pair.contrast is not None:
            text = f"{pair.first.name} and {pair.second.name} differ: {pair.contrast.text}"
            events.append(_event(pair.first, moment, LaneEventKind.DISPUTED, text))

    def _follow_noise(self, pair: LanePair) -> None:
        """A fault is no noise: only in good order do both lanes take what their sensors differ by."""
        if not (is_due(pair.first) or is_due(pair.second)):
            return
        in_order = all(lane.standing == Standing.GOOD and not lane.dead.reason for lane in self._order)
        if in_order and all(one.dispute is None for one in self._pairs):
            follow_noise(pair, pair.first)
            follow_noise(pair, pair.second)

    def _find_guilt(self, pair: LanePair, moment: Moment, events: list[Event]) -> None:
        used = self._receiver.is_used
        pair.weigh(moment.t_ns, used)
        lane = pair.guilty(moment.t_ns, used)
        dispute = pair.dispute
        if lane is not None and dispute is not None:
            gyro, accel = pair.excess_of(lane)
            elapsed_s = (moment.t_ns - dispute.opened_ns) * 1e-9
            text = f"{sensor_text(gyro, accel)} (evidence {abs(dispute.evidence):.1f} after {elapsed_s:.1f} s)"
            self._set_aside(lane, moment, text, events)

    def _set_aside(self, lane: LaneWatch, moment: Moment, reason: str, events: list[Event]) -> None:
        """A sensor is at fault: its filter stands still from now on."""
        lane.standing = Standing.ASIDE
        lane.aside_reason = reason
        oldest = lane.moments.oldest
        if oldest is not None and oldest.before is not None:
            lane.gyro_bias, lane.accel_bias = oldest.before.gyro_bias, accel_bias(oldest.before)
            lane.before_fault = oldest.before
        self._end_disputes(lane)
        for pair in self._pairs:
            if pair.has(lane):
                pair.begin_watching(moment.t_ns)
        self._receiver.abandon(lane)
        events.append(_event(lane, moment, LaneEventKind.FAULTY, reason))

    def _end_disputes(self, lane: LaneWatch) -> None:
        for pair in self._pairs:
            if pair.has(lane):
                pair.end()

    def _take_back(self, aside: LaneWatch, pair: LanePair, events: list[Event]) -> None:
        """A sensor is well again: its filter goes on from the healthy one's state."""
        healthy, one = pair.other(aside).state, pair.other(aside).filter
        newest = aside.moments.newest
        own = aside.state if aside.before_fault is None else aside.before_fault
        if healthy is None or one is None or own is None or newest is None:
            return
        more = pair.reads_more(aside)
        aside.adopt(on_another_sensor(one, healthy, own, more.gyro, more.accel, RETURN_BIAS**2))
        aside.standing = Standing.GOOD
        pair.end()
        events.append(_event(aside, newest, LaneEventKind.RETURNED, "reads like the other sensor again: it is used"))

    def _select(self) -> None:
        """Keep the selected lane while it is in good standing; one that is not proven yields to an earlier one.

        The streams start one after the other, so that chance would tell which of them is aligned first.
        """
        selected = self._lanes[self.selected]
        if selected.standing == Standing.GOOD and selected.proving.done:
            return
        for lane in self._good():
            self.selected = lane.name
            return

    def _form_set(self, selected: LaneWatch, good: list[LaneWatch], moment: Moment, disputed: bool) -> None:
        """The members beside the selected attitude, and whether that may be published."""
        members: list[Member] = []
        for lane in good:
            member = None if lane is selected else lane_member(moment, lane)
            if member is not None:
                members.append(member)
        candidates = self._receiver.candidates()
        members += [candidate_member(moment, candidate) for candidate in candidates]
        self.members = tuple(members)
        self._doubted = self._doubt.active(moment.t_ns) or bool(selected.dead.reason)
        state = moment.state
        together = not (disputed or candidates) or all(is_near(state, member) for member in members)
        self.publishes = not self._doubted and together

    def _set_situation(self) -> None:
        """Tell every lane what to do with fixes, where that has changed."""
        receiver = self._receiver
        calm = receiver.is_used and all(pair.dispute is None for pair in self._pairs)
        for lane in self._order:
            known, used = lane.situation, receiver.is_used
            if known.calm != calm or known.receiver_used != used or known.fix_shift_s != receiver.shift_s:
                lane.situation = Situation(calm, used, receiver.shift_s)


def _event(lane: LaneWatch, moment: Moment, kind: LaneEventKind, text: str) -> LaneEvent:
    return LaneEvent(lane.name, kind, moment.t_ns, moment.sample.rx_ns, text)

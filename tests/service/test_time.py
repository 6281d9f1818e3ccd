"""Time on a live link: what is old is never published as fresh, and no single time stamp is believed."""

from itertools import pairwise
from struct import pack_into, unpack_from

import pytest

from attest_mav.config.parsing import parse_config
from attest_mav.mavlink.component.encoder import Encoder
from attest_mav.mavlink.wire.checksum import with_checksum
from attest_mav.sim.fault_text import parse_faults
from attest_mav.sim.settings import SimSettings

from .conftest import SECOND, Flight, message_id

BOOT, CALIBRATING, ACTIVE = 1, 2, 4
RAW_IMU, GPS_RAW_INT, ATTITUDE, TIMESYNC = 27, 24, 30, 111
ONE_SENSOR = "[streams]\nfurther_imu_messages = []\n"

STEP_NS = 2_000_000
"""Of virtual time."""
LIMIT_S = 0.5
"""The default of ``estimate.stale_s``."""
ROUNDING_S = 0.011
"""time_boot_ms is cut to milliseconds, and half of the round trip, an interval of 20 ms at most, is not known."""


class Line(Flight):
    """A flight over a line that delays and edits. ``stops``: when the vehicle's process stands still, s."""

    def __init__(self, dialect, config, settings):
        super().__init__(dialect, config, settings)
        self.delay_s = lambda _t_s: 0.0
        """Of a frame that is sent at t_s, s; frames do not overtake each other."""
        self.edit = lambda _t_s, frame: [frame]
        """The frames that are delivered instead of one."""
        self.stops = []
        self.speed = 1.0
        """Of the vehicle's clock."""
        self._queue = []

    def vehicle_ns(self, now_ns):
        stopped = sum(min(max(now_ns - round(a * SECOND), 0), round((b - a) * SECOND)) for a, b in self.stops)
        return round((now_ns - stopped) * self.speed)

    def run_until(self, t_s):
        end_ns = round(t_s * SECOND)
        while self.now_ns < end_ns:
            self.now_ns = min(self.now_ns + STEP_NS, end_ns)
            for frame in self.vehicle.frames_until(self.vehicle_ns(self.now_ns)):
                if message_id(frame) in self.deaf_to:
                    continue
                now_s = self.now_ns / SECOND
                due_ns = self.now_ns + round(self.delay_s(now_s) * SECOND)
                if self._queue:
                    due_ns = max(due_ns, self._queue[-1][0])
                self._queue += [(due_ns, one) for one in self.edit(now_s, frame)]
            while self._queue and self._queue[0][0] <= self.now_ns:
                self.service.receive(0, self._queue.pop(0)[1], self.now_ns)
                self._exchange()
            if self.service.due_ns <= self.now_ns:
                self.service.poll(self.now_ns)
                self._exchange()

    def _exchange(self):
        now_ns, self.now_ns = self.now_ns, self.vehicle_ns(self.now_ns)
        before = len(self.heard)
        super()._exchange()
        self.now_ns = now_ns
        self.heard[before:] = [(now_ns / SECOND, message) for _, message in self.heard[before:]]

    def published(self, begin_s=0.0, end_s=1e9):
        """When attitudes were sent, and how old they were by the vehicle's clock, s."""
        return [
            (t_s, (self.vehicle_ns(round(t_s * SECOND)) - self.vehicle.boot_ns) / SECOND - one.time_boot_ms / 1000)
            for t_s, one in self.heard
            if one.get_type() == "ATTITUDE_QUATERNION" and begin_s <= t_s < end_s
        ]

    def oldest_s(self, begin_s=0.0, end_s=1e9):
        return max([age_s for _, age_s in self.published(begin_s, end_s)], default=0.0)

    def first_s(self, begin_s):
        """When the first attitude after that was sent, s."""
        return self.published(begin_s)[0][0]

    def longest_gap_s(self, begin_s, end_s):
        times = [begin_s, *[t_s for t_s, _ in self.published(begin_s, end_s)], end_s]
        return max(b - a for a, b in pairwise(times))


@pytest.fixture
def line(dialect):
    def make(toml="", scenario="square", rate_hz=50.0, faults=()):
        settings = SimSettings(scenario=scenario, fast_rate_hz=rate_hz, faults=parse_faults(faults))
        return Line(dialect, parse_config(f"[[link]]\nurl = 'udpin::0'\n{toml}", "test"), settings)

    return make


ANSWERED = pytest.mark.parametrize("answered", [True, False], ids=["timesync", "no-timesync"])


def silence(f, answered):
    if not answered:
        f.deaf_to.add(TIMESYNC)


@ANSWERED
@pytest.mark.parametrize("growth", [0.1, 0.4, 0.9])
def test_a_backlog_that_grows_slowly_is_never_published_as_fresh(line, growth, answered):
    f = line(ONE_SENSOR)
    silence(f, answered)
    f.delay_s = lambda t_s: growth * max(0.0, t_s - 10.0)
    f.run_until(10.0 + 1.2 * (1.0 + growth) / growth)
    assert f.published(10.0), "what is not old yet is sent"
    # Without answers a clock that runs slow by a thousandth cannot be told from a delay that grows.
    assert f.oldest_s() < LIMIT_S + ROUNDING_S + (0.0 if answered else 0.001 * (f.now_ns / SECOND - 10.0))
    assert any("RAW_IMU: samples come 0." in text and text.endswith("s late") for text in f.texts)
    assert any(text.startswith("attitude withheld: samples come") for text in f.texts)
    assert "nothing is sent: samples come 1." in f.status()
    assert f.snapshot().late_by_s == pytest.approx(1.2, abs=0.03 if answered else 0.1)
    assert f.states()[-1] == CALIBRATING


@ANSWERED
def test_a_delay_that_stays_is_not_forgotten_and_what_ends_it_is_noticed(line, answered):
    f = line(ONE_SENSOR)
    silence(f, answered)
    f.delay_s = lambda t_s: 2.0 if 10.0 <= t_s < 40.0 else 0.0
    f.run_until(39.0)
    assert f.published(10.5) == []
    assert f.snapshot().late_by_s == pytest.approx(2.0, abs=0.1)
    f.run_until(46.0)
    assert f.first_s(10.5) < 42.0 + 1.0, "the last delayed frame comes at 42 s"
    assert f.oldest_s(10.5) < LIMIT_S + ROUNDING_S + (0.0 if answered else 0.001 * 30.0)
    assert any("samples come in time again; they were up to 2.0" in text for text in f.texts)


def test_a_delay_that_is_there_from_the_start_is_measured_by_timesync(line):
    f = line()
    f.delay_s = lambda _t_s: 1.4
    f.run_until(15.0)
    assert f.published(4.0) == []
    assert f.snapshot().late_by_s == pytest.approx(0.7, abs=0.05), "half of the round trip: the way there took none"


@pytest.mark.parametrize("pause_s", [0.3, 1.0, 5.0, 60.0])
def test_a_pause_of_the_autopilots_clock_costs_less_than_a_second_after_it(line, pause_s):
    f = line()
    f.stops = [(10.0, 10.0 + pause_s), (20.0 + pause_s, 20.0 + 2 * pause_s)]
    f.run_until(30.0 + 2 * pause_s)
    for _, end_s in f.stops:
        assert f.first_s(end_s - 0.001) < end_s + 1.0
    assert f.longest_gap_s(11.0 + pause_s, 20.0 + pause_s) < 0.15
    assert f.oldest_s() < 0.05
    assert [lane.restarts for lane in f.snapshot().lanes] == [0, 0]
    assert f.errors_deg(6.0)[0] < 1.0
    assert f.states()[-1] == ACTIVE


def test_a_pause_without_timesync_stays_a_delay(line):
    """Nothing tells the clock that stood still from a link that became slower: what may be old is not published."""
    f = line(ONE_SENSOR)
    f.deaf_to.add(TIMESYNC)
    f.stops = [(10.0, 15.0)]
    f.run_until(40.0)
    assert f.published(10.1) == []
    assert "nothing is sent: samples come 4.9" in f.status(), "a thousandth of the time since is forgiven"
    assert any("TIMESYNC is not answered" in text for text in f.texts)


def test_a_simulator_that_runs_slower_than_time_is_no_delay(line):
    f = line(ONE_SENSOR)
    f.speed = 0.66
    f.run_until(30.0)
    assert f.longest_gap_s(10.0, 30.0) < 0.3
    assert [text for text in f.texts if "late" in text] == []


STAMPED = {
    RAW_IMU: ("RAW_IMU", "<Q", 1e-6),
    GPS_RAW_INT: ("GPS_RAW_INT", "<Q", 1e-6),
    ATTITUDE: ("ATTITUDE", "<I", 1e-3),
    TIMESYNC: ("TIMESYNC", "<q", 1e-9),
}
"""Messages that begin with a time stamp, with its unit, s."""


def renumbered(frame, dialect):
    """The frame under another sequence number."""
    head = bytearray(frame[:-2])
    head[4] = (head[4] + 100) % 256
    return with_checksum(bytes(head), dialect.by_id[message_id(frame)].crc_extra)


def restamped(frame, dialect, error_s):
    """A frame with another time stamp."""
    name, code, unit = STAMPED[message_id(frame)]
    layout = dialect.layout(name)
    payload = bytearray(frame[10:-2].ljust(layout.size, b"\0"))
    pack_into(code, payload, 0, max(0, unpack_from(code, payload)[0] + round(error_s / unit)))
    encoder = Encoder(dialect, 1, 1)
    encoder._sequence = frame[4]
    return encoder.frame(layout, bytes(payload))


def once_in(period_s, makes):
    """An edit that replaces one RAW_IMU in each period from 8 to 18 s by what ``makes`` makes of it."""
    due = [8.0]

    def edit(t_s, frame):
        if message_id(frame) != RAW_IMU or not due[0] <= t_s < 18.0:
            return [frame]
        due[0] += period_s
        return makes(frame)

    return edit


@pytest.mark.parametrize("beside", [True, False], ids=["forged", "damaged"])
@pytest.mark.parametrize("error_s", [-1000.0, -5.0, -0.9, -0.03, 0.03, 0.9, 5.0, 1e4])
def test_one_wrong_time_stamp_changes_nothing(line, dialect, error_s, beside):
    f = line(ONE_SENSOR)

    def wrong(frame):
        return [restamped(frame, dialect, error_s), *([frame] if beside else [])]

    f.edit = once_in(1.0, wrong)
    f.run_until(20.0)
    (lane,) = f.snapshot().lanes
    assert lane.restarts == 0
    assert f.longest_gap_s(6.0, 20.0) < 0.15
    assert f.oldest_s() < 0.05
    assert f.errors_deg(6.0)[0] < 1.0
    assert [text for text in f.texts if "went back" in text or "aligning again" in text] == []


@pytest.mark.parametrize("rate_hz", [50.0, 200.0])
@pytest.mark.parametrize("stretch_s", [0.06, 0.25, 0.5])
def test_a_stretch_that_comes_twice_costs_no_state(line, dialect, rate_hz, stretch_s):
    """The second time under other sequence numbers: as copies of the same frames they would not reach the lane."""
    f = line(f"{ONE_SENSOR}imu_hz = {rate_hz}", rate_hz=rate_hz)
    past = []

    def again(frame):
        return [frame, *[renumbered(one, dialect) for t_s, one in past if t_s > past[-1][0] - stretch_s]]

    repeat = once_in(1.0, again)

    def edit(t_s, frame):
        past.append((t_s, frame))
        return repeat(t_s, frame)

    f.edit = edit
    f.run_until(20.0)
    (lane,) = f.snapshot().lanes
    assert lane.restarts == 0
    assert lane.late + lane.repeats >= 9 * stretch_s * rate_hz
    assert f.longest_gap_s(6.0, 20.0) < 0.15
    assert f.errors_deg(6.0)[0] < 1.0


@pytest.mark.parametrize(("spread_s", "gap_s"), [(0.1, 0.3), (0.5, 4.0)])
def test_disorder_costs_no_state(line, spread_s, gap_s):
    """Of three frames one is in time, the next late by half of the spread, the third by all of it.

    With half a second three of five samples are lost, and our own sigma withholds the attitude for a while.
    """
    f = line(ONE_SENSOR)
    held, count = [], [0]

    def edit(t_s, frame):
        if not 8.0 <= t_s < 18.0:
            return [frame]
        count[0] += 1
        held.append((t_s + (0.0, 0.5, 1.0)[count[0] % 3] * spread_s, count[0], frame))
        held.sort()
        ready = [one for one in held if one[0] <= t_s]
        del held[: len(ready)]
        return [one for _, _, one in ready]

    f.edit = edit
    f.run_until(20.0)
    (lane,) = f.snapshot().lanes
    assert lane.restarts == 0
    assert lane.late > 150
    assert f.longest_gap_s(6.0, 20.0) < gap_s
    assert f.oldest_s() < LIMIT_S + ROUNDING_S
    assert f.errors_deg(6.0)[0] < 2.0


def test_a_reboot_is_recognised_within_a_second_of_its_first_sample(line):
    f = line(faults=["reboot@12"])
    first = []

    def edit(t_s, frame):
        if message_id(frame) == RAW_IMU and t_s > 12.1:
            first.append(t_s)
        return [frame]

    f.edit = edit
    f.run_until(14.0)
    while not any("went back" in text for text in f.texts):
        f.run_until(f.now_ns / SECOND + 0.05)
        assert f.now_ns < 20 * SECOND
    assert f.now_ns / SECOND - first[0] < 1.0
    f.run_until(25.0)
    assert f.oldest_s(13.0) < 0.05
    assert f.first_s(13.0) < first[0] + 2.5
    assert f.errors_deg(20.0)[0] < 1.0


@pytest.mark.parametrize("jump_s", [-8.0, -5.0, -0.8, 0.3, 5.0, 1000.0])
def test_a_clock_that_is_set_costs_three_seconds_at_most(line, dialect, jump_s):
    """Six tenths of a second confirm the new value; the new alignment, and trust in it, take the rest."""
    f = line(ONE_SENSOR)
    f.edit = lambda t_s, frame: (
        [restamped(frame, dialect, jump_s)] if message_id(frame) in STAMPED and t_s >= 10.0 else [frame]
    )
    f.run_until(20.0)
    assert f.longest_gap_s(6.0, 20.0) < 3.0


def questions(f, begin_s, end_s):
    return [one for one in f.of_type("TIMESYNC", begin_s, end_s) if one.tc1 == 0]


def test_the_autopilot_is_asked_often_at_first_and_seldom_then(line):
    f = line(scenario="still")
    f.run_until(43.0)
    assert len(questions(f, 0.0, 2.5)) == pytest.approx(9, abs=1)
    assert len(questions(f, 3.0, 43.0)) == pytest.approx(8, abs=1)
    clock = f.snapshot().clock
    assert clock.answers == len(questions(f, 0.0, 43.0))
    assert 0.0 < clock.round_trip_s < 0.02
    assert (clock.skew, clock.jumps) == (pytest.approx(0.0, abs=1e-4), 0)
    silent = line("[estimate]\ntimesync = false")
    silent.run_until(5.0)
    assert silent.of_type("TIMESYNC") == []


def test_answers_to_others_and_of_others_are_no_exchange(line):
    f = line(scenario="still")
    f.run_until(10.0)
    before = f.snapshot().clock
    ours = questions(f, 0.0, 10.0)[-1].ts1
    for sender, ts1_ns in (((1, 1), 123), ((1, 100), ours), ((9, 1), ours), ((1, 1), ours)):
        f.service.receive(0, Encoder(f.vehicle.dialect, *sender).timesync(77, ts1_ns), f.now_ns)
    assert f.snapshot().clock == before, "the vehicle has answered that question already"


@pytest.mark.parametrize(
    ("target", "answers"), [((0, 0), 1), ((1, 193), 1), ((1, 0), 1), ((0, 193), 1), ((1, 1), 0), ((2, 193), 0)]
)
def test_questions_to_us_and_to_all_are_answered_with_our_clock(line, target, answers):
    f = line(scenario="still")
    f.run_until(5.0)
    heard = len(f.of_type("TIMESYNC"))
    f.service.receive(0, Encoder(f.vehicle.dialect, 255, 190).timesync(0, 4711, *target), f.now_ns)
    sent = f.service.take_frames(0)
    assert len(sent) == answers
    if answers:
        tc1_ns, ts1_ns = unpack_from("<qq", sent[0], 10)
        assert (message_id(sent[0]), tc1_ns, ts1_ns) == (TIMESYNC, f.now_ns, 4711)
        assert sent[0][26:28] == bytes((255, 190)), "the one who asks"
    assert len(f.of_type("TIMESYNC")) == heard


def test_answers_are_limited_and_those_to_all_are_left_to_others(line):
    f = line(scenario="still")
    f.run_until(5.0)
    station = Encoder(f.vehicle.dialect, 255, 190)
    for k in range(200):
        f.service.receive(0, station.timesync(0, 1 + k, 1, 193), f.now_ns)
    assert len(f.service.take_frames(0)) == 20
    f.run_until(7.0)
    f.service.receive(0, Encoder(f.vehicle.dialect, 1, 191).heartbeat(18, 8, 0, 4), f.now_ns)
    f.service.take_frames(0)
    f.service.receive(0, station.timesync(0, 4711), f.now_ns)
    assert f.service.take_frames(0) == []
    f.service.receive(0, station.timesync(0, 4711, 1, 193), f.now_ns)
    assert len(f.service.take_frames(0)) == 1

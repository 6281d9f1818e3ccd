"""Requests on virtual time against an autopilot of a few lines."""

import pytest

from attest_mav.mavlink.component.stream import Stream
from attest_mav.mavlink.component.streams import StreamManager

SECOND = 1_000_000_000
TICK = 10_000_000
IMU, ATTITUDE = 27, 30
ACCEPTED, TEMPORARILY_REJECTED, DENIED, UNSUPPORTED = 0, 1, 2, 3


class Autopilot:
    """Answers requests with ``result`` and then sends at ``rate(request)``; ``silent`` answers nothing."""

    def __init__(self, result=ACCEPTED, silent=False, ceiling_hz=1000.0, start_hz=0.0):
        self.result = result
        self.silent = silent
        self.ceiling_hz = ceiling_hz
        self.hz = {IMU: start_hz, ATTITUDE: start_hz}
        self.requests = []
        self.sent = []
        """Messages of the inertial stream in each second."""
        self._due = dict.fromkeys(self.hz, 0.0)

    def run(self, manager, from_s, to_s):
        for tick in range(round(from_s * 100), round(to_s * 100)):
            now_ns = tick * TICK
            for message, hz in self.hz.items():
                self._due[message] += hz / 100.0
                while self._due[message] >= 1.0:
                    self._due[message] -= 1.0
                    manager.arrived(message)
                    if message == IMU:
                        self.sent += [0] * (tick // 100 + 1 - len(self.sent))
                        self.sent[-1] += 1
            for request in manager.poll(now_ns):
                self._take(request, manager, now_ns)

    def _take(self, request, manager, now_ns):
        self.requests.append((round(now_ns / SECOND, 2), request))
        if request.group >= 0:
            self.hz = dict.fromkeys(self.hz, min(request.hz, self.ceiling_hz))
        elif not self.silent:
            if self.result == ACCEPTED:
                self.hz[request.message_id] = min(request.hz, self.ceiling_hz)
            manager.acknowledged(self.result, now_ns)


@pytest.fixture
def manager(notebook):
    manager = StreamManager(True, notebook)
    manager.begin([Stream(IMU, "RAW_IMU", 50.0, 1), Stream(ATTITUDE, "ATTITUDE", 10.0, 10)], 0)
    return manager


def texts(notebook):
    return [note.text for note in notebook.take()]


def test_a_good_autopilot_is_asked_once_for_each(manager, notebook):
    autopilot = Autopilot()
    autopilot.run(manager, 0, 60)
    assert [(request.message_id, request.interval_us, request.group) for _, request in autopilot.requests] == [
        (IMU, 20_000, -1),
        (ATTITUDE, 100_000, -1),
    ]
    assert [stream.answer for stream in manager.streams] == ["accepted", "accepted"]
    assert manager.streams[0].achieved_hz == pytest.approx(50.0, abs=0.6)
    assert texts(notebook) == []


def test_one_request_at_a_time(manager):
    """COMMAND_ACK does not say which message it is about."""
    assert [request.message_id for request in manager.poll(0)] == [IMU]
    assert manager.poll(SECOND // 2) == []
    manager.acknowledged(ACCEPTED, SECOND // 2)
    assert [request.message_id for request in manager.poll(SECOND // 2)] == [ATTITUDE]


def test_no_answer_raises_the_confirmation_and_then_asks_for_the_group(manager, notebook):
    autopilot = Autopilot(silent=True)
    autopilot.run(manager, 0, 8)
    sent = [(request.message_id, request.confirmation, request.group) for _, request in autopilot.requests]
    assert sent[:3] == [(IMU, 0, -1), (IMU, 1, -1), (IMU, 2, -1)]
    assert (IMU, 0, 1) in sent
    assert (ATTITUDE, 0, 10) in sent
    assert "RAW_IMU at 50 Hz: no answer to 3 requests" in texts(notebook)
    assert manager.streams[0].answer == "no answer, asked by stream group"


def test_unsupported_falls_back_to_the_group_and_denied_does_not(notebook):
    for result, groups in ((UNSUPPORTED, [1]), (DENIED, [])):
        manager = StreamManager(True, notebook)
        manager.begin([Stream(IMU, "RAW_IMU", 50.0, 1)], 0)
        autopilot = Autopilot(result=result)
        autopilot.run(manager, 0, 30)
        assert [request.group for _, request in autopilot.requests if request.group >= 0] == groups
        assert manager.streams[0].refused == (result == DENIED)


def test_temporarily_rejected_is_asked_again(notebook):
    manager = StreamManager(True, notebook)
    manager.begin([Stream(IMU, "RAW_IMU", 50.0, 1)], 0)
    autopilot = Autopilot(result=TEMPORARILY_REJECTED)
    autopilot.run(manager, 0, 4)
    autopilot.result = ACCEPTED
    autopilot.run(manager, 4, 30)
    assert manager.streams[0].answer == "accepted"
    assert manager.streams[0].achieved_hz == pytest.approx(50.0, abs=0.6)


@pytest.mark.parametrize("period_s", [4, 5, 10, 15, 30])
def test_a_rate_that_is_overridden_again_and_again_is_45_hz_in_each_minute_and_the_period_is_named(
    manager, notebook, period_s
):
    """MAVProxy asks for all streams at 4 Hz every few seconds."""
    autopilot = Autopilot()
    autopilot.run(manager, 0, 10)
    for t_s in range(10, 310, period_s):
        autopilot.hz = dict.fromkeys(autopilot.hz, 4.0)
        autopilot.run(manager, t_s, t_s + period_s)
    minutes = [autopilot.sent[60 * minute : 60 * (minute + 1)] for minute in range(1, 5)]
    assert min(sum(minute) / 60.0 for minute in minutes) >= 45.0
    asked = [t_s for t_s, request in autopilot.requests if request.message_id == IMU and t_s > 60]
    assert len(asked) <= 250 / period_s + 3
    imu = next(stream for stream in manager.streams if stream.message_id == IMU)
    text = f"another program on this link lowers the rate every {period_s} s"
    assert manager.hindrance(imu, 310 * SECOND) == text
    lines = texts(notebook)
    assert any(text in line for line in lines)
    assert len(lines) <= 2 * 6


@pytest.mark.parametrize("is_cut", [True, False])
def test_a_link_that_was_cut_is_not_laid_to_another_program(manager, is_cut):
    """Asking has helped once; ten minutes later a second's messages are missing."""
    autopilot = Autopilot()
    autopilot.run(manager, 0, 10)
    autopilot.hz = dict.fromkeys(autopilot.hz, 4.0)
    autopilot.run(manager, 10, 600)
    usual = autopilot.hz
    autopilot.hz = dict.fromkeys(usual, 0.0)
    if is_cut:
        manager.silent_ns = 601 * 10**9
    autopilot.run(manager, 600, 601)
    autopilot.hz = usual
    autopilot.run(manager, 601, 606)
    imu = next(stream for stream in manager.streams if stream.message_id == IMU)
    assert (imu.override_text(606 * 10**9) == "") == is_cut


def test_a_rate_that_no_asking_raises_is_asked_for_ever_more_seldom(manager):
    """An autopilot that accepts, and a station that sets 4 Hz at once each time."""
    autopilot = Autopilot(ceiling_hz=4.0)
    for t_s in range(0, 300, 2):
        manager.overheard("system 255", t_s * SECOND)
        autopilot.run(manager, t_s, t_s + 2)
    times = [t_s for t_s, request in autopilot.requests if request.message_id == IMU]
    assert 4 <= len(times) <= 9
    assert times[-1] - times[-2] > 30.0


@pytest.mark.parametrize(("damaged", "word"), [(3000, "damaged"), (0, "lost")])
def test_frames_that_the_link_loses_are_no_reason_to_ask_again(manager, notebook, damaged, word):
    autopilot = Autopilot(ceiling_hz=35.0)
    for t_s in range(120):
        manager.loss.take(70 * t_s, 30 * t_s, damaged * t_s // 100, t_s * SECOND)
        autopilot.run(manager, t_s, t_s + 1)
    imu = next(stream for stream in manager.streams if stream.message_id == IMU)
    assert manager.hindrance(imu, 120 * SECOND) == f"30 % of the frames are {word} on the link"
    asked = [t_s for t_s, request in autopilot.requests if request.message_id == IMU]
    assert len(asked) <= 2
    assert sum("RAW_IMU" in line for line in texts(notebook)) <= 1


def test_a_ceiling_is_recognised_and_left_alone(notebook):
    manager = StreamManager(True, notebook)
    manager.begin([Stream(IMU, "RAW_IMU", 100.0, 1)], 0)
    autopilot = Autopilot(ceiling_hz=40.0)
    autopilot.run(manager, 0, 120)
    assert len(autopilot.requests) == 2, "asked, and asked once more"
    assert manager.streams[0].ceiling_hz == pytest.approx(40.0, abs=1.0)
    assert texts(notebook)[-1] == "RAW_IMU: 40.0 Hz is all that the autopilot gives"


def test_a_ceiling_that_is_exceeded_was_none(notebook):
    """ArduPilot's streams run four times slower while parameters are fetched."""
    manager = StreamManager(True, notebook)
    manager.begin([Stream(IMU, "RAW_IMU", 50.0, 1)], 0)
    autopilot = Autopilot(ceiling_hz=12.5)
    autopilot.run(manager, 0, 30)
    assert manager.streams[0].ceiling_hz > 0.0
    autopilot.hz[IMU] = 50.0
    autopilot.run(manager, 30, 40)
    assert manager.streams[0].ceiling_hz == 0.0


def test_who_does_not_ask_only_measures(notebook):
    manager = StreamManager(False, notebook)
    manager.begin([Stream(IMU, "RAW_IMU", 50.0, 1)], 0)
    autopilot = Autopilot(start_hz=10.0)
    autopilot.run(manager, 0, 60)
    assert autopilot.requests == []
    assert manager.streams[0].achieved_hz == pytest.approx(10.0, abs=0.6)


def test_a_stray_acknowledgement_changes_nothing(notebook):
    manager = StreamManager(True, notebook)
    manager.acknowledged(DENIED, 0)
    manager.begin([Stream(IMU, "RAW_IMU", 50.0, 1)], 0)
    manager.acknowledged(DENIED, 0)
    assert not manager.streams[0].refused
    manager.poll(0)
    manager.acknowledged(200, 0)
    assert manager.streams[0].answer == "result 200"


def test_the_deadline_is_when_something_happens(manager):
    assert manager.next_deadline_ns == 0
    manager.poll(0)
    due_ns = manager.next_deadline_ns
    assert manager.poll(due_ns - 1) == []
    assert len(manager.poll(due_ns)) == 1

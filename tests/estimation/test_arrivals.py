"""Stamps of a live link against the clock of the arrivals: stored data and other vehicles are not believed."""

import pytest

from attest_mav.estimation.arrivals import Arrivals
from attest_mav.estimation.timebase import StepKind, TimeBase

MS = 1_000_000
S = 1_000 * MS
STEP = 20 * MS


class LiveStream:
    """50 Hz on a live link; ``t_ns`` is the stamp and ``rx_ns`` the arrival of the newest sample."""

    def __init__(self):
        self.base = TimeBase(Arrivals.LIVE)
        self.t_ns, self.rx_ns, self.least_ns = 1000 * S, 0, -1000 * S

    def take(self, t_ns, rx_ns):
        kind = self.base.advance(t_ns, rx_ns, self.least_ns).kind
        if kind in (StepKind.STEP, StepKind.GAP, StepKind.RESTART, StepKind.REBOOT):
            self.least_ns = min(self.least_ns, rx_ns - t_ns)  # as the delay is followed
        return kind

    def run(self, count, pace=1.0):
        """So many steps, at a pace of message time against arrivals; their kinds."""
        kinds = []
        for _ in range(count):
            self.t_ns += STEP
            self.rx_ns += round(STEP / pace)
            kinds.append(self.take(self.t_ns, self.rx_ns))
        return kinds


@pytest.fixture
def stream():
    one = LiveStream()
    one.run(100)
    return one


@pytest.mark.parametrize("ahead_s", [-900.0, -60.0, 0.02, 0.9, 100.0])
def test_a_minute_that_comes_at_once_is_not_believed(stream, ahead_s):
    """But for the tenth of a second by which a latency may become shorter."""
    begin_ns = stream.t_ns + round(ahead_s * S)
    kinds = [stream.take(begin_ns + k * STEP, stream.rx_ns) for k in range(3000)]
    assert kinds.count(StepKind.STEP) <= 5
    assert set(kinds) <= {StepKind.STEP, StepKind.STRAY, StepKind.LATE, StepKind.REPEAT}
    kinds = stream.run(50)
    assert set(kinds[5:]) == {StepKind.STEP}


@pytest.mark.parametrize("faster", [2.0, 5.0, 30.0])
def test_stored_data_among_the_samples_never_takes_the_stream_over(stream, faster):
    """The forged stream goes on from the newest stamp, faster than time, for two seconds of arrivals."""
    forged_ns, believed = stream.t_ns, []
    for k in range(100):
        own = stream.run(1)[0]
        for part in range(round(faster)):
            forged_ns += STEP
            believed.append(stream.take(forged_ns, stream.rx_ns + part) == StepKind.STEP)
        assert k < 10 or own in (StepKind.STEP, StepKind.LATE, StepKind.REPEAT)
    assert sum(believed) <= 12
    assert set(stream.run(20)[-10:]) == {StepKind.STEP}


def test_a_backlog_of_the_link_itself_is_used_whole(stream):
    """Ten seconds stall; what was sent meanwhile comes at once, each sample as old as it is."""
    stream.rx_ns += 10 * S
    kinds = [stream.take(stream.t_ns + k * STEP, stream.rx_ns) for k in range(1, 501)]
    assert set(kinds) == {StepKind.STEP}
    stream.t_ns += 10 * S
    assert set(stream.run(50)) == {StepKind.STEP}


def test_a_reboot_in_a_backlog_is_confirmed_by_the_live_samples_behind_it(stream):
    stream.rx_ns += 10 * S
    kinds = [stream.take(5 * S + k * STEP, stream.rx_ns) for k in range(400)]
    assert set(kinds) == {StepKind.STRAY}
    stream.t_ns = 5 * S + 399 * STEP
    kinds = stream.run(60)
    assert kinds.index(StepKind.REBOOT) * STEP <= S
    assert set(kinds[kinds.index(StepKind.REBOOT) + 1 :]) == {StepKind.STEP}


@pytest.mark.parametrize("pace", [0.5, 1.04, 1.5, 5.0, 9.0])
def test_a_simulator_of_another_speed_costs_one_jump(stream, pace):
    kinds = stream.run(2000, pace)
    assert kinds.count(StepKind.STRAY) <= 0.65 * 50 * max(1.0, 0.5 * pace)
    assert set(kinds[-1500:]) == {StepKind.STEP}


def test_a_stream_that_is_faster_than_any_simulator_is_never_believed(stream):
    kinds = stream.run(5000, 60.0)
    assert kinds.count(StepKind.STEP) <= 10
    assert StepKind.RESTART not in kinds


def test_what_is_stored_when_the_link_opens_is_no_beginning():
    """The first stamp is believed; what comes with it is not, until samples come at the pace of time."""
    stream = LiveStream()
    kinds = [stream.take(stream.t_ns + k * STEP, 0) for k in range(500)]
    assert kinds[0] == StepKind.FIRST
    assert kinds.count(StepKind.STEP) <= 50
    stream.t_ns += 499 * STEP
    kinds = stream.run(60)
    assert set(kinds[-25:]) == {StepKind.STEP}

import pytest

from attest_mav.estimation.timebase import WRAP_NS, StepKind, TimeBase, wrapped_difference_ns

MS = 1_000_000
S = 1_000 * MS


class Stream:
    """A time base and a link that takes no time: each stamp arrives ``dt`` after the one before, or as told."""

    def __init__(self, hz=50, begin_ns=1000 * S):
        self.base = TimeBase()
        self.dt = S // hz
        self.t_ns = begin_ns - self.dt
        self.rx_ns = 0
        self.least_ns = self.rx_ns - self.t_ns

    def take(self, t_ns, after_ns=0):
        self.rx_ns += after_ns
        return self.base.advance(t_ns, self.rx_ns, self.least_ns)

    def run(self, count):
        """So many steps in good order; their kinds."""
        kinds = []
        for _ in range(count):
            self.t_ns += self.dt
            kinds.append(self.take(self.t_ns, self.dt).kind)
        return kinds


@pytest.mark.parametrize(
    ("delta_ns", "kind", "dt_s"),
    [
        (20 * MS, StepKind.STEP, 0.02),
        (100 * MS, StepKind.STEP, 0.1),
        (101 * MS, StepKind.GAP, 0.101),
        (1 * S, StepKind.GAP, 1.0),
        (1 * S + MS, StepKind.RESTART, 1.001),
        (0, StepKind.REPEAT, 0.0),
        (-MS, StepKind.LATE, 0.0),
        (-1 * S, StepKind.LATE, 0.0),
        (-1 * S - MS, StepKind.STRAY, 0.0),
        (-500 * S, StepKind.STRAY, 0.0),
    ],
)
def test_a_step_is_classified_by_its_size(delta_ns, kind, dt_s):
    """The arrival is as far ahead as the stamp."""
    s = Stream()
    assert s.run(2) == [StepKind.FIRST, StepKind.STEP]
    step = s.take(s.t_ns + delta_ns, max(delta_ns, 0))
    assert step.kind == kind
    assert step.dt_s == pytest.approx(dt_s, abs=1e-12)


def test_a_slow_stream_has_no_gaps_until_a_sample_is_missing():
    s = Stream(hz=4)
    assert set(s.run(20)[1:]) == {StepKind.STEP}
    assert s.take(s.t_ns + 750 * MS, 750 * MS).kind == StepKind.GAP


def test_repeats_and_late_samples_do_not_move_the_time():
    s = Stream()
    s.run(5)
    s.take(s.t_ns)
    s.take(s.t_ns - 5 * MS)
    assert s.take(s.t_ns + 20 * MS, 20 * MS).dt_s == pytest.approx(0.02)


@pytest.mark.parametrize("hz", [1, 4, 50, 200, 1000])
@pytest.mark.parametrize("error_s", [-1000.0, -5.0, -0.9, -0.3, 0.9, 5.0, 1e6])
def test_one_wrong_stamp_changes_nothing(hz, error_s):
    """One that is less than five intervals and a second ahead is taken; the stamps up to it are late."""
    s = Stream(hz=hz, begin_ns=5000 * S)
    s.run(20)
    wrong = s.take(s.t_ns + round(error_s * S))
    is_near = 0.0 < error_s < min(5.0 / hz, 1.0)
    assert is_near or wrong.kind in (StepKind.LATE, StepKind.STRAY)
    kinds = s.run(20)
    if not is_near:
        assert set(kinds) == {StepKind.STEP}
    assert set(kinds) <= {StepKind.STEP, StepKind.LATE, StepKind.REPEAT}
    assert kinds.count(StepKind.LATE) <= 5


@pytest.mark.parametrize("hz", [1, 4, 50, 200, 1000])
@pytest.mark.parametrize(
    ("jump_s", "kind"), [(-3.0, StepKind.REBOOT), (-4000.0, StepKind.REBOOT), (8.0, StepKind.RESTART)]
)
def test_a_jump_is_recognised_within_a_second_by_stamps_that_continue_from_it(hz, jump_s, kind):
    s = Stream(hz=hz, begin_ns=5000 * S)
    s.run(20)
    s.t_ns += round(jump_s * S)
    kinds = s.run(hz + 2)
    recognised = kinds.index(kind)
    assert recognised * s.dt <= S
    assert set(kinds[:recognised]) == {StepKind.STRAY}
    assert set(kinds[recognised + 1 :]) <= {StepKind.STEP}


@pytest.mark.parametrize("hz", [4, 50, 200, 1000])
@pytest.mark.parametrize("at_once", [True, False])
def test_half_a_second_that_is_sent_twice_is_no_jump(hz, at_once):
    s = Stream(hz=hz)
    s.run(2 * hz)
    for _ in range(5):
        s.t_ns -= S // 2
        end_ns, kinds = s.t_ns + S // 2, []
        while s.t_ns < end_ns:
            s.t_ns += s.dt
            kinds.append(s.take(s.t_ns, 0 if at_once else s.dt).kind)
        assert set(kinds) <= {StepKind.LATE, StepKind.REPEAT}
        assert set(s.run(hz // 2)) == {StepKind.STEP}


def test_a_long_backlog_that_is_sent_twice_at_once_is_no_jump():
    s = Stream(hz=200)
    s.run(1000)
    kinds = [s.take(s.t_ns - 4 * S + k * s.dt).kind for k in range(800)]
    assert set(kinds) == {StepKind.LATE, StepKind.STRAY}
    assert s.run(1) == [StepKind.STEP]


def test_two_clocks_in_turn_leave_the_first_one_alone():
    s = Stream()
    s.run(20)
    for k in range(200):
        assert s.take(77 * S + k * s.dt).kind == StepKind.STRAY
        assert s.run(1) == [StepKind.STEP]


def test_a_jump_survives_disorder_and_gaps_among_the_stamps_that_confirm_it():
    s = Stream()
    s.run(20)
    order = [0, 40, 20, 40, 200, 180, 400, 380, 600, 620]
    kinds = [s.take(5 * S + t * MS, 60 * MS).kind for t in order]
    assert kinds == [StepKind.STRAY] * 8 + [StepKind.REBOOT, StepKind.STEP]


def test_a_recorder_whose_clock_is_set_hides_no_sample():
    """The stamps go on as they were; only the arrivals jump."""
    s = Stream()
    s.run(20)
    s.rx_ns -= 3600 * S
    assert set(s.run(20)) == {StepKind.STEP}


@pytest.mark.parametrize("speed", [0.5, 3.0, 20.0])
def test_a_simulator_of_another_speed_is_no_jump(speed):
    s = Stream()
    kinds = []
    for _ in range(200):
        s.t_ns += s.dt
        kinds.append(s.take(s.t_ns, round(s.dt / speed)).kind)
        s.least_ns = min(s.least_ns, s.rx_ns - s.t_ns)
    assert set(kinds[1:]) == {StepKind.STEP}


def test_a_millisecond_clock_wraps_without_a_gap():
    s = Stream(begin_ns=WRAP_NS - 10 * MS)
    s.run(1)
    step = s.take(10 * MS, 20 * MS)
    assert step.kind == StepKind.STEP
    assert step.dt_s == pytest.approx(0.02)
    assert step.t_ns == WRAP_NS + 10 * MS
    late = s.take(WRAP_NS - 5 * MS)
    assert (late.kind, late.t_ns) == (StepKind.LATE, WRAP_NS - 5 * MS)
    assert s.take(30 * MS, 20 * MS).dt_s == pytest.approx(0.02)


def test_after_a_wrap_a_reboot_is_still_a_reboot():
    s = Stream(begin_ns=WRAP_NS - 10 * MS)
    s.run(1)
    s.t_ns -= WRAP_NS
    assert set(s.run(5000)) == {StepKind.STEP}
    steps = [s.take(2 * S + k * 20 * MS, 20 * MS) for k in range(40)]
    (reboot,) = [step for step in steps if step.kind == StepKind.REBOOT]
    assert 2 * S < reboot.t_ns < 3 * S
    assert steps[-1].kind == StepKind.STEP
    assert steps[-1].t_ns == 2 * S + 39 * 20 * MS


def test_instants_compare_across_a_wrap():
    assert wrapped_difference_ns(5 * MS, WRAP_NS - 5 * MS) == 10 * MS
    assert wrapped_difference_ns(WRAP_NS + 5 * MS, 3 * MS) == 2 * MS
    assert wrapped_difference_ns(3 * MS, 8 * MS) == -5 * MS


def test_disorder_is_no_set_back():
    s = Stream()
    s.run(5)
    order = [0, 20, 40, 30, 60, 50, 80, 70, 100, 90, 120, 110, 140, 130, 160, 150, 180, 170, 200, 190, 220, 210, 240]
    kinds = [s.take(s.t_ns + 20 * MS + t * MS, 10 * MS).kind for t in order]
    assert set(kinds) == {StepKind.STEP, StepKind.LATE}
    assert kinds.count(StepKind.LATE) == 10

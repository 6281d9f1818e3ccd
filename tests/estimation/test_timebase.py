import pytest

from attest_mav.estimation.timebase import WRAP_NS, StepKind, TimeBase, wrapped_difference_ns

MS = 1_000_000
S = 1_000 * MS


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
        (-1 * S - MS, StepKind.REBOOT, 0.0),
        (-500 * S, StepKind.REBOOT, 0.0),
    ],
)
def test_a_step_is_classified_by_its_size(delta_ns, kind, dt_s):
    base = TimeBase()
    assert base.advance(1000 * S - 20 * MS).kind == StepKind.FIRST
    base.advance(1000 * S)
    step = base.advance(1000 * S + delta_ns)
    assert step.kind == kind
    assert step.dt_s == pytest.approx(dt_s, abs=1e-12)


def test_a_slow_stream_has_no_gaps_until_a_sample_is_missing():
    base = TimeBase()
    kinds = [base.advance(round(k * 0.25 * S)).kind for k in range(20)]
    assert set(kinds[1:]) == {StepKind.STEP}
    assert base.advance(round((19 * 0.25 + 0.75) * S)).kind == StepKind.GAP


def test_repeats_and_late_samples_do_not_move_the_time():
    base = TimeBase()
    base.advance(10 * S)
    base.advance(10 * S)
    base.advance(10 * S - 5 * MS)
    assert base.advance(10 * S + 20 * MS).dt_s == pytest.approx(0.02)


def test_a_millisecond_clock_wraps_without_a_gap():
    base = TimeBase()
    base.advance(WRAP_NS - 10 * MS)
    step = base.advance(10 * MS)
    assert step.kind == StepKind.STEP
    assert step.dt_s == pytest.approx(0.02)
    assert step.t_ns == WRAP_NS + 10 * MS
    assert base.advance(30 * MS).dt_s == pytest.approx(0.02)


def test_after_a_wrap_a_reboot_is_still_a_reboot():
    base = TimeBase()
    base.advance(WRAP_NS - 10 * MS)
    base.advance(3600 * S)
    base.advance(5000 * S)
    step = base.advance(2 * S)
    assert step.kind == StepKind.REBOOT
    assert step.t_ns == 2 * S
    assert base.advance(2 * S + 20 * MS).kind == StepKind.STEP


def test_instants_compare_across_a_wrap():
    assert wrapped_difference_ns(5 * MS, WRAP_NS - 5 * MS) == 10 * MS
    assert wrapped_difference_ns(WRAP_NS + 5 * MS, 3 * MS) == 2 * MS
    assert wrapped_difference_ns(3 * MS, 8 * MS) == -5 * MS


def test_a_clock_set_back_by_less_than_a_second_is_noticed_after_some_samples():
    base = TimeBase()
    base.advance(10 * S)
    kinds = [base.advance(round(9.2 * S) + k * 20 * MS).kind for k in range(13)]
    assert kinds == [StepKind.LATE] * 10 + [StepKind.REBOOT] + [StepKind.STEP] * 2


def test_disorder_is_no_set_back():
    base = TimeBase()
    order = [0, 20, 40, 30, 60, 50, 80, 70, 100, 90, 120, 110, 140, 130, 160, 150, 180, 170, 200, 190, 220, 210, 240]
    kinds = [base.advance(S + t * MS).kind for t in order]
    assert StepKind.REBOOT not in kinds
    assert kinds.count(StepKind.LATE) == 10

import pytest

from attest_mav.replay.log_time import LogTime, Regularity

MS = 1_000_000


def test_log_time_starts_at_the_first_sample_and_stands_still_at_a_restart():
    time = LogTime()
    assert time.advance(1_000_000 * MS) == 0.0
    assert time.advance(1_002_500 * MS) == pytest.approx(2.5)
    assert time.advance(700 * MS) == pytest.approx(2.5)
    assert time.advance(1700 * MS) == pytest.approx(3.5)
    assert time.at(1690 * MS) == pytest.approx(3.49)


def test_a_late_sample_does_not_move_log_time():
    time = LogTime()
    time.advance(0)
    time.advance(1000 * MS)
    assert time.advance(980 * MS) == pytest.approx(0.98)
    assert time.advance(1020 * MS) == pytest.approx(1.02)


def test_rate_leaves_gaps_out():
    regularity = Regularity()
    for t_ms in [*range(0, 1001, 20), *range(3000, 4001, 20)]:
        regularity.add(t_ms * MS)
    rate, gaps = regularity.rate_and_gaps()
    assert rate == pytest.approx(50.0)
    assert gaps == 1
    assert regularity.samples == 102


def test_at_four_hertz_the_usual_interval_is_no_gap():
    regularity = Regularity()
    for t_ms in (0, 250, 500, 750, 1000, 1600, 2240):
        regularity.add(t_ms * MS)
    assert regularity.rate_and_gaps()[1] == 1  # 640 ms is more than 2.5 times 250 ms, 600 ms is not


def test_one_sample_has_no_rate():
    regularity = Regularity()
    regularity.add(0)
    assert regularity.rate_and_gaps() == (None, 0)


def test_repeats_are_samples_without_an_interval():
    regularity = Regularity()
    for t_ms in (0, 20, 20, 40):
        regularity.add(t_ms * MS)
    assert regularity.samples == 4
    assert regularity.rate_and_gaps()[0] == pytest.approx(50.0)

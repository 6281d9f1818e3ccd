import pytest

from attest_mav.estimation.clock_offset import DRIFT, ClockOffset
from attest_mav.vehicle_reports import TimeExchange

MS = 1_000_000
S = 1_000 * MS


def exchange(sent_s, offset_s, there_s, back_s):
    """One with an autopilot whose clock is ``offset_s`` behind the host's, over ways that take so long."""
    return TimeExchange(
        round(sent_s * S), round((sent_s + there_s - offset_s) * S), round((sent_s + there_s + back_s) * S)
    )


def offset_s(clock, at_s):
    return clock.offset_ns(round(at_s * S)) * 1e-9


def test_the_offset_is_in_the_middle_of_the_round_trip():
    clock = ClockOffset()
    assert not clock.is_known
    assert clock.take(exchange(10.0, 3.0, 0.004, 0.004))
    assert clock.is_known
    assert clock.round_trip_s == pytest.approx(0.008)
    assert offset_s(clock, 11.0) == pytest.approx(3.0, abs=1e-6)


def test_the_quickest_exchange_counts_until_its_age_outweighs_it():
    clock = ClockOffset()
    clock.take(exchange(10.0, 3.0, 0.002, 0.002))
    clock.take(exchange(15.0, 3.0, 0.002, 0.100))
    assert offset_s(clock, 15.0) == pytest.approx(3.0, abs=1e-6), "the slow answer would be off by 49 ms"
    clock.take(exchange(90.0, 3.0, 0.002, 0.100))
    assert offset_s(clock, 90.0) == pytest.approx(3.049, abs=0.0005)


def test_a_backlog_that_grows_on_the_way_back_leaves_the_offset():
    clock = ClockOffset()
    for k in range(60):
        assert clock.take(exchange(10.0 + 5 * k, 3.0, 0.002, 0.002 + 0.1 * k)), "no answer contradicts"
    assert offset_s(clock, 310.0) == pytest.approx(3.0, abs=0.001)


@pytest.mark.parametrize("change_s", [5.0, -5.0, 0.3, 0.05])
def test_a_clock_that_was_stopped_or_set_is_found_out_by_one_exchange(change_s):
    clock = ClockOffset()
    for k in range(10):
        clock.take(exchange(10.0 + k, 3.0, 0.004, 0.004))
    assert not clock.take(exchange(21.0, 3.0 + change_s, 0.004, 0.004))
    assert clock.jumps == 1
    assert offset_s(clock, 21.0) == pytest.approx(3.0 + change_s, abs=1e-6)


@pytest.mark.parametrize("skew", [1e-4, -3e-4])
def test_the_skew_is_learnt_and_used_between_the_exchanges(skew):
    clock = ClockOffset()
    for k in range(100):
        t_s = 10.0 + 5 * k
        clock.take(exchange(t_s, 3.0 + skew * t_s, 0.003 + 0.001 * (k % 2), 0.003))
    assert clock.skew == pytest.approx(skew, rel=0.05)
    assert offset_s(clock, 600.0) == pytest.approx(3.0 + skew * 600.0, abs=0.003)
    assert clock.jumps == 0


def test_the_uncertainty_is_half_the_round_trip_and_grows_with_age():
    clock = ClockOffset()
    clock.take(exchange(10.0, 3.0, 0.004, 0.004))
    assert clock.uncertainty_ns(round(30.008 * S)) == pytest.approx((0.004 + 20 * DRIFT) * S, rel=1e-6)

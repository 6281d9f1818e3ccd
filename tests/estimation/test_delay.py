import pytest

from attest_mav.estimation.arrivals import Arrivals
from attest_mav.estimation.clock_offset import ClockOffset
from attest_mav.estimation.delay import DelayMeter
from attest_mav.vehicle_reports import TimeExchange

MS = 1_000_000
S = 1_000 * MS
LIVE = {"arrivals": Arrivals.LIVE}


def delays(pairs, **choices):
    """Delays, s, of samples given as (sensor time, arrival), ns."""
    meter = DelayMeter(ClockOffset(), **choices)
    return [meter.delay_s(t_ns, rx_ns) for t_ns, rx_ns in pairs]


def test_a_steady_stream_has_no_delay_whatever_the_clocks_say():
    assert max(delays([(k * 20 * MS, 77 * S + k * 20 * MS) for k in range(500)])) < 1e-9


def test_a_hiccup_shows_but_for_what_is_forgotten_in_a_tenth_of_a_second():
    late = delays([(k * 20 * MS, k * 20 * MS + (200 * MS if k == 50 else 0)) for k in range(100)])
    assert late[50] == pytest.approx(0.15, abs=1e-6)
    assert max(late[:50] + late[51:]) < 1e-9


def test_a_backlog_is_as_old_as_it_is():
    before = [(k * 20 * MS, k * 20 * MS) for k in range(100)]
    backlog = [(2 * S + k * 20 * MS, 22 * S) for k in range(1000)]
    late = delays(before + backlog)[100:]
    ages = [20.0 - 0.02 * k for k in range(1000)]
    assert late[0] == pytest.approx(ages[0], abs=0.1)
    assert max(abs(seen - age) for seen, age in zip(late, ages, strict=True)) < 0.1


@pytest.mark.parametrize("speed", [0.6, 0.9999, 1.0001, 3.0])
def test_a_clock_of_another_speed_is_no_delay(speed):
    assert max(delays([(round(k * 20 * MS * speed), k * 20 * MS) for k in range(5000)])) < 0.02


def test_a_link_that_has_become_slower_is_believed_after_a_while_in_a_recording():
    quick = [(k * 20 * MS, k * 20 * MS) for k in range(100)]
    slow = [(k * 20 * MS, k * 20 * MS + S) for k in range(100, 300)]
    late = delays(quick + slow)
    assert late[100] == pytest.approx(0.95, abs=0.05)
    assert late[-1] < 0.01


@pytest.mark.parametrize("growth", [0.01, 0.1, 0.4, 0.9])
def test_on_a_live_link_a_delay_that_grows_slowly_is_seen_whole(growth):
    late = delays([(k * 20 * MS, round(k * 20 * MS * (1 + growth))) for k in range(3000)], **LIVE)
    assert late[-1] == pytest.approx(60.0 * growth, rel=0.11, abs=0.01)


def test_on_a_live_link_a_delay_that_stays_is_not_forgotten():
    late = delays(
        [(k * 20 * MS, k * 20 * MS + (2 * S if k >= 100 else 0)) for k in range(6000)], arrivals=Arrivals.LIVE
    )
    assert late[-1] == pytest.approx(2.0, abs=0.13)


def test_a_crystal_that_runs_slow_is_no_delay():
    assert max(delays([(k * 20 * MS, round(k * 20 * MS * 1.0005)) for k in range(100_000)], **LIVE)) < 1e-6


def metered(exchanges, samples):
    """Delays of samples (sensor time, arrival) after exchanges (sent, autopilot, received), s."""
    clock = ClockOffset()
    for sent_s, autopilot_s, received_s in exchanges:
        clock.take(TimeExchange(round(sent_s * S), round(autopilot_s * S), round(received_s * S)))
    meter = DelayMeter(clock, Arrivals.LIVE)
    return [meter.delay_s(round(t_s * S), round(rx_s * S)) for t_s, rx_s in samples]


def test_with_the_autopilots_time_a_delay_from_the_start_is_measured():
    assert metered([(100.0, 7.76, 101.5)], [(7.8, 101.54)]) == [pytest.approx(0.75, abs=0.001)]


def test_a_sample_is_never_younger_than_nothing():
    """Half of the round trip is taken for the way there, which took none of it: the offset is too large by 0.2 s."""
    assert metered([(100.0, 7.4, 100.4)], [(7.6, 100.3)]) == [0.0]


@pytest.mark.parametrize("zero_s", [1.7e9, -50_000.0, 35.0, 3.0, -5.0])
def test_timestamps_of_another_clock_than_the_one_that_answers_are_not_measured_with_it(zero_s):
    late = metered([(100.0, 7.0 + zero_s, 100.02)], [(7.0 + 0.02 * k, 100.0 + 0.02 * k) for k in range(50)])
    assert max(late) < 1e-6


def test_a_millisecond_clock_that_has_wrapped_is_measured_with_one_that_does_not():
    wrap_s = 4294967.296
    assert metered([(100.0, wrap_s + 7.01, 100.02)], [(8.0, 101.3)]) == [pytest.approx(0.3, abs=0.001)]


def test_timestamps_of_another_clock_stay_so_between_the_answers():
    """The bound on the age grows until the next answer; an age of 3 s is not believed after 4 s either."""
    late = metered([(100.0, 10.0, 100.02)], [(7.0 + 0.02 * k, 100.02 + 0.02 * k) for k in range(400)])
    assert max(late) < 1e-6


def test_a_clock_that_stood_still_is_found_out_by_the_next_answer():
    clock = ClockOffset()
    meter = DelayMeter(clock, Arrivals.LIVE)
    clock.take(TimeExchange(0, 5 * MS, 10 * MS))
    assert meter.delay_s(20 * MS, 22 * MS) == pytest.approx(0.002)
    assert meter.delay_s(40 * MS, 5 * S + 42 * MS) == pytest.approx(5.0, abs=0.01)
    clock.take(TimeExchange(5 * S + 50 * MS, 55 * MS, 5 * S + 60 * MS))
    assert clock.jumps == 1
    assert meter.delay_s(60 * MS, 5 * S + 62 * MS) == pytest.approx(0.002, abs=0.001)
    assert 5 * S - 10 * MS < meter.least_ns <= 5 * S + 2 * MS, (
        "the quickest arrival is that of the clock as it runs now"
    )


def test_a_backlog_that_an_answer_overtook_stays_old():
    clock = ClockOffset()
    meter = DelayMeter(clock, Arrivals.LIVE)
    clock.take(TimeExchange(0, 5 * MS, 10 * MS))
    assert meter.delay_s(20 * MS, 22 * MS) == pytest.approx(0.002)
    clock.take(TimeExchange(3 * S, 3 * S + 5 * MS, 3 * S + 10 * MS))
    late = [meter.delay_s(S + k * 20 * MS, 3 * S + 10 * MS + k * 20 * MS) for k in range(50)]
    assert min(late) == pytest.approx(2.005, abs=0.01)

import pytest

from attest_mav.estimation.delay import DelayMeter

MS = 1_000_000
S = 1_000 * MS


def delays(pairs):
    """Delays, s, of samples given as (sensor time, arrival), ns."""
    meter = DelayMeter()
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


def test_a_link_that_has_become_slower_is_believed_after_a_while():
    quick = [(k * 20 * MS, k * 20 * MS) for k in range(100)]
    slow = [(k * 20 * MS, k * 20 * MS + S) for k in range(100, 300)]
    late = delays(quick + slow)
    assert late[100] == pytest.approx(0.95, abs=0.05)
    assert late[-1] < 0.01

"""Our own timestamps: with the time of day, strictly growing, over restarts too."""

import pytest

from attest_mav.mavlink.signing.clock import SigningClock

SECOND = 1_000_000_000
TICKS = 100_000
UNIX_NS = 1_790_000_000 * SECOND
NOW = (1_790_000_000 - 1_420_070_400) * TICKS


def started(kept=0, unix_ns=UNIX_NS, now_ns=0):
    clock = SigningClock()
    clock.begin(kept, unix_ns, now_ns)
    return clock


def test_they_run_with_the_time_of_day():
    clock = started(now_ns=7 * SECOND)
    assert clock.take() == NOW
    clock.advance(17 * SECOND)
    assert clock.take() == NOW + 10 * TICKS


def test_no_two_are_alike():
    clock = started()
    taken = [clock.take() for _ in range(1000)]
    assert taken == list(range(NOW, NOW + 1000))
    clock.advance(1_000)
    assert clock.take() == NOW + 1000


@pytest.mark.parametrize("back_s", [0, 5, 3600, 10**9])
def test_a_restart_goes_on_behind_everything_that_was_used(back_s):
    """The state was kept half a minute before the power went; meanwhile the clock was set back."""
    clock = started()
    clock.advance(100 * SECOND)
    kept = clock.timestamp
    clock.advance(130 * SECOND)
    last = max(clock.take() for _ in range(100))
    again = started(kept, UNIX_NS + 131 * SECOND if back_s == 0 else UNIX_NS + 100 * SECOND - back_s * SECOND)
    assert again.take() > last


def test_restarts_with_a_right_clock_do_not_run_ahead():
    kept = 0
    for number in range(100):
        clock = started(kept, UNIX_NS + number * SECOND)
        kept = clock.timestamp
    assert kept == NOW + 99 * TICKS


def test_a_clock_that_is_set_right_later_is_followed_and_one_set_back_is_not():
    clock = started(unix_ns=0)
    early = clock.take()
    clock.set_time(UNIX_NS, 5 * SECOND)
    assert clock.take() == NOW > early
    clock.set_time(UNIX_NS - 3600 * SECOND, 6 * SECOND)
    assert clock.take() == NOW + TICKS

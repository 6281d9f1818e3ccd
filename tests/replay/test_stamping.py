import random

import pytest

from attest_mav.replay.stamping import BurstStamp
from attest_mav.samples import AttitudeSample
from attest_mav.types import NO_TIME, AttitudeRole

MS = 1_000_000


def untimed(rx_ms):
    return AttitudeSample("SIM_STATE", 1, 1, NO_TIME, round(rx_ms * MS), (1.0, 0.0, 0.0, 0.0), None, AttitudeRole.TRUTH)


def stamps(events):
    """Times (ms) found for untimed samples, by their arrival. events: ("A", t_ms, rx_ms) or ("U", rx_ms), in order."""
    stamp, found = BurstStamp(), {}
    for kind, *times in events:
        one = stamp.timed(times[0] * MS, round(times[1] * MS)) if kind == "A" else stamp.untimed(untimed(times[0]))
        if one is not None:
            found[one.sample.rx_ns / MS] = one.t_ns / MS
    last = stamp.finish()
    if last is not None:
        found[last.sample.rx_ns / MS] = last.t_ns / MS
    return found


def test_behind_its_burst_mate_a_sample_has_the_mates_time():
    events = []
    for k in range(10):
        events += [("A", 1000 + 20 * k, 5000 + 20 * k), ("U", 5000.4 + 20 * k)]
    assert stamps(events) == {5000.4 + 20 * k: 1000 + 20 * k for k in range(10)}


def test_before_its_burst_mate_too():
    events = []
    for k in range(10):
        events += [("U", 5000 + 20 * k), ("A", 1000 + 20 * k, 5000.4 + 20 * k)]
    # The first one is given up: nothing before it tells the order.
    assert stamps(events) == {5000 + 20 * k: 1000 + 20 * k for k in range(1, 10)}


def test_bursts_that_are_read_at_one_instant_are_told_apart_by_their_order():
    events = []
    for k in range(10):
        rx_ms = 5000 + 20 * (k - k % 2)  # two bursts a read
        events += [("A", 1000 + 20 * k, rx_ms), ("U", rx_ms + 0.1 * (k % 2))]
    assert list(stamps(events).values()) == [1000 + 20 * k for k in range(10)]


def test_a_sample_whose_mate_was_lost_gets_no_time():
    events = [("A", 1000, 5000), ("U", 5000.4), ("U", 5020.4), ("A", 1040, 5040), ("U", 5040.4)]
    assert stamps(events) == {5000.4: 1000, 5040.4: 1040}


def test_a_pause_parts_what_stands_on_its_sides():
    assert stamps([("A", 1000, 5000), ("U", 5000.4), ("A", 1020, 5020), ("U", 5853.0)]) == {5000.4: 1000}


def test_streams_that_are_not_sent_together_are_stamped_by_arrival():
    # ATTITUDE at 4 Hz, the untimed message 90 ms behind it, both with a little jitter of arrival.
    jitter = random.Random(1)
    events, expected = [], {}
    for k in range(40):
        rx_ms = round(5090 + 250 * k + jitter.uniform(0, 2), 3)
        events += [("A", 1000 + 250 * k, 5000 + 250 * k + jitter.uniform(0, 2)), ("U", rx_ms)]
        expected[rx_ms] = 1090 + 250 * k
    events.append(("A", 11_000, 15_000))
    found = stamps(events)
    assert found.keys() == expected.keys()
    for rx_ms, t_ms in expected.items():
        assert found[rx_ms] == pytest.approx(t_ms, abs=2.5)


def test_streams_that_change_places_are_followed():
    events = []
    for k in range(200):
        mate = ("A", 1000 + 20 * k, 5000 + 20 * k)
        events += [mate, ("U", 5000.5 + 20 * k)] if k < 100 else [("U", 4999.5 + 20 * k), mate]
    found = list(stamps(events).values())
    assert found[:100] == [1000 + 20 * k for k in range(100)]
    assert found[-50:] == [1000 + 20 * k for k in range(150, 200)]

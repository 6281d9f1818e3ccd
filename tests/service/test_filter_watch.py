"""The question behind the watchdog, asked of the whole service beside the fake autopilot."""

from dataclasses import replace

import pytest

from attest_mav.service.filter_watch import PATIENCE_NS, FilterWatch
from attest_mav.sim.fault_text import parse_faults
from attest_mav.sim.settings import SimSettings

from .conftest import SECOND

PATIENCE_S = PATIENCE_NS // SECOND
LONG_S = PATIENCE_S + 5


def sim(*faults):
    return SimSettings(scenario="square", fast_rate_hz=50.0, faults=parse_faults(faults))


def failures(f, watch, seconds):
    """The looks, one a second, that find a failure, counted from the first."""
    begin_s = f.now_ns / SECOND
    found = []
    for second in range(1, seconds + 1):
        f.run_until(begin_s + second)
        if watch.fails(f.snapshot(), f.service.fresh(f.now_ns)):
            found.append(second)
    return found


@pytest.mark.parametrize("fault", [None, "imu-silent@3", "imu-freeze@12"])
def test_a_vehicle_that_flies_is_off_or_repeats_one_reading_is_no_failure(flight, fault):
    f = flight("", sim(*([fault] if fault else [])))
    assert failures(f, FilterWatch(), LONG_S) == []
    assert f.service.fresh(f.now_ns) == (fault is None)


def test_samples_that_come_and_are_not_filtered_are_one(flight):
    f = flight("", sim())
    f.run_until(2.0)
    shown = f.snapshot()
    watch = FilterWatch()

    def fails(second, *, is_fresh=False, late_by_s=0.0):
        now_ns = shown.now_ns + second * SECOND
        return watch.fails(
            replace(shown, now_ns=now_ns, samples=shown.samples + 50 * second, late_by_s=late_by_s), is_fresh
        )

    assert next(second for second in range(LONG_S) if fails(second)) == PATIENCE_S + 1
    assert not fails(LONG_S, is_fresh=True)
    assert not any(fails(LONG_S + second, late_by_s=0.7) for second in range(LONG_S)), "the link holds a backlog"

from random import Random

import numpy as np
import pytest

from attest_mav.filters.velocity_aided.history import LENGTH_NS, SPACING_NS, appended, empty_history, look_back

STEPS_MS = {"quick": (1, 4), "usual": (8, 25), "slow": (90, 300), "with gaps": (10, 900)}


@pytest.mark.parametrize("steps_ms", STEPS_MS.values(), ids=STEPS_MS)
def test_the_motion_since_an_instant_is_the_integral_of_the_force(steps_ms):
    rng, history = Random(1), empty_history(0)
    times, integral = [0], [np.zeros(3)]
    for _ in range(400):
        times.append(times[-1] + 1_000_000 * rng.randint(*steps_ms))
        step_s = (times[-1] - times[-2]) * 1e-9
        # Steps that are not all kept must have one force, for the integral between the others to be known.
        force = np.array([1.0, -2.0, 9.0]) if steps_ms[1] < 8 else np.array([rng.random(), rng.random(), 9.0])
        integral.append(integral[-1] + force * step_s)
        history = appended(history, times[-1], tuple(force * step_s))
        back_ns = rng.randint(0, LENGTH_NS)
        since_ns = times[-1] - back_ns
        found = look_back(history, since_ns)
        if since_ns < 0:
            assert found is None
            continue
        then = [np.interp(since_ns, times, [one[axis] for one in integral]) for axis in range(3)]
        assert found.delta_velocity == pytest.approx(integral[-1] - then, abs=1e-9)
        assert found.age_s == pytest.approx(back_ns * 1e-9)


@pytest.mark.parametrize("step_ms", [1, 5, 20, 250])
def test_nothing_is_told_of_a_time_before_the_history(step_ms):
    history = empty_history(0)
    for k in range(1, 3001):
        history = appended(history, 1_000_000 * step_ms * k, (0.0, 0.0, 0.01))
    now_ns = history.newest.t_ns
    oldest_ns = now_ns - LENGTH_NS
    kept_ns = max(1_000_000 * step_ms, SPACING_NS) + 1_000_000 * step_ms
    assert look_back(history, oldest_ns) is not None
    assert look_back(history, oldest_ns - kept_ns) is None


def test_a_gap_longer_than_the_history_empties_it_but_for_the_gap_itself():
    history = empty_history(0)
    for k in range(1, 41):
        history = appended(history, 20_000_000 * k, (0.0, 0.0, 0.2))
    history = appended(history, 5_000_000_000, (0.0, 0.0, 42.0))
    assert look_back(history, 4_900_000_000).delta_velocity[2] == pytest.approx(1.0)
    history = appended(history, 5_020_000_000, (0.0, 0.0, 0.2))
    assert look_back(history, 790_000_000) is None


def test_a_clock_that_goes_back_begins_a_new_history():
    history = appended(empty_history(10_000_000_000), 10_020_000_000, (0.0, 0.0, 0.2))
    history = appended(history, 3_000_000_000, (0.0, 0.0, 0.2))
    assert history.newest.delta_velocity == (0.0, 0.0, 0.0)
    assert look_back(history, 2_990_000_000) is None

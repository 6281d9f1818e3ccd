"""The smoother's model against the live filter's: the motion of an interval is that of its steps."""

import numpy as np
import pytest

from attest_mav.filters.base import FilterInputs, Start
from attest_mav.filters.velocity_aided.alignment.initialize import first_navigation
from attest_mav.filters.velocity_aided.alignment.solve import AlignmentMethod, InitialState
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.prediction import predict
from attest_mav.filters.velocity_aided.reading import Reading, read
from attest_mav.samples import ImuSample
from attest_mav.smoothing.intervals import Nominal, integrate
from attest_mav.smoothing.model import Prediction, State, first_covariance
from attest_mav.smoothing.parts import Parts
from attest_mav.smoothing.recorder import Recorder
from attest_mav.smoothing.rotations import matrices
from attest_mav.types import North

PARAMETERS = FlightParameters()
STEPS = 10
Q = (0.9, 0.3, -0.2, 0.1)


@pytest.fixture(scope="module")
def samples(flown):
    rows = zip(flown.t[1:], flown.gyro[1:].tolist(), flown.accel[1:].tolist(), strict=True)
    return [ImuSample("x", 1, 1, int(1e9 * t), int(1e9 * t), tuple(w), tuple(f), None) for t, w, f in rows]


@pytest.fixture(scope="module")
def intervals(samples):
    """One interval of ten steps."""
    recorder = Recorder(PARAMETERS)
    zero = (0.0, 0.0, 0.0)
    state = recorder.initial(Start((1.0, 0.0, 0.0, 0.0), zero, North.RELATIVE, zero, None))
    for sample in samples[:600]:
        state = recorder.step(state, 0.02, sample, FilterInputs(zero_mean_velocity=True))
    part = Parts(recorder.recording(), PARAMETERS, 1)[0]
    zero = np.zeros((1, 3))
    assert part.rows.tolist() == [0, STEPS]
    return integrate(part, Nominal(zero, zero, zero), PARAMETERS)


def live_after(samples, q_nb, first, count):
    """The live filter's prediction from this attitude over so many steps, after two readings to know bends from."""
    tt = np.diag([0.01, 0.02, 0.03])
    initial = InitialState(q_nb, tuple(map(tuple, tt.tolist())), (1.0, 2.0, 3.0), 0.5, AlignmentMethod.VELOCITY)
    reading = read(samples[first], (0.0, 0.0, -9.8))
    navigation = first_navigation(initial, reading, samples[first].t_ns, (0.0, 0.0, 0.0), 0.0, PARAMETERS)
    nav, memory = navigation.estimate, navigation.imu
    for sample in samples[first + 1 : first + 1 + count]:
        step = Reading(sample.gyro, sample.accel, saturated=False)
        nav, memory = predict(nav, memory, step, 0.02, sample.t_ns, False, PARAMETERS)
    return nav


def test_an_interval_is_the_same_as_the_live_filters_steps(samples, intervals):
    length = np.linalg.norm(Q)
    q_nb = tuple(float(part / length) for part in Q)
    live = live_after(samples, q_nb, 0, STEPS)
    x = np.zeros((1, 24))
    x[0, 3:6] = 1.0, 2.0, 3.0
    p = first_covariance(declination_known=True, parameters=PARAMETERS)
    p[:3, :3], p[3:6, 3:6] = np.diag([0.01, 0.02, 0.03]), 0.25 * np.eye(3)
    state = State(matrices(np.array([q_nb])), x, p[np.newaxis].copy(), np.zeros(1), np.zeros(1))
    Prediction(intervals, 1, PARAMETERS).predict(state, 0)
    np.testing.assert_allclose(state.attitude[0], matrices(np.array(live.q_nb)), atol=1e-9)
    np.testing.assert_allclose(state.x[0, 3:6], live.velocity, atol=1e-9)
    names = "tvbsamdr"
    for row, one in enumerate(names):
        for column, other in list(enumerate(names))[row:]:
            theirs = np.array(getattr(live.covariance, one + other))
            ours = state.p[0, 3 * row : 3 * row + 3, 3 * column : 3 * column + 3]
            # The live filter lets the drift of a step act from the next step on: a tenth of what ten steps make.
            share = 3e-3 if other != "r" or one not in "tv" else 0.15
            np.testing.assert_allclose(ours, theirs, rtol=2e-3, atol=share * np.abs(theirs).max() + 1e-12)


def test_the_transition_is_the_derivative_of_the_motion(intervals):
    attitude = matrices(np.array([[0.6, 0.0, 0.8, 0.0]]))

    def moved(x):
        state = State(attitude.copy(), x.copy(), np.tile(np.eye(24), (1, 1, 1)), np.zeros(1), np.zeros(1))
        phi = Prediction(intervals, 1, PARAMETERS).predict(state, 0)
        return state, phi

    base, phi = moved(np.zeros((1, 24)))
    for place in (*range(6, 15), 21, 22, 23):
        x = np.zeros((1, 24))
        x[0, place] = 1e-6
        off, _ = moved(x)
        np.testing.assert_allclose((off.x - base.x)[0, 3:6] / 1e-6, phi[0, 3:6, place], atol=1e-5)
        turn = off.attitude[0] @ base.attitude[0].T
        vector = np.array([turn[2, 1], turn[0, 2], turn[1, 0]]) / 1e-6
        np.testing.assert_allclose(vector, phi[0, 0:3, place], atol=1e-5)

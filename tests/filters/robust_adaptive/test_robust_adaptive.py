"""The robust adaptive filter: published vectors, equations against numpy, modes, and bad readings."""

from dataclasses import replace
from math import inf, isinf, isnan, nan, pi, radians, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from attest_mav.algebra import (
    heading_between,
    q_exp,
    q_from_euler,
    q_heading,
    q_mul,
    q_norm,
    q_unit,
    scale,
    tilt_between,
)
from attest_mav.evaluation.papers.paper2_equations import gain_gap, jacobian_gap, undone_gain
from attest_mav.evaluation.papers.rotation_stand import PRINTED
from attest_mav.filters.base import FilterInputs, Start
from attest_mav.filters.robust_adaptive.filter import RobustAdaptive
from attest_mav.filters.robust_adaptive.model import (
    accel_innovation,
    attitude_variances,
    heading_innovation,
    measurement_jacobian,
    predicted_covariance,
    state_variances_of,
)
from attest_mav.matrices4 import add4, diagonal4, scaled4
from attest_mav.samples import ImuSample
from attest_mav.types import G_MPS2, North

Q = q_from_euler(0.1, -0.2, 0.3)
ONE = (1.0, 0.0, 0.0, 0.0)
GYRO = (0.05, -0.02, 0.1)
ZERO = (0.0, 0.0, 0.0)
LEVEL = (0.0, 0.0, -G_MPS2)
NORTH_FIELD = (0.2, 0.0, 0.35)
NO_INPUTS = FilterInputs()
PLAIN = RobustAdaptive(robust=False, adaptive=False)


def reading(gyro=ZERO, accel=LEVEL, mag=NORTH_FIELD, saturated=False):
    return ImuSample("RAW_IMU", 1, 1, 0, 0, gyro, accel, mag, saturated)


def started(filter_, q=ONE, bias=ZERO):
    return filter_.initial(Start(q, bias, North.MAGNETIC, LEVEL, NORTH_FIELD))


def run(filter_, samples, q=ONE, dt_s=0.01, inputs=NO_INPUTS):
    """The state after the samples."""
    state = started(filter_, q)
    for sample in samples:
        state = filter_.step(state, dt_s, sample, inputs)
    return state


# --- vectors: computed by an independent implementation of the same equations -------------------------------------

TURN = q_exp(scale(GYRO, 0.005))
PREDICTED = (0.981754161304, 0.064286566562, -0.091249396105, 0.153946587594)
V = (0.01, 0.2, -0.005, 0.03)


def test_the_prediction_gives_the_published_attitude_and_measurement():
    q = q_mul(Q, TURN)
    force = [
        measured - innovation for measured, innovation in zip((0.0, 0.0, -1.0), accel_innovation(q, LEVEL), strict=True)
    ]
    assert q == pytest.approx(PREDICTED, abs=1e-9)
    assert force == pytest.approx((-0.198962343785, -0.098132142175, -0.975081570141), abs=1e-9)
    assert heading_innovation(q, None, 0.0) == pytest.approx(-0.300994852679, abs=1e-9)


@pytest.mark.parametrize(
    ("filter_", "inflation", "alpha", "expected"),
    [
        pytest.param(
            replace(PRINTED, robust=False, adaptive=False),
            (1.0, 1.0, 1.0, 1.0),
            1.0,
            (0.979668077318, 0.062671177740, -0.090861623743, 0.167531928587),
            id="plain",
        ),
        pytest.param(
            PRINTED,
            (1.0, 6.998698933, 1.0, 8.003794754),
            0.220537057943,
            (0.979769197522, 0.062947490858, -0.090604503383, 0.166975318383),
            id="printed",
        ),
        pytest.param(
            replace(PRINTED, adaptive=False),
            (1.0, 6.998698933, 1.0, 8.003794754),
            1.0,
            (0.980264394275, 0.063560755606, -0.090848871704, 0.163671103660),
            id="robust only",
        ),
        pytest.param(
            RobustAdaptive(r_heading=1e-6),
            (1.0, inf, 1.0, inf),
            1.0,
            (0.981760235256, 0.064279046999, -0.091188093917, 0.153947316038),
            id="recommended",
        ),
    ],
)
def test_one_correction_gives_the_published_attitude(filter_, inflation, alpha, expected):
    diagonal = ((1e-6, 0.0, 0.0, 0.0), (0.0, 2e-6, 0.0, 0.0), (0.0, 0.0, 3e-6, 0.0), (0.0, 0.0, 0.0, 4e-6))
    q = q_mul(Q, TURN)
    p = predicted_covariance(diagonal, TURN, q, 0.0, 1e-8)
    rows = measurement_jacobian(q, not filter_.printed)
    spread = state_variances_of(p, rows)
    weights, _ = filter_.weigh_measurements(V, spread, (0.0, 0.0, 0.0, 0.0), 0.01)
    _, factor = filter_.weigh_prediction(V, spread, weights, 1.0, 0.01)
    dq, _ = filter_.correction(scaled4(p, 1.0 / factor), rows, V, weights)
    assert weights == pytest.approx(inflation, abs=1e-8)
    assert factor == pytest.approx(alpha, abs=1e-9)
    assert q_unit(add4(q, dq)) == pytest.approx(expected, abs=1e-9)


# --- equations ----------------------------------------------------------------------------------------------------

seeds = st.integers(0, 2**32)


@given(seeds)
@settings(derandomize=True, max_examples=50, deadline=None)
def test_rows_are_the_derivatives_of_the_measurement(seed):
    assert jacobian_gap(np.random.default_rng(seed)) < 1e-7


@given(seeds)
@settings(derandomize=True, max_examples=50, deadline=None)
def test_rows_one_after_the_other_equal_the_information_form(seed):
    assert gain_gap(np.random.default_rng(seed)) < 1e-10


@given(seeds)
@settings(derandomize=True, max_examples=50, deadline=None)
def test_the_predicted_covariance_is_phi_p_phi_t_plus_q(seed):
    rng = np.random.default_rng(seed)
    half = rng.standard_normal((4, 4))
    p, q = half @ half.T, q_unit(tuple(rng.standard_normal(4).tolist()))
    turn = q_exp(tuple((0.3 * rng.standard_normal(3)).tolist()))
    phi = np.column_stack([q_mul(tuple(column), turn) for column in np.eye(4).tolist()])
    noise, q_step = rng.uniform(0.0, 1.0, 2).tolist()
    w, x, y, z = q
    xi = np.array([[-x, -y, -z], [w, -z, y], [z, w, -x], [-y, x, w]])
    expected = phi @ p @ phi.T + noise * xi @ xi.T + q_step * np.eye(4)
    ours = predicted_covariance(tuple(map(tuple, p.tolist())), turn, q, noise, q_step)
    assert np.abs(np.array(ours) - expected).max() < 1e-13


def test_one_whole_step_is_the_kalman_filter_written_with_matrices():
    """Plain, from a start where nothing vanishes; numpy does all rows at once."""
    filter_ = replace(PLAIN, p0=1e-2)
    sample = reading(GYRO, (1.5, 1.0, -9.6), (0.45, -0.1, 0.85))
    state = started(filter_, Q)
    after = filter_.step(state, 0.01, sample, NO_INPUTS)
    q = q_mul(Q, TURN)
    p = np.array(predicted_covariance(diagonal4(1e-2), TURN, q, 0.25 * 2.7e-7 * 0.01, 0.0))
    h, r = np.array(measurement_jacobian(q, vertical=True)), np.diag([1e-3, 1e-3, 1e-3, 2.7e-3])
    v = np.array([*accel_innovation(q, sample.accel), heading_innovation(q, sample.mag, nan)])
    gain = p @ h.T @ np.linalg.inv(h @ p @ h.T + r)
    assert after.residual == pytest.approx(v, abs=1e-14)
    assert after.q_nb == pytest.approx(q_unit(tuple((np.array(q) + gain @ v).tolist())), abs=1e-12)
    left = np.eye(4) - gain @ h
    assert np.abs(np.array(after.covariance) - (left @ p @ left.T + gain @ r @ gain.T)).max() < 1e-14


def test_the_sigmas_are_those_of_the_error_turn():
    """Variances of 2 vec(dq conj(q)) for a covariance built from known turns in NED."""
    sigma = np.array([0.01, 0.02, 0.05])
    w, x, y, z = Q
    to_dq = 0.5 * np.array([[-x, -y, -z], [w, z, -y], [-z, w, x], [y, -x, w]])
    p = to_dq @ np.diag(sigma**2) @ to_dq.T
    tilt, heading = attitude_variances(Q, tuple(map(tuple, p.tolist())))
    assert tilt == pytest.approx(sigma[0] ** 2 + sigma[1] ** 2)
    assert heading == pytest.approx(sigma[2] ** 2)


@pytest.mark.parametrize("k", [3.0, 10.0, 100.0])
def test_the_printed_factors_undo_each_other(k):
    assert undone_gain(k) == pytest.approx(0.81, abs=0.01)


# --- modes --------------------------------------------------------------------------------------------------------


def test_a_heading_outlier_is_rejected_and_moves_nothing():
    state = run(RobustAdaptive(), [reading()] * 100)
    off = RobustAdaptive().step(state, 0.01, reading(), FilterInputs(heading=radians(40.0)))
    assert isinf(off.inflation[3])
    assert not off.mag_used
    assert off.residual[3] == pytest.approx(radians(40.0), abs=1e-6)
    assert abs(heading_between(off.q_nb, state.q_nb)) < 1e-9


def test_a_doubtful_heading_counts_less_and_a_plain_filter_takes_it_whole():
    state = run(RobustAdaptive(), [reading()] * 100)
    doubtful = FilterInputs(heading=radians(10.0))
    taken = PLAIN.step(state, 0.01, reading(), doubtful)
    softened = RobustAdaptive().step(state, 0.01, reading(), doubtful)
    assert softened.inflation[3] > 1.5
    assert 0.0 < heading_between(softened.q_nb, ONE) < 0.7 * heading_between(taken.q_nb, ONE)


def test_a_row_that_is_rejected_for_long_is_believed_again():
    """30 degrees off: nothing for five seconds, then home within three."""
    start = q_heading(radians(30.0))
    waiting = run(RobustAdaptive(), [reading()] * 495, start)
    home = run(RobustAdaptive(), [reading()] * 800, start)
    never = run(RobustAdaptive(reacquire_s=inf), [reading()] * 800, start)
    assert heading_between(waiting.q_nb, ONE) == pytest.approx(radians(30.0), abs=1e-6)
    assert waiting.rejected_s[3] == pytest.approx(4.95)
    assert abs(heading_between(home.q_nb, ONE)) < radians(1.0)
    assert home.rejected_s[3] == 0.0
    assert heading_between(never.q_nb, ONE) == pytest.approx(radians(30.0), abs=1e-6)


def test_a_prediction_that_disagrees_is_trusted_less():
    """A gyro that is 2 deg/s off: the adaptive factor opens the filter, and the heading lags much less."""
    turning = [reading((0.0, 0.0, radians(2.0)))] * 2000
    adaptive, fixed = run(RobustAdaptive(c=inf), turning), run(RobustAdaptive(c=inf, adaptive=False), turning)
    assert fixed.alpha == 1.0
    assert heading_between(adaptive.q_nb, ONE) < 0.5 * heading_between(fixed.q_nb, ONE)


def test_the_adaptive_factor_cannot_inflate_without_end():
    """No field, and spells of shaking: the variance of the unobserved heading stops at what an angle can be."""
    shaken = [reading(accel=(3.0, 0.0, -9.3), mag=None)] * 25 + [reading(mag=None)] * 100
    state = run(RobustAdaptive(robust=False), shaken * 12)
    assert 0.9 < np.array(state.covariance).diagonal().max() < 1.01


def test_a_vertical_heading_row_cannot_tilt():
    """A supplied heading that is off tilts a banked vehicle with Euler's row, not with the vertical one."""
    banked = q_from_euler(radians(60.0), radians(20.0), 0.0)
    blind = reading(accel=ZERO, mag=None)
    vertical = run(replace(PLAIN, r_heading=1e-6), [blind], banked, inputs=FilterInputs(heading=radians(4.0)))
    euler = run(
        replace(PLAIN, printed=True, r_heading=1e-6), [blind], banked, inputs=FilterInputs(heading=radians(4.0))
    )
    assert tilt_between(vertical.q_nb, banked) < radians(0.1)
    assert tilt_between(euler.q_nb, banked) > radians(1.0)


# --- readings that are missing or bad -----------------------------------------------------------------------------


def test_without_a_field_the_heading_is_kept_and_its_sigma_grows():
    state = run(RobustAdaptive(), [reading(mag=None)] * 1000, q_heading(1.0))
    assert heading_between(state.q_nb, ONE) == pytest.approx(1.0)
    assert not state.mag_used
    assert isnan(state.residual[3])
    longer = run(RobustAdaptive(), [reading(mag=None)] * 2000, q_heading(1.0))
    assert longer.heading_sigma > state.heading_sigma
    assert longer.tilt_sigma == pytest.approx(state.tilt_sigma, rel=0.05)


@pytest.mark.parametrize(
    "mag", [(nan, 0.2, 0.3), (inf, 0.0, 0.0), (0.0, 0.0, 0.0), (1e200, 0.0, 1e200), (0.001, 0.0, 0.5)]
)
def test_a_field_that_shows_no_heading_is_not_used(mag):
    state = run(RobustAdaptive(), [reading(mag=mag)] * 3)
    assert not state.mag_used
    assert state.q_nb == pytest.approx(ONE)


@pytest.mark.parametrize(
    "accel", [(nan, 0.0, -9.8), (inf, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, -14.0), (1e308, 1e308, 0.0)]
)
def test_an_accelerometer_out_of_its_gate_is_not_used(accel):
    state = run(RobustAdaptive(), [reading(accel=accel)] * 3)
    assert not state.accel_used
    assert state.mag_used
    assert state.q_nb == pytest.approx(ONE)


@pytest.mark.parametrize("gyro", [(nan, 0.0, 0.0), (inf, 0.0, 0.0), (1e200, 1e200, 0.0)])
def test_a_senseless_gyro_holds_everything(gyro):
    before = run(RobustAdaptive(), [reading(GYRO)] * 10)
    after = RobustAdaptive().step(before, 0.01, reading(gyro), NO_INPUTS)
    assert after.q_nb == before.q_nb
    assert after.covariance == before.covariance
    assert not after.accel_used
    assert not after.mag_used


def test_saturation_skips_the_accelerometer_and_widens_the_covariance():
    before = run(RobustAdaptive(), [reading()] * 500)
    usual = RobustAdaptive().step(before, 0.01, reading(mag=None, accel=ZERO), NO_INPUTS)
    saturated = RobustAdaptive().step(before, 0.01, reading(mag=None, saturated=True), NO_INPUTS)
    assert not saturated.accel_used
    growth = (saturated.tilt_sigma**2 - before.tilt_sigma**2) / (usual.tilt_sigma**2 - before.tilt_sigma**2)
    assert growth == pytest.approx(10.0, rel=1e-6)


def test_a_gap_turns_exactly_and_widens_with_its_length():
    rate = (0.3, -0.4, 1.2)
    blind = reading(rate, ZERO, None)
    once = run(RobustAdaptive(), [blind], dt_s=0.9)
    often = run(RobustAdaptive(), [blind] * 90, dt_s=0.01)
    assert once.q_nb == pytest.approx(often.q_nb, abs=1e-12)
    assert once.heading_sigma == pytest.approx(often.heading_sigma, rel=1e-3)


def test_a_broken_covariance_asks_for_a_new_start():
    assert isnan(q_norm(run(RobustAdaptive(p0=inf), [reading()]).q_nb))


# --- properties ---------------------------------------------------------------------------------------------------

numbers = st.floats(allow_nan=True, allow_infinity=True)
vectors = st.one_of(
    st.tuples(*[st.floats(-50.0, 50.0)] * 3), st.tuples(numbers, numbers, numbers), st.just(LEVEL), st.just(ZERO)
)


@pytest.mark.parametrize("filter_", [RobustAdaptive(), PRINTED, PLAIN], ids=["recommended", "printed", "plain"])
@given(st.lists(st.tuples(vectors, vectors, vectors, numbers, st.floats(1e-4, 1.0), st.booleans()), max_size=30))
@settings(derandomize=True, max_examples=100, deadline=None)
def test_whatever_comes_the_state_stays_sound_or_asks_for_a_start(filter_, readings):
    state = started(filter_)
    for gyro, accel, mag, heading, dt_s, saturated in readings:
        state = filter_.step(state, dt_s, reading(gyro, accel, mag, saturated), FilterInputs(heading=heading))
        if isnan(q_norm(state.q_nb)):
            return
        p = np.array(state.covariance)
        assert q_norm(state.q_nb) == pytest.approx(1.0, abs=1e-12)
        assert (p == p.T).all()
        assert p.diagonal().min() >= 1e-14
        assert np.linalg.eigvalsh(p).min() > -1e-12 * max(1.0, p.diagonal().max())
        assert 0.0 < state.alpha <= 1.0
        assert 0.0 <= state.tilt_sigma < inf
        assert 0.0 <= state.heading_sigma < inf


def test_a_run_cut_in_two_is_the_whole_run_bit_for_bit():
    rng = np.random.default_rng(3)
    samples = [
        reading(tuple(g), tuple(a), tuple(m))
        for g, a, m in zip(
            rng.normal(0.0, 0.3, (400, 3)).tolist(),
            (rng.normal(0.0, 0.5, (400, 3)) + LEVEL).tolist(),
            (rng.normal(0.0, 0.02, (400, 3)) + NORTH_FIELD).tolist(),
            strict=True,
        )
    ]
    whole = run(RobustAdaptive(), samples)
    half = run(RobustAdaptive(), samples[:200])
    other = RobustAdaptive()
    for sample in samples[200:]:
        half = other.step(half, 0.01, sample, NO_INPUTS)
    assert (half.q_nb, half.covariance, half.rejected_s) == (whole.q_nb, whole.covariance, whole.rejected_s)


def test_the_sigmas_are_honest_on_noise_that_fits():
    """Errors over sigma, in tilt and heading, over runs with white noise as large as the filter is told."""
    ratios = []
    for seed in range(30):
        rng = np.random.default_rng(seed)
        filter_ = RobustAdaptive(gyro_noise=1e-6)
        samples = [
            reading(tuple(g), tuple((G_MPS2 * a).tolist()), None)
            for g, a in zip(
                rng.normal(0.0, sqrt(1e-6 / 0.01), (600, 3)).tolist(),
                np.array([0.0, 0.0, -1.0]) + rng.normal(0.0, sqrt(1e-3), (600, 3)),
                strict=True,
            )
        ]
        state = started(filter_)
        for sample, psi in zip(samples, rng.normal(0.0, sqrt(2.7e-3), 600).tolist(), strict=True):
            state = filter_.step(state, 0.01, sample, FilterInputs(heading=psi))
        ratios.append(
            (tilt_between(state.q_nb, ONE) / state.tilt_sigma, heading_between(state.q_nb, ONE) / state.heading_sigma)
        )
    rms = np.sqrt(np.mean(np.square(ratios), axis=0))
    assert 0.6 < rms[0] < 1.4
    assert 0.6 < rms[1] < 1.4


def test_headings_across_south_are_wrapped():
    south = run(PLAIN, [reading(mag=None)] * 50, q_heading(pi - 0.01), inputs=FilterInputs(heading=-pi + 0.01))
    assert abs(south.residual[3]) < 0.02

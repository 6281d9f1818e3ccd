"""Each measurement against differences: its residual when the truth is moved by a small error."""

import numpy as np
import pytest

from attest_mav.algebra import add, mat_vec, q_conj, q_exp, q_mul, q_to_matrix, rotate, rotate_back, scale
from attest_mav.filters.velocity_aided.aids.airspeed import airspeed_measurement
from attest_mav.filters.velocity_aided.aids.field import field_residual, levelled_field
from attest_mav.filters.velocity_aided.aids.gnss_velocity import velocity_measurement
from attest_mav.filters.velocity_aided.aids.gravity import gravity_measurements
from attest_mav.filters.velocity_aided.covariance import Covariance
from attest_mav.filters.velocity_aided.history import Lookback
from attest_mav.filters.velocity_aided.measurement import Measurement
from attest_mav.filters.velocity_aided.nav_state import NavigationState, cross_covariance_of, update
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.matrices import diagonal
from attest_mav.samples import ImuSample, VelocitySample
from attest_mav.types import G_MPS2, VelocityOrigin

SETTINGS = FlightParameters()
Q = (0.8, 0.3, -0.4, 0.33)
Q = tuple(x / np.linalg.norm(Q) for x in Q)
NONE = diagonal(0.0)
STEP = 1e-6


def nav(t=(0, 0, 0), v=(0, 0, 0), m=(0, 0, 0), d=(0, 0, 0)):
    """The estimate moved by an error, so that it is the truth of that error."""
    turned = q_mul(q_exp(scale(tuple(map(float, t)), 0.5)), Q)
    p = Covariance(*([NONE] * 36))
    return NavigationState(
        turned,
        add((12.0, -5.0, 1.0), tuple(map(float, v))),
        (0.0, 0.0, 0.0),
        (0.0, 0.0, 0.0),
        (0.0, 0.0, 0.0),
        (0.0, 0.0, 0.0),
        add((0.01, -0.02, 0.03), tuple(map(float, m))),
        *add((0.05, 0.1, 0.02), tuple(map(float, d))),
        p,
    )


def slope(residual, name):
    """- d residual / d error, by central differences: the measurement predicts residual = h . error."""
    result = []
    for axis in np.eye(3):
        ahead = residual(nav(**{name: STEP * axis}))
        behind = residual(nav(**{name: -STEP * axis}))
        result.append(-(ahead - behind) / (2.0 * STEP))
    return result


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_velocity_measurements(axis):
    """A fix is of an instant 0.25 s ago; since then the vehicle gained u, and turned with the error."""
    gain, force = (1.5, -2.0, -2.6), (4.0, -6.0, -10.0)
    accel = (4.0, -6.0, G_MPS2 - 10.0)
    fix = VelocitySample("GPS_RAW_INT", 1, 1, 0, 0, (11.0, -3.0, 0.5), True, VelocityOrigin.RECEIVER)
    measurement = velocity_measurement(nav(), Lookback(gain, 0.25, force), accel, fix, axis, SETTINGS)

    def residual(at):
        error = q_mul(at.q_nb, q_conj(Q))
        late = at.fix_lag_s - nav().fix_lag_s
        turned = rotate(error, gain)
        expected = [
            v - u - g + a * -late
            for v, u, g, a in zip(at.velocity, turned, (0.0, 0.0, G_MPS2 * 0.25), accel, strict=True)
        ]
        return fix.v_ned[axis] - expected[axis]

    assert measurement.residual == pytest.approx(residual(nav()), abs=1e-12)
    for name in "tvd":
        assert getattr(measurement, name) == pytest.approx(slope(residual, name), abs=1e-6)


def test_heading_measurement():
    field, rate, declination = (0.2, -0.3, 0.25), (0.3, -0.5, 0.8), 0.04
    levelled = levelled_field(nav(), field, rate, declination)
    measurement = levelled.measurement
    assert levelled.strength == pytest.approx(np.linalg.norm(np.subtract(field, nav().hard_iron)))
    assert np.linalg.norm(levelled.direction) == pytest.approx(1.0)

    def residual(at):
        then = q_mul(at.q_nb, q_exp(scale(rate, -0.5 * at.mag_lag_s)))
        field_n = rotate(then, tuple(f - m for f, m in zip(field, at.hard_iron, strict=True)))
        north = declination + at.declination_error
        return (np.sin(north) * field_n[0] - np.cos(north) * field_n[1]) / levelled.strength

    assert measurement.residual == pytest.approx(residual(nav()), abs=1e-12)
    assert measurement.t == pytest.approx(slope(residual, "t"), abs=1e-6)
    assert measurement.m == pytest.approx(slope(residual, "m"), abs=1e-6)
    # The lag is taken back by one turn at the present rate, of which the Jacobian has the first order.
    assert measurement.d == pytest.approx(slope(residual, "d"), abs=1e-6)


def test_the_whole_field_residual_has_the_covariance_that_the_errors_make():
    """Errors drawn from a covariance of attitude, hard iron and magnetometer delay, against their residuals."""
    rng = np.random.default_rng(7)
    gyro, reference = (0.3, -0.5, 0.8), (0.4, 0.05, np.sqrt(1.0 - 0.4**2 - 0.05**2))
    root = rng.normal(size=(7, 7)) * 1e-4
    p = np.zeros((24, 24))
    seven = [0, 1, 2, 15, 16, 17, 18]
    p[np.ix_(seven, seven)] = root @ root.T
    blocks = [
        tuple(tuple(float(x) for x in row) for row in p[3 * i : 3 * i + 3, 3 * j : 3 * j + 3])
        for i in range(8)
        for j in range(i, 8)
    ]

    def at(t, m, delay):
        one = nav(t=t, m=m, d=(delay, 0.0, 0.0))
        return one.with_covariance(Covariance(*blocks))

    sample = ImuSample("RAW_IMU", 1, 1, 0, 0, gyro, (0.0, 0.0, -9.8), (0.2, -0.3, 0.25))
    found = field_residual(at((0, 0, 0), (0, 0, 0), 0.0), gyro, sample, reference)
    errors = rng.normal(size=(4000, 7)) @ root.T
    residuals = np.array([field_residual(at(e[:3], e[3:6], e[6]), gyro, sample, reference).residual for e in errors])
    assert np.subtract(found.direction, reference) == pytest.approx(found.residual)
    expected = np.cov(residuals.T)
    assert np.allclose(found.covariance, expected, rtol=0.0, atol=0.08 * np.trace(expected))
    blind = ImuSample("RAW_IMU", 1, 1, 0, 0, gyro, (0.0, 0.0, -9.8), None)
    assert field_residual(nav(), gyro, blind, reference) is None


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_airspeed_measurements(axis):
    wind = (2.0, 1.0, -0.5)
    measurement = airspeed_measurement(nav(), wind, axis, 15.0)

    def residual(at):
        through_air = tuple(v - w for v, w in zip(at.velocity, wind, strict=True))
        return (15.0 if axis == 0 else 0.0) - rotate_back(at.q_nb, through_air)[axis]

    assert measurement.residual == pytest.approx(residual(nav()), abs=1e-12)
    for name in "tv":
        assert getattr(measurement, name) == pytest.approx(slope(residual, name), abs=1e-6)


@pytest.mark.parametrize("axis", [0, 1])
def test_gravity_measurements(axis):
    body_force = (2.0, -3.0, -8.5)
    force = mat_vec(q_to_matrix(Q), body_force)
    measurement = gravity_measurements(force)[axis]

    def residual(at):
        return -rotate(at.q_nb, body_force)[axis]

    assert measurement.residual == pytest.approx(residual(nav()), abs=1e-12)
    assert measurement.t == pytest.approx(slope(residual, "t"), abs=1e-6)


@pytest.mark.parametrize(("residual", "delay"), [(-5.0, -0.15), (5.0, 0.4), (0.1, 0.2)])
def test_a_delay_stays_one_that_can_be(residual, delay):
    """From the future, or from before the history, no fix would ever match a row again."""
    p = Covariance(*([NONE] * 33), diagonal(1.0), NONE, NONE)
    before = NavigationState(Q, *([(0.0, 0.0, 0.0)] * 6), 0.05, 0.1, 0.02, p)
    measurement = Measurement(residual, d=(0.0, 1.0, 0.0))
    after = update(before, measurement, cross_covariance_of(before, measurement), 1e-12)
    assert (after.mag_lag_s, after.fix_lag_s, after.declination_error) == pytest.approx((0.05, delay, 0.02), abs=1e-9)

"""Each measurement row against differences: what the residual becomes when the truth is moved by a small error."""

import numpy as np
import pytest

from attest_mav.algebra import add, mat_vec, q_conj, q_exp, q_mul, q_to_matrix, rotate, rotate_back, scale
from attest_mav.filters.velocity_aided.aids.airspeed import airspeed_measurement
from attest_mav.filters.velocity_aided.aids.gnss_velocity import velocity_measurement
from attest_mav.filters.velocity_aided.aids.gravity import gravity_measurements
from attest_mav.filters.velocity_aided.aids.magnetometer import heading_measurement
from attest_mav.filters.velocity_aided.covariance import Covariance, Measurement
from attest_mav.filters.velocity_aided.history import Lookback
from attest_mav.filters.velocity_aided.nav_state import NavigationState, cross_covariance_of, update
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.matrices import diagonal
from attest_mav.types import G_MPS2, VelocityOrigin, VelocitySample

SETTINGS = FlightParameters()
Q = (0.8, 0.3, -0.4, 0.33)
Q = tuple(x / np.linalg.norm(Q) for x in Q)
NONE = diagonal(0.0)
STEP = 1e-6


def nav(t=(0, 0, 0), v=(0, 0, 0), m=(0, 0, 0), d=(0, 0, 0)):
    """The estimate moved by an error, so that it is the truth of that error."""
    turned = q_mul(q_exp(scale(tuple(map(float, t)), 0.5)), Q)
    p = Covariance(*([NONE] * 28))
    return NavigationState(
        turned,
        add((12.0, -5.0, 1.0), tuple(map(float, v))),
        (0.0, 0.0, 0.0),
        (0.0, 0.0, 0.0),
        (0.0, 0.0, 0.0),
        add((0.01, -0.02, 0.03), tuple(map(float, m))),
        add((0.05, 0.1, 0.02), tuple(map(float, d))),
        p,
    )


def slope(residual, name):
    """- d residual / d error, by central differences: the row predicts residual = h . error."""
    result = []
    for axis in np.eye(3):
        ahead = residual(nav(**{name: STEP * axis}))
        behind = residual(nav(**{name: -STEP * axis}))
        result.append(-(ahead - behind) / (2.0 * STEP))
    return result


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_velocity_rows(axis):
    """A fix is of an instant 0.25 s ago; since then the vehicle gained u, and turned with the error."""
    gain, force = (1.5, -2.0, -2.6), (4.0, -6.0, -10.0)
    accel = (4.0, -6.0, G_MPS2 - 10.0)
    fix = VelocitySample("GPS_RAW_INT", 1, 1, 0, 0, (11.0, -3.0, 0.5), True, VelocityOrigin.RECEIVER)
    measurement = velocity_measurement(nav(), Lookback(gain, 0.25, force), accel, fix, axis, SETTINGS)

    def residual(at):
        error = q_mul(at.q_nb, q_conj(Q))
        late = at.delays[1] - nav().delays[1]
        turned = rotate(error, gain)
        expected = [
            v - u - g + a * -late
            for v, u, g, a in zip(at.velocity, turned, (0.0, 0.0, G_MPS2 * 0.25), accel, strict=True)
        ]
        return fix.v_ned[axis] - expected[axis]

    assert measurement.residual == pytest.approx(residual(nav()), abs=1e-12)
    for name in "tvd":
        assert getattr(measurement, name) == pytest.approx(slope(residual, name), abs=1e-6)


def test_magnetometer_row():
    field, rate, declination = (0.2, -0.3, 0.25), (0.3, -0.5, 0.8), 0.04
    measurement, levelled, strength = heading_measurement(nav(), field, rate, declination)
    assert strength == pytest.approx(np.linalg.norm(np.subtract(field, nav().hard_iron)))
    assert np.linalg.norm(levelled) == pytest.approx(1.0)

    def residual(at):
        then = q_mul(at.q_nb, q_exp(scale(rate, -0.5 * at.delays[0])))
        field_n = rotate(then, tuple(f - m for f, m in zip(field, at.hard_iron, strict=True)))
        north = declination + at.delays[2]
        return (np.sin(north) * field_n[0] - np.cos(north) * field_n[1]) / strength

    assert measurement.residual == pytest.approx(residual(nav()), abs=1e-12)
    assert measurement.t == pytest.approx(slope(residual, "t"), abs=1e-6)
    assert measurement.m == pytest.approx(slope(residual, "m"), abs=1e-6)
    # The lag is taken back by one turn at the present rate, of which the row has the first order.
    assert measurement.d == pytest.approx(slope(residual, "d"), abs=1e-6)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_wing_rows(axis):
    wind = (2.0, 1.0, -0.5)
    measurement = airspeed_measurement(nav(), wind, axis, 15.0)

    def residual(at):
        through_air = tuple(v - w for v, w in zip(at.velocity, wind, strict=True))
        return (15.0 if axis == 0 else 0.0) - rotate_back(at.q_nb, through_air)[axis]

    assert measurement.residual == pytest.approx(residual(nav()), abs=1e-12)
    for name in "tv":
        assert getattr(measurement, name) == pytest.approx(slope(residual, name), abs=1e-6)


@pytest.mark.parametrize("axis", [0, 1])
def test_gravity_rows(axis):
    body_force = (2.0, -3.0, -8.5)
    force = mat_vec(q_to_matrix(Q), body_force)
    measurement = gravity_measurements(force)[axis]

    def residual(at):
        return -rotate(at.q_nb, body_force)[axis]

    assert measurement.residual == pytest.approx(residual(nav()), abs=1e-12)
    assert measurement.t == pytest.approx(slope(residual, "t"), abs=1e-6)


@pytest.mark.parametrize(("residual", "delay"), [(-5.0, 0.0), (5.0, 0.4), (0.1, 0.2)])
def test_a_delay_stays_one_that_can_be(residual, delay):
    """From the future, or from before the history, no fix would ever match a row again."""
    p = Covariance(*([NONE] * 27), diagonal(1.0))
    before = NavigationState(Q, *([(0.0, 0.0, 0.0)] * 5), (0.05, 0.1, 0.02), p)
    measurement = Measurement(residual, d=(0.0, 1.0, 0.0))
    after = update(before, measurement, cross_covariance_of(before, measurement), 1e-12)
    assert after.delays == pytest.approx((0.05, delay, 0.02), abs=1e-9)

"""The smoother without a velocity: iron that is there from the beginning, and a magnet that is fixed to it for a while.

The motion is made with ``evaluation.motion``, whose own tests hold it against the paper's equations.
"""

import numpy as np
import pytest

from attest_mav import Readings, smooth_readings
from attest_mav.algebra import heading_between
from attest_mav.evaluation.motion import euler_to_quaternion, mean_rate, times, to_body
from attest_mav.filters.velocity_aided.parameters import BARE_SENSOR

RATE_HZ = 25.0
FIELD_NED = np.array([0.2, 0.0, 0.45])
GRAVITY_NED = np.array([0.0, 0.0, 9.80665])
BEGINS_S, ENDS_S = 10.0, 70.0


@pytest.fixture(scope="module")
def tumbling():
    """Ten seconds of rest, a minute of turns about all axes, and rest again."""
    t = times(80.0, RATE_HZ)
    fade = np.clip(np.minimum(t - BEGINS_S, ENDS_S - t), 0.0, 1.0)
    angles = (1.2 * fade * np.sin(0.9 * t), 1.0 * fade * np.sin(0.7 * t), 0.4 + 1.1 * np.cumsum(fade) / RATE_HZ)
    return t, euler_to_quaternion(*angles)


@pytest.fixture(scope="module")
def heading_errors(tumbling):
    """Heading errors (degrees) with this iron at each instant, gauss."""
    t, q = tumbling
    rng = np.random.default_rng(5)
    mean = mean_rate(q, 1.0 / RATE_HZ)
    gyro = 0.5 * (np.vstack((mean[:1], mean)) + np.vstack((mean, mean[-1:]))) + 2e-3 * rng.standard_normal((len(t), 3))
    accel = to_body(q, -GRAVITY_NED) + 0.03 * rng.standard_normal((len(t), 3))
    field = to_body(q, FIELD_NED) + 2e-3 * rng.standard_normal((len(t), 3))

    def errors(iron):
        found = smooth_readings(Readings(t, gyro, accel, field + iron, declination=0.0), BARE_SENSOR).attitudes
        pairs = zip(found[1:].tolist(), q[1:].tolist(), strict=True)
        return np.degrees([heading_between(tuple(one), tuple(true)) for one, true in pairs])

    return errors


def test_iron_of_a_quarter_of_the_field(heading_errors):
    assert np.abs(heading_errors(np.array([-0.07, 0.07, 0.07]))).max() < 3.0


def test_a_magnet_that_is_fixed_to_the_sensor_for_a_while(heading_errors, tumbling):
    t, _ = tumbling
    attached = ((t > BEGINS_S) & (t < 65.0))[:, np.newaxis] * np.array([0.1, 0.1, -0.1])
    assert np.abs(heading_errors(attached)).max() < 1.5


def test_nothing_is_taken_off_a_calibrated_magnetometer(heading_errors):
    assert np.abs(heading_errors(np.zeros(3))).max() < 1.0

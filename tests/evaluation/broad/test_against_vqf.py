"""Motions that mislead filters in the hand, beside VQF on the same readings, by the metric of BROAD's authors."""

from dataclasses import dataclass, field
from math import radians

import numpy as np
import pytest

from attest_mav.evaluation.broad import ours, peers
from attest_mav.evaluation.broad.metric import errors
from attest_mav.evaluation.broad.trial import Trial
from attest_mav.evaluation.motion import conjugate, euler_to_quaternion, mean_rate, multiply, times, to_body
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.filters.velocity_aided.parameters import BARE_SENSOR

UP = np.array([0.0, 0.0, 9.80665])
FIELD_ENU = np.array([0.0, 17.0, -40.0])
"""microtesla."""
GYRO_BIAS, ACCEL_BIAS = np.array((0.004, -0.003, 0.005)), np.array((0.03, -0.04, 0.05))
"""rad/s, m/s^2."""
REST_S = 5.0


@dataclass
class Made:
    """A motion in ENU by Euler angles (rad) and places (m), and the disturbance of its readings."""

    angles: tuple
    place: np.ndarray
    rate_hz: float = 100.0
    magnet: tuple = ()
    """Place (m) and moment (microtesla m^3) of a dipole that stays where it is."""
    vibration: float = 0.0
    """m/s^2, at 151 Hz, while it moves."""
    gyro_scale: float = 0.003
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(3))

    def trial(self):
        """The readings with the errors of an ordinary sensor."""
        q, dt_s = euler_to_quaternion(*self.angles), 1.0 / self.rate_hz
        mean = mean_rate(q, dt_s)
        moving = fading(len(q), self.rate_hz)[1:]
        rate = 0.5 * (mean + np.vstack((mean[1:], mean[-1:])))
        acceleration = np.gradient(np.gradient(self.place, dt_s, axis=0), dt_s, axis=0)
        force = to_body(q, acceleration + UP)[1:]
        field_enu = FIELD_ENU + (dipole(self.place, *self.magnet) if self.magnet else 0.0)
        shaking = self.vibration * moving * np.sin(2.0 * np.pi * 151.3 * np.arange(1, len(q)) * dt_s)
        gyr = rate * (1.0 + self.gyro_scale) + GYRO_BIAS + np.outer(shaking, (0.004, 0.01, 0.006))
        acc = force + ACCEL_BIAS + np.outer(shaking, (0.5, 0.3, 0.8))
        mag = to_body(q, field_enu)[1:]
        noise = self.rng.standard_normal
        return Trial(
            "made",
            self.rate_hz,
            gyr + 0.002 * noise(gyr.shape),
            acc + 0.04 * noise(acc.shape),
            mag + 0.4 * noise(mag.shape),
            q[1:],
            moving > 0.0,
        )


def fading(count, rate_hz):
    """0 at rest, at the beginning and at the end, and 1 in between."""
    t = np.arange(count) / rate_hz
    share = np.clip(np.minimum(t - REST_S, t[-1] - REST_S - t), 0.0, 1.0)
    return share * share * (3.0 - 2.0 * share)


def dipole(place, at, moment):
    """Field of a magnet at places, microtesla."""
    away = place - at
    distance = np.linalg.norm(away, axis=1, keepdims=True)
    u = away / distance
    return (3.0 * u * (u @ np.array(moment))[:, None] - moment) / distance**3


def turned_by_hand(seconds, rate_hz, swing=0.2, **how):
    """Rotations about all axes while the hand swings."""
    t = times(seconds, rate_hz)
    fade = fading(len(t), rate_hz)
    angles = (1.05 * fade * np.sin(1.3 * t), 0.87 * fade * np.sin(1.9 * t + 1.0), 0.4 + 1.5 * fade * np.sin(0.6 * t))
    waves = [fade * np.sin(2.0 * np.pi * f * t + p) for f, p in ((0.7, 0.2), (1.1, 0.9), (0.5, 1.7))]
    return Made(angles, swing * np.stack(waves, axis=1), rate_hz, **how)


def spun(lever_m, gyro_scale):
    """Turns about the vertical at 200 deg/s, the sensor off their axis."""
    t = times(45.0, 100.0)
    fade = fading(len(t), 100.0)
    yaw = 0.4 + radians(200.0) * np.cumsum(fade) / 100.0
    angles = (0.05 * fade * np.sin(2.1 * t), 0.05 * fade * np.cos(1.7 * t) - 0.05 * fade, yaw)
    q = euler_to_quaternion(*angles)
    arm = np.tile((0.0, lever_m, 0.0, 0.0), (len(q), 1))
    return Made(angles, multiply(multiply(q, arm), conjugate(q))[:, 1:], gyro_scale=gyro_scale)


def brought_near_a_magnet(moment):
    """The hand goes to a magnet and back, twice."""
    made = turned_by_hand(50.0, 100.0, swing=0.05)
    t = times(50.0, 100.0)
    way = 0.3 * fading(len(t), 100.0) * (1.0 - np.cos(2.0 * np.pi * (t - REST_S) / 20.0))
    made.place = made.place + np.outer(way, (1.0, 0.0, 0.0))
    made.magnet = ((0.8, 0.12, -0.1), moment)
    return made


def compared(made, with_mag=True):
    """The errors of the flight filter and of VQF."""
    trial = made.trial()
    own = ours.attitudes(VelocityAided(BARE_SENSOR), trial, with_mag)
    return errors(trial, own), errors(trial, peers.vqf(trial, with_mag))


@pytest.mark.parametrize(("lever_m", "gyro_scale"), [(0.0, 0.003), (0.0, 0.0003), (0.1, 0.0003)])
def test_fast_turns_about_the_vertical(lever_m, gyro_scale):
    own, vqf = compared(spun(lever_m, gyro_scale))
    assert own.total < vqf.total


def test_a_magnet_that_stays_where_it_is():
    moments = [(-0.06, 0.05, 0.06), (0.03, 0.08, -0.05), (0.02, -0.07, 0.07), (0.2, 0.15, -0.15)]
    pairs = [compared(brought_near_a_magnet(moment)) for moment in moments]
    assert np.mean([own.total for own, _ in pairs]) < np.mean([vqf.total for _, vqf in pairs])


@pytest.mark.parametrize("vibration", [2.0, 8.0])
def test_the_vibration_of_a_phone(vibration):
    own, vqf = compared(turned_by_hand(40.0, 286.0, vibration=vibration))
    assert own.total < vqf.total
    assert own.inclination < vqf.inclination

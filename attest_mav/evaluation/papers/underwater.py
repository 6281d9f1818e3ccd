"""The experiment of paper 3: an underwater vehicle with a speed sensor, moving or standing, and the filter on it.

Navigation-grade sensors; the Earth turns. Rates and specific force are those in the middle of each interval.
"""

from dataclasses import dataclass
from math import cos, pi, radians, sin
from typing import Final

import numpy as np

from attest_mav.algebra import clamp, q_from_euler, q_to_euler
from attest_mav.evaluation.motion import Array, euler_to_quaternion, to_body
from attest_mav.evaluation.readings import samples_of
from attest_mav.filters.base import BodyVelocity, FilterInputs, Start
from attest_mav.filters.leveling.filter import Leveling
from attest_mav.filters.leveling.north import EARTH_RATE
from attest_mav.filters.leveling.state import LevelingState
from attest_mav.samples import ImuSample
from attest_mav.types import North, Quat

GRAVITY: Final = 9.81
LATITUDE: Final = radians(37.5)
DURATION_S: Final = 30.0
PITCH_PERIOD_S: Final = 14.0
YAW_PERIOD_S: Final = 50.0
FIELD_NED: Final = (cos(radians(60.0)), 0.0, sin(radians(60.0)))
DEG_PER_HOUR: Final = radians(1.0) / 3600.0
MILLI_G: Final = 1e-3 * GRAVITY


@dataclass(frozen=True)
class Course:
    """speed: along the nose, m/s. yaw_rate_deg: amplitude of the turning, deg/s. pitch_deg: amplitude of the pitch."""

    speed: float = 4.0
    yaw_rate_deg: float = 0.0
    pitch_deg: float = 0.0


STANDING: Final = Course(speed=0.0)
STRAIGHT: Final = Course()
WINDING_LEVEL: Final = Course(yaw_rate_deg=8.6)
WINDING: Final = Course(yaw_rate_deg=8.6, pitch_deg=3.0)
"""The paper's S-shaped course: turns with a period of 50 s, pitch with one of 14 s."""


@dataclass(frozen=True)
class Sensors:
    """Fixed biases, the same in every run, and white noise a sample.

    gyro_bias: per axis, deg/h. gyro_noise: deg/h. accel_bias: every axis, mg. accel_noise: mg. speed_bias,
    speed_noise: m/s. mag_noise: of the field.
    """

    gyro_bias: tuple[float, float, float] = (1.0, 1.0, 1.0)
    gyro_noise: float = 0.3
    accel_bias: float = 1.0
    accel_noise: float = 0.05
    speed_bias: float = 0.1
    speed_noise: float = 0.1
    mag_noise: float = 0.008


@dataclass(frozen=True)
class Setting:
    """A course, the sensors on it, and how often they speak.

    rate_hz: of the inertial samples. speed_every: a speed comes with every so many of them. stationary: the filter is
    told that the vehicle stands. magnetic: the heading comes from a magnetometer, else it is supplied and right.
    start_deg: one sigma of the error of roll and pitch at the start, and with ``magnetic`` of the heading.
    """

    course: Course = WINDING
    sensors: Sensors = Sensors()
    rate_hz: float = 100.0
    speed_every: int = 5
    stationary: bool = False
    magnetic: bool = False
    start_deg: float = 45.0


@dataclass(frozen=True, eq=False)
class Voyage:
    """One run: where the filter starts, its input, and the true Euler angles at each sample, rad, shape (n, 3)."""

    start: Start
    dt_s: float
    samples: list[ImuSample]
    inputs: list[FilterInputs]
    truth: Array


def voyage(setting: Setting, rng: np.random.Generator) -> Voyage:
    """Simulate the sensors once."""
    sensors, dt_s = setting.sensors, 1.0 / setting.rate_hz
    count = round(DURATION_S * setting.rate_hz)
    times = np.arange(count, dtype=np.float64) * dt_s
    gyro, force = _true_readings(setting.course, times + 0.5 * dt_s)
    gyro += DEG_PER_HOUR * (np.array(sensors.gyro_bias) + sensors.gyro_noise * rng.standard_normal((count, 3)))
    force += MILLI_G * (sensors.accel_bias + sensors.accel_noise * rng.standard_normal((count, 3)))
    speeds = setting.course.speed + sensors.speed_bias + sensors.speed_noise * rng.standard_normal(count)
    truth = course_angles(setting.course, times + dt_s)
    mag = None
    if setting.magnetic:
        mag = to_body(euler_to_quaternion(*truth.T), np.array(FIELD_NED))
        mag += sensors.mag_noise * rng.standard_normal((count, 3))
    return Voyage(
        start=Start(_wrong_start(setting, rng), (0.0, 0.0, 0.0), North.TRUE, (0.0, 0.0, -GRAVITY), None),
        dt_s=dt_s,
        samples=samples_of(gyro, force, mag, dt_s),
        inputs=[
            FilterInputs(
                body_velocity=BodyVelocity(speed, is_new=k % setting.speed_every == 0),
                stationary=setting.stationary,
                latitude=LATITUDE,
                heading=None if setting.magnetic else heading,
            )
            for k, (speed, heading) in enumerate(zip(speeds.tolist(), truth[:, 2].tolist(), strict=True))
        ],
        truth=truth,
    )


def _wrong_start(setting: Setting, rng: np.random.Generator) -> Quat:
    """The attitude at the start with its random errors. A pitch drawn beyond the vertical is taken as vertical."""
    roll, pitch, yaw = (radians(setting.start_deg) * rng.standard_normal(3)).tolist()
    return q_from_euler(roll, clamp(pitch, -0.5 * pi, 0.5 * pi), yaw if setting.magnetic else 0.0)


def course_angles(course: Course, t: Array) -> Array:
    """True roll, pitch and yaw at times t, rad, shape (n, 3)."""
    pitch = radians(course.pitch_deg) * np.sin(2.0 * pi * t / PITCH_PERIOD_S)
    yaw = radians(course.yaw_rate_deg) * YAW_PERIOD_S / (2.0 * pi) * (1.0 - np.cos(2.0 * pi * t / YAW_PERIOD_S))
    return np.column_stack((np.zeros(len(t)), pitch, yaw))


def _true_readings(course: Course, t: Array) -> tuple[Array, Array]:
    """Rate against the stars and specific force at times t, body, shape (n, 3); eqs. (2), (12), (13)."""
    angles = course_angles(course, t)
    q = euler_to_quaternion(*angles.T)
    pitch_rate = radians(course.pitch_deg) * 2.0 * pi / PITCH_PERIOD_S * np.cos(2.0 * pi * t / PITCH_PERIOD_S)
    yaw_rate = radians(course.yaw_rate_deg) * np.sin(2.0 * pi * t / YAW_PERIOD_S)
    # With no roll, eq. (2): the yaw rate lies along the true vertical.
    turn = np.column_stack((-yaw_rate * np.sin(angles[:, 1]), pitch_rate, yaw_rate * np.cos(angles[:, 1])))
    earth = to_body(q, EARTH_RATE * np.array([cos(LATITUDE), 0.0, -sin(LATITUDE)]))
    gravity = to_body(q, np.array([0.0, 0.0, GRAVITY]))
    velocity = np.array([course.speed, 0.0, 0.0])
    return turn + earth, np.cross(turn + 2.0 * earth, velocity) - gravity


def states(chosen: Leveling, run: Voyage) -> list[LevelingState]:
    """The filter's state after each sample."""
    state = chosen.initial(run.start)
    after = []
    for sample, inputs in zip(run.samples, run.inputs, strict=True):
        state = chosen.step(state, run.dt_s, sample, inputs)
        after.append(state)
    return after


def angle_errors(after: list[LevelingState], truth: Array) -> Array:
    """Estimated minus true roll, pitch and yaw, degrees, wrapped, shape (n, 3)."""
    difference = np.array([q_to_euler(state.q_nb) for state in after]) - truth
    return np.degrees((difference + pi) % (2.0 * pi) - pi)

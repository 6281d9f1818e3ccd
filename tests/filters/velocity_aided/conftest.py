"""Flights with a known truth, as telemetry shows them: low-passed, delayed, held, truncated.

The truth is made here and not by ``attest_mav.sim``: its rates and accelerations are differences on a grid of 2 ms,
those of the simulator are derivatives of jets, so an error of one would show against the other's figures. The
simulator's flights, through its messages and the whole daemon, are in tests/scenario.
"""

import copy
from dataclasses import dataclass, field
from math import radians

import numpy as np
import pytest

from attest_mav.algebra import heading_between, q_from_euler, rotate, rotate_back, tilt_between
from attest_mav.filters.base import Airspeed, FilterInputs, Start
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.samples import ImuSample, VelocitySample
from attest_mav.types import G_MPS2, AirspeedSource, North, Quantum, VelocityOrigin

RECEIVER = VelocityOrigin.RECEIVER
DECLINATION = radians(3.0)
DIP = radians(66.0)
FIELD = (0.49 * np.cos(DIP) * np.cos(DECLINATION), 0.49 * np.cos(DIP) * np.sin(DECLINATION), 0.49 * np.sin(DIP))
LOW_PASS_S = 0.0112540
FINE_S = 0.002
ONE = (1.0, 0.0, 0.0, 0.0)
ZERO = (0.0, 0.0, 0.0)
SWINGS = ((0.7, 0.2), (1.1, 0.9), (0.5, 1.7))
"""Frequency (Hz) and phase of the hand along each axis; 0.2 m each, so up to 9 m/s^2."""


@dataclass
class Telemetry:
    """What stands between the motion and the filter. Units as in the samples; noises are standard deviations."""

    rate_hz: float = 50.0
    integer: bool = True
    mag_lag_s: float = 0.055
    fix_delay_s: float = 0.1
    fix_noise: float = 0.02
    gyro_bias: tuple = ZERO
    accel_bias: tuple = ZERO
    hard_iron: tuple = ZERO
    gyro_noise: float = 0.0
    accel_noise: float = 0.0
    mag_noise: float = 0.0
    airspeed: bool = False
    seed: int = 0


@dataclass
class Motion:
    """A motion on a fine grid: attitudes (N, 4), body rates, velocities and accelerations in NED (N, 3)."""

    q: np.ndarray
    rate: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray


def coordinated(seconds, bank, speed=20.0, heading=0.4, still_s=0.0):
    """A wing that banks by ``bank(t)`` (rad) at constant speed, after standing for ``still_s`` (a catapult, then)."""
    t = np.arange(0.0, seconds, FINE_S)
    flies = t >= still_s
    banked = np.where(flies, bank(np.maximum(t - still_s, 0.0)), 0.0)
    turn = np.where(flies, G_MPS2 * np.tan(banked) / speed, 0.0)
    yaw = heading + np.concatenate(([0.0], np.cumsum(0.5 * (turn[1:] + turn[:-1]) * FINE_S)))
    ahead = np.where(flies, speed, 0.0)
    velocity = np.stack([ahead * np.cos(yaw), ahead * np.sin(yaw), np.zeros_like(t)], axis=1)
    acceleration = np.stack([-turn * ahead * np.sin(yaw), turn * ahead * np.cos(yaw), np.zeros_like(t)], axis=1)
    roll_rate = np.gradient(banked, FINE_S)
    rate = np.stack([roll_rate, turn * np.sin(banked), turn * np.cos(banked)], axis=1)
    q = np.array([q_from_euler(b, 0.0, y) for b, y in zip(banked, yaw, strict=True)])
    return Motion(q, rate, velocity, acceleration)


def gusty(seconds, still_s=0.0, speed=4.0, heading=0.4):
    """A copter that is sent to and fro and leans into it, after standing for ``still_s``."""
    t = np.arange(0.0, seconds, FINE_S)
    s = np.maximum(t - still_s, 0.0)
    fade = np.minimum(s / 2.0, 1.0) ** 2 * (3.0 - 2.0 * np.minimum(s / 2.0, 1.0))
    vx = speed * fade * np.sin(0.9 * s)
    vy = speed * fade * np.sin(0.57 * s + 0.3) - speed * fade * np.sin(0.3)
    velocity = np.stack([vx, vy, np.zeros_like(t)], axis=1)
    acceleration = np.gradient(velocity, FINE_S, axis=0)
    yaw = heading + 0.8 * fade * np.sin(0.13 * s)
    forward = acceleration[:, 0] * np.cos(yaw) + acceleration[:, 1] * np.sin(yaw)
    right = -acceleration[:, 0] * np.sin(yaw) + acceleration[:, 1] * np.cos(yaw)
    pitch = -np.arctan2(forward, G_MPS2)
    roll = np.arctan2(right * np.cos(pitch), G_MPS2)
    q = np.array([q_from_euler(*angles) for angles in zip(roll, pitch, yaw, strict=True)])
    rates = np.stack([np.gradient(one, FINE_S) for one in (roll, pitch, yaw)], axis=1)
    rate = np.stack(
        [
            rates[:, 0] - rates[:, 2] * np.sin(pitch),
            rates[:, 1] * np.cos(roll) + rates[:, 2] * np.sin(roll) * np.cos(pitch),
            -rates[:, 1] * np.sin(roll) + rates[:, 2] * np.cos(roll) * np.cos(pitch),
        ],
        axis=1,
    )
    return Motion(q, rate, velocity, acceleration)


def carried():
    """Five seconds of rest, then 55 s of turning by up to 60 degrees and swinging by 0.2 m, then rest again."""
    t = np.arange(0.0, 65.0, FINE_S)
    fade = np.clip(np.minimum(t - 5.0, 60.0 - t), 0.0, 1.0)
    fade = fade * fade * (3.0 - 2.0 * fade)
    swing = np.stack([0.2 * fade * np.sin(2.0 * np.pi * f * t + p) for f, p in SWINGS], axis=1)
    velocity = np.gradient(swing, FINE_S, axis=0)
    angles = [
        radians(60.0) * fade * np.sin(1.3 * t),
        radians(50.0) * fade * np.sin(1.9 * t + 1.0),
        0.4 + 1.5 * fade * np.sin(0.6 * t),
    ]
    roll, pitch, _ = angles
    rolling, pitching, yawing = (np.gradient(one, FINE_S) for one in angles)
    rate = np.stack(
        [
            rolling - yawing * np.sin(pitch),
            pitching * np.cos(roll) + yawing * np.sin(roll) * np.cos(pitch),
            -pitching * np.sin(roll) + yawing * np.cos(roll) * np.cos(pitch),
        ],
        axis=1,
    )
    q = np.array([q_from_euler(*each) for each in zip(*angles, strict=True)])
    return Motion(q, rate, velocity, np.gradient(velocity, FINE_S, axis=0))


def body(q, v):
    return np.array(rotate_back(tuple(q), tuple(v)))


@dataclass
class Flight:
    """The samples with their aids, and the true attitude at each."""

    samples: list = field(default_factory=list)
    inputs: list = field(default_factory=list)
    truth: list = field(default_factory=list)

    def run(self, chosen=None, state=None, first=0, last=None):
        """The states after each sample of a part of the flight."""
        chosen = chosen or VelocityAided()
        states = []
        for k in range(first, len(self.samples) if last is None else last):
            sample = self.samples[k]
            if state is None:
                start = Start(ONE, ZERO, North.RELATIVE, sample.accel, sample.mag, at_rest=False)
                state = chosen.initial(start)
            else:
                dt_s = (sample.t_ns - self.samples[k - 1].t_ns) * 1e-9
                state = chosen.step(state, dt_s, sample, self.inputs[k])
            states.append(state)
        return states

    def errors(self, states, first=0):
        """Tilt and heading errors in degrees, NaN while the filter aligns."""
        tilt = [
            np.degrees(tilt_between(s.q_nb, q)) if s.aligned else np.nan
            for s, q in zip(states, self.truth[first:], strict=False)
        ]
        heading = [
            np.degrees(heading_between(s.q_nb, q)) if s.aligned else np.nan
            for s, q in zip(states, self.truth[first:], strict=False)
        ]
        return np.array(tilt), np.array(heading)


def telemetered(motion, how):
    """The flight as ``how`` shows the motion."""
    rng = np.random.default_rng(how.seed)
    step = round(1.0 / how.rate_hz / FINE_S)
    force = np.array([body(q, a - (0, 0, G_MPS2)) for q, a in zip(motion.q, motion.acceleration, strict=True)])
    flight = Flight()
    field_held, fix = None, None
    next_field, next_fix = 0.0, 0.0
    for k in range(step, len(motion.q), step):
        t = k * FINE_S
        lagged = max(0, k - round(LOW_PASS_S / FINE_S))
        gyro = motion.rate[lagged] + how.gyro_bias + rng.normal(0.0, how.gyro_noise, 3)
        accel = force[lagged] + how.accel_bias + rng.normal(0.0, how.accel_noise, 3)
        if t >= next_field:
            next_field += 0.1
            then = max(0, k - round(how.mag_lag_s / FINE_S))
            field_held = body(motion.q[then], FIELD) + how.hard_iron + rng.normal(0.0, how.mag_noise, 3)
        if t >= next_fix:
            next_fix += 0.2
            then = max(0, k - round(how.fix_delay_s / FINE_S))
            v = motion.velocity[then] + rng.normal(0.0, how.fix_noise, 3)
            fix = VelocitySample(
                "GPS_RAW_INT", 1, 1, round(t * 1e9), 0, (float(v[0]), float(v[1]), 0.0), False, RECEIVER
            )
        flight.samples.append(_sample(how, round(t * 1e9), gyro, accel, field_held))
        ahead = float(np.dot(motion.velocity[k], rotate(tuple(motion.q[k]), (1.0, 0.0, 0.0))))
        air = wing(ahead) if how.airspeed else {}
        flight.inputs.append(
            FilterInputs(velocity=fix, declination=DECLINATION, inclination=DIP, zero_mean_velocity=False, **air)
        )
        flight.truth.append(tuple(float(x) for x in motion.q[k]))
    return flight


def wing(speed):
    """The inputs of a vehicle that goes where it points, at this airspeed, m/s."""
    return {"airspeed": Airspeed(speed, AirspeedSource.SENSOR), "goes_where_it_points": True}


def _sample(how, t_ns, gyro, accel, mag):
    units = (1e-3, 1e-3 * G_MPS2, 1e-3) if how.integer else (0.0, 0.0, 0.0)
    values = [
        tuple(float(x) for x in (np.trunc(v / u) * u if u else v))
        for v, u in zip((gyro, accel, mag), units, strict=True)
    ]
    source = "RAW_IMU" if how.integer else "HIGHRES_IMU"
    return ImuSample(source, 1, 1, t_ns, t_ns, *values, quantum=Quantum(*units))


def rms(x):
    return float(np.sqrt(np.nanmean(np.square(x))))


@pytest.fixture(scope="session")
def s_turns():
    """Two minutes of S-turns of 45 degrees of bank, after ten seconds on the ground."""
    return coordinated(120.0, lambda t: radians(45.0) * np.sin(2.0 * np.pi * t / 14.0), still_s=10.0)


@pytest.fixture(scope="session")
def circles():
    """A minute of circles at 40 degrees of bank."""
    return coordinated(60.0, lambda t: radians(40.0) * np.minimum(t / 2.0, 1.0))


@pytest.fixture(scope="session")
def copter():
    """A copter to and fro for 90 s, after ten seconds on the ground."""
    return gusty(90.0, still_s=10.0)


@pytest.fixture(scope="session")
def hand():
    """A sensor that is turned by hand for 55 s."""
    return carried()


@pytest.fixture(scope="session")
def plane_log(s_turns):
    """The S-turns as telemetry shows them."""
    return telemetered(s_turns, Telemetry())


@pytest.fixture(scope="session")
def copter_log(copter):
    """The copter as telemetry shows it."""
    return telemetered(copter, Telemetry())


@pytest.fixture(scope="session")
def telemetry():
    """Makes a flight of a motion: ``telemetry(motion, rate_hz=10)``."""
    return lambda motion, **how: telemetered(motion, Telemetry(**how))


def changed(flight, change):
    """The flight with ``change(k, sample, inputs)`` applied to each sample from the start."""
    other = copy.copy(flight)
    pairs = [change(k, s, i) for k, (s, i) in enumerate(zip(flight.samples, flight.inputs, strict=True))]
    other.samples = [s for s, _ in pairs]
    other.inputs = [i for _, i in pairs]
    return other


def with_reading(sample, **others):
    """The sample with other readings."""
    values = {"gyro": sample.gyro, "accel": sample.accel, "mag": sample.mag, "saturated": sample.saturated}
    values |= others
    return ImuSample(sample.source, 1, 1, sample.t_ns, sample.rx_ns, **values, quantum=sample.quantum)


def with_inputs(inputs, **others):
    """The inputs with some of their fields replaced; every other one stays."""
    names = [name for name in dir(inputs) if not name.startswith("_") and not callable(getattr(inputs, name))]
    return FilterInputs(**{name: getattr(inputs, name) for name in names} | others)

"""Gyros and accelerometers: what the autopilot's driver makes of the true motion before it becomes a message.

Truth + bias + drift + white noise, clipped to the range, then ArduPilot's second-order Butterworth low-pass
(``LowPassFilter2p``, INS_GYRO_FILTER = INS_ACCEL_FILTER = 20 Hz), whose group delay at low frequencies is
sqrt(2) / (2 pi 20 Hz) = 11.25 ms, as seen in ArduPilot's simulator. Faults that add or scale act before the range;
those that put something else in the reading's place act behind the low-pass, at once.
"""

from math import cos, nan, pi, sqrt, tan
from random import Random
from typing import Final

from attest_mav.algebra import add, is_finite, scale, sub
from attest_mav.sim.draws import generator, noise
from attest_mav.sim.faults import NOWHERE, Effect, Faults, has
from attest_mav.sim.settings import SensorErrors
from attest_mav.types import G_MPS2, Vec3

GYRO_RANGE: Final = 2000.0 * pi / 180.0
"""rad/s."""
ACCEL_RANGE: Final = 16.0 * G_MPS2
"""m/s^2."""

DRIFT_EVERY_S: Final = 0.1
"""Drifts walk in steps of this length: nothing resolves more, and random numbers are what a tick costs."""


def clipped(v: Vec3, limit: float) -> Vec3:
    """v with each component held within the range."""
    if abs(v[0]) < limit and abs(v[1]) < limit and abs(v[2]) < limit:
        return v
    return (
        min(max(v[0], -limit), limit),
        min(max(v[1], -limit), limit),
        min(max(v[2], -limit), limit),
    )


class Lowpass:
    """ArduPilot's biquad in direct form II, settled on the first value at the start."""

    def __init__(self, rate_hz: float, cutoff_hz: float) -> None:
        ohm = tan(pi * cutoff_hz / rate_hz)
        c = 1.0 + 2.0 * cos(pi / 4.0) * ohm + ohm * ohm
        self.b = ohm * ohm / c
        self.a1 = 2.0 * (ohm * ohm - 1.0) / c
        self.a2 = (1.0 - 2.0 * cos(pi / 4.0) * ohm + ohm * ohm) / c
        self.d1: Vec3 | None = None
        self.d2: Vec3 = NOWHERE

    def step(self, x: Vec3) -> Vec3:
        """The filtered value after one more sample."""
        if self.d1 is None:
            self.d1 = self.d2 = scale(x, 1.0 / (1.0 + self.a1 + self.a2))
        a1, a2, d1, d2 = self.a1, self.a2, self.d1, self.d2
        d = (
            x[0] - a1 * d1[0] - a2 * d2[0],
            x[1] - a1 * d1[1] - a2 * d2[1],
            x[2] - a1 * d1[2] - a2 * d2[2],
        )
        self.d1, self.d2 = d, d1
        b = self.b
        return (
            b * (d[0] + 2.0 * d1[0] + d2[0]),
            b * (d[1] + 2.0 * d1[1] + d2[1]),
            b * (d[2] + 2.0 * d1[2] + d2[2]),
        )


class Triad:
    """Three axes of one kind: bias, drift, noise, range and low-pass.

    reading: the latest, SI units. error: what faults have changed in it. stopped: a fault that the driver notices.
    """

    def __init__(
        self,
        density: float,
        bias: float,
        drift: float,
        limit: float,
        rate_hz: int,
        lowpass_hz: float | None,
        rng: Random,
    ) -> None:
        self.sigma = density * sqrt(rate_hz)
        self.bias: Vec3 = noise(rng, bias)
        self.limit = limit
        self.rng = rng
        self.drift_every = max(round(DRIFT_EVERY_S * rate_hz), 1)
        self.drift_step = drift * sqrt(self.drift_every / rate_hz)
        self.lowpass = None if lowpass_hz is None else Lowpass(rate_hz, lowpass_hz)
        self.ticks = 0
        self.reading: Vec3 = NOWHERE
        self.error: Vec3 = NOWHERE
        self.stopped = False

    def update(self, true: Vec3, faults: Faults = ()) -> None:
        """Take one sample."""
        self.ticks += 1
        if self.ticks % self.drift_every == 0:
            self.bias = add(self.bias, noise(self.rng, self.drift_step))
        healthy = clipped(add(add(true, self.bias), noise(self.rng, self.sigma)), self.limit)
        if not faults:
            self.reading = healthy if self.lowpass is None else self.lowpass.step(healthy)
            self.error, self.stopped = NOWHERE, False
            return
        value = clipped(distorted(healthy, faults), self.limit)
        passed = value if self.lowpass is None else self.lowpass.step(value)
        self.reading = replaced(passed, self.reading, faults)
        wrong = add(sub(value, healthy), sub(self.reading, passed))
        self.error = wrong if is_finite(wrong) else NOWHERE
        self.stopped = has(faults, Effect.STOP)


def distorted(value: Vec3, faults: Faults) -> Vec3:
    """The value with the faults that add to it or scale it."""
    for fault in faults:
        v = fault.vector
        if fault.effect is Effect.OFFSET:
            value = add(value, v)
        elif fault.effect is Effect.SCALE:
            value = (value[0] * (1.0 + v[0]), value[1] * (1.0 + v[1]), value[2] * (1.0 + v[2]))
    return value


def replaced(reading: Vec3, before: Vec3, faults: Faults) -> Vec3:
    """The reading with the faults that put something else in its place. before: the reading of the last sample."""
    for fault in faults:
        if fault.effect is Effect.STUCK:
            x, y, z = (fault.size if axis in fault.axes else reading[axis] for axis in range(3))
            reading = (x, y, z)
        elif fault.effect is Effect.STOP:
            reading = NOWHERE
        elif fault.effect is Effect.FREEZE:
            reading = before
        elif fault.effect is Effect.NOT_FINITE:
            reading = (nan, nan, nan)
    return reading


class InertialUnit:
    """A gyro and an accelerometer."""

    def __init__(self, errors: SensorErrors, rate_hz: int, lowpass_hz: float | None, name: str) -> None:
        e = errors
        self.gyro = Triad(
            e.gyro_noise, e.gyro_bias, e.gyro_drift, GYRO_RANGE, rate_hz, lowpass_hz, generator(name, "gyro")
        )
        self.accel = Triad(
            e.accel_noise, e.accel_bias, e.accel_drift, ACCEL_RANGE, rate_hz, lowpass_hz, generator(name, "accel")
        )

    def update(self, rates: Vec3, force: Vec3, gyro: Faults = (), accel: Faults = ()) -> None:
        """Take one sample of the true angular rate (rad/s) and specific force (m/s^2), with faults of both."""
        if gyro and has(gyro, Effect.SATURATED):
            rates = (10.0 * GYRO_RANGE, rates[1], rates[2])
        if accel and has(accel, Effect.SATURATED):
            force = (force[0], force[1], -10.0 * ACCEL_RANGE)
        self.gyro.update(rates, gyro)
        self.accel.update(force, accel)

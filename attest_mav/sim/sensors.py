"""Sensors with errors: what the autopilot's driver makes of the true motion before it becomes a message.

Inertial unit: truth + bias + drift + white noise, clipped to the range, then ArduPilot's second-order Butterworth
low-pass (``LowPassFilter2p``, INS_GYRO_FILTER = INS_ACCEL_FILTER = 20 Hz), whose group delay at low frequencies is
sqrt(2) / (2 pi 20 Hz) = 11.25 ms. Magnetometer: a mean over ten readings, made ten times a second and held until
the next: it is 45 ms late when new, and near 57 ms in the first message of a 50 Hz stream that carries it.
GPS: five fixes a second, each telling of 100 ms before. All three delays are as seen in ArduPilot's simulator.
"""

from math import cos, pi, sqrt, tan
from random import Random
from typing import Final

from attest_mav.algebra import add, rotate_back, scale
from attest_mav.sim.motion import Motion
from attest_mav.sim.settings import SensorErrors
from attest_mav.sim.trajectory import Trajectory
from attest_mav.types import G_MPS2, Quat, Vec3

GYRO_RANGE: Final = 2000.0 * pi / 180.0
"""rad/s."""
ACCEL_RANGE: Final = 16.0 * G_MPS2
"""m/s^2."""

DRIFT_EVERY_S: Final = 0.1
"""Drifts walk in steps of this length: nothing resolves more, and random numbers are what a tick costs."""

GPS_PERIOD_NS: Final = 200_000_000
GPS_PHASE_NS: Final = 71_000_000
GPS_DELAY_S: Final = 0.1
GPS_SPEED_NOISE: Final = 0.04
"""m/s, one deviation of each horizontal component."""
GPS_POSITION_NOISE_M: Final = 0.3

NOTHING: Final[Vec3] = (0.0, 0.0, 0.0)


def noise(rng: Random, sigma: float) -> Vec3:
    """Three independent normal numbers."""
    gauss = rng.gauss
    return (gauss(0.0, sigma), gauss(0.0, sigma), gauss(0.0, sigma))


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
    """ArduPilot's biquad in direct form II. It starts settled on the first value."""

    def __init__(self, rate_hz: float, cutoff_hz: float) -> None:
        ohm = tan(pi * cutoff_hz / rate_hz)
        c = 1.0 + 2.0 * cos(pi / 4.0) * ohm + ohm * ohm
        self.b = ohm * ohm / c
        self.a1 = 2.0 * (ohm * ohm - 1.0) / c
        self.a2 = (1.0 - 2.0 * cos(pi / 4.0) * ohm + ohm * ohm) / c
        self.d1: Vec3 | None = None
        self.d2: Vec3 = NOTHING

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
    """Three axes of one kind: bias, drift, noise, range and low-pass. ``reading`` is the latest, SI units."""

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
        self.reading: Vec3 = NOTHING

    def update(self, true: Vec3) -> None:
        """Take one sample."""
        self.ticks += 1
        if self.ticks % self.drift_every == 0:
            self.bias = add(self.bias, noise(self.rng, self.drift_step))
        value = clipped(add(add(true, self.bias), noise(self.rng, self.sigma)), self.limit)
        self.reading = value if self.lowpass is None else self.lowpass.step(value)


class InertialUnit:
    """A gyro and an accelerometer."""

    def __init__(self, errors: SensorErrors, rate_hz: int, lowpass_hz: float | None, name: str) -> None:
        e = errors
        self.gyro = Triad(
            e.gyro_noise, e.gyro_bias, e.gyro_drift, GYRO_RANGE, rate_hz, lowpass_hz, _generator(name, "gyro")
        )
        self.accel = Triad(
            e.accel_noise, e.accel_bias, e.accel_drift, ACCEL_RANGE, rate_hz, lowpass_hz, _generator(name, "accel")
        )

    def update(self, rates: Vec3, force: Vec3) -> None:
        """Take one sample of the true angular rate (rad/s) and specific force (m/s^2)."""
        self.gyro.update(rates)
        self.accel.update(force)


class Magnetometer:
    """Readings at equal intervals, ``per_mean`` of which make the value that is held until the next.

    held: gauss, zeros before the first mean. count: how many means there have been.
    """

    PHASE_NS = 27_500_000
    """Means appear this long after the full tenths of a second, so that streams do not meet them fresh."""

    def __init__(self, errors: SensorErrors, field_ned: Vec3, period_ns: int, per_mean: int, name: str) -> None:
        self.rng = _generator(name, "mag")
        self.field_ned = field_ned
        self.bias = noise(self.rng, errors.mag_bias)
        self.sigma = errors.mag_noise
        self.every_ns = period_ns // per_mean
        self.per_mean = per_mean
        self.due_ns = self.PHASE_NS + self.every_ns
        self.sum: Vec3 = NOTHING
        self.summed = 0
        self.held: Vec3 = NOTHING
        self.count = 0

    def update(self, t_ns: int, q_nb: Quat) -> None:
        """Take a reading if one is due."""
        if t_ns < self.due_ns:
            return
        self.due_ns += self.every_ns
        reading = add(add(rotate_back(q_nb, self.field_ned), self.bias), noise(self.rng, self.sigma))
        self.sum = add(self.sum, reading)
        self.summed += 1
        if self.summed == self.per_mean:
            self.held = scale(self.sum, 1.0 / self.per_mean)
            self.count += 1
            self.sum, self.summed = NOTHING, 0


class Gps:
    """The latest fix: time (ns, 0 = none yet), position in NED (m) and velocity (m/s)."""

    def __init__(self, trajectory: Trajectory, first_fix_s: float, seed: int) -> None:
        self.trajectory = trajectory
        self.rng = _generator(str(seed), "gps")
        self.due_ns = GPS_PHASE_NS + GPS_PERIOD_NS * round(first_fix_s * 1e9 / GPS_PERIOD_NS)
        self.fix_ns = 0
        self.position: Vec3 = NOTHING
        self.velocity: Vec3 = NOTHING

    def update(self, t_ns: int) -> None:
        """Take a fix if one is due."""
        if t_ns < self.due_ns:
            return
        at_s = self.due_ns * 1e-9 - GPS_DELAY_S
        self.position = add(self.trajectory.position(at_s), noise(self.rng, GPS_POSITION_NOISE_M))
        self.velocity = add(self.trajectory.at(at_s).v_ned, noise(self.rng, GPS_SPEED_NOISE))
        self.fix_ns = self.due_ns
        self.due_ns += GPS_PERIOD_NS


class SensorSuite:
    """All sensors of one vehicle: two inertial units, each with a magnetometer, and a GPS."""

    def __init__(
        self,
        trajectory: Trajectory,
        errors: SensorErrors,
        field_ned: Vec3,
        rate_hz: int,
        lowpass_hz: float | None,
        mag_period_ns: int,
        mag_per_mean: int,
        first_fix_s: float,
        seed: int,
    ) -> None:
        names = [f"{seed} {unit}" for unit in (0, 1)]
        self.imus = [InertialUnit(errors, rate_hz, lowpass_hz, name) for name in names]
        self.mags = [Magnetometer(errors, field_ned, mag_period_ns, mag_per_mean, name) for name in names]
        self.gps = Gps(trajectory, first_fix_s, seed)

    def update(self, t_ns: int, motion: Motion, *, saturated: bool) -> None:
        """Take one sample of everything. ``saturated`` drives an axis of gyro and accelerometer out of its range."""
        rates, force = motion.rates, motion.specific_force()
        if saturated:
            rates = (10.0 * GYRO_RANGE, rates[1], rates[2])
            force = (force[0], force[1], -10.0 * ACCEL_RANGE)
        for imu in self.imus:
            imu.update(rates, force)
        for mag in self.mags:
            mag.update(t_ns, motion.q_nb)
        self.gps.update(t_ns)


def _generator(*words: str) -> Random:
    """A generator of its own for each sensor, so that what one draws changes nothing for the others."""
    return Random(" ".join(words))  # noqa: S311  # a simulation, no secret

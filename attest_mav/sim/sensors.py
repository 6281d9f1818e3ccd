"""All sensors of one vehicle, and the magnetometer.

Magnetometer: a mean over ten readings, made ten times a second and held until the next: it is 45 ms late when new, and
near 57 ms in the first message of a 50 Hz stream that carries it, as seen in ArduPilot's simulator.
"""

from math import pi, sin
from typing import Final

from attest_mav.algebra import add, rotate_back, scale
from attest_mav.sim.draws import generator, noise
from attest_mav.sim.faults import NOWHERE, SENSORS, Effect, Faults, FaultSchedule, Part, has, total
from attest_mav.sim.inertial import InertialUnit
from attest_mav.sim.motion import Motion
from attest_mav.sim.personality import Personality
from attest_mav.sim.receiver import Gps
from attest_mav.sim.settings import SensorErrors, SimSettings
from attest_mav.sim.trajectory import Trajectory
from attest_mav.types import Quat, Vec3

VIBRATION_HZ: Final = 147.0
"""No multiple of the usual message rates: sampled by those, such a vibration would look like a constant."""


class Magnetometer:
    """Readings at equal intervals, ``per_mean`` of which make the value that is held until the next.

    held: gauss, zeros before the first mean. count: how many means there have been. error: what faults add to the
    field, gauss.
    """

    PHASE_NS = 27_500_000
    """Means appear this long after the full tenths of a second, so that streams do not meet them fresh."""

    def __init__(self, errors: SensorErrors, field_ned: Vec3, period_ns: int, per_mean: int, name: str) -> None:
        self.rng = generator(name, "mag")
        self.field_ned = field_ned
        self.bias = noise(self.rng, errors.mag_bias)
        self.sigma = errors.mag_noise
        self.every_ns = period_ns // per_mean
        self.per_mean = per_mean
        self.due_ns = self.PHASE_NS + self.every_ns
        self.sum: Vec3 = NOWHERE
        self.summed = 0
        self.held: Vec3 = NOWHERE
        self.count = 0
        self.error: Vec3 = NOWHERE

    def update(self, t_ns: int, q_nb: Quat, faults: Faults = ()) -> None:
        """Take a reading if one is due."""
        self.error = total(faults, Effect.OFFSET) if faults else NOWHERE
        if t_ns < self.due_ns:
            return
        self.due_ns += self.every_ns
        reading = add(add(rotate_back(q_nb, self.field_ned), self.bias), noise(self.rng, self.sigma))
        self.sum = add(self.sum, add(reading, self.error))
        self.summed += 1
        if self.summed == self.per_mean:
            if not has(faults, Effect.FREEZE):
                self.held = scale(self.sum, 1.0 / self.per_mean)
            self.count += 1
            self.sum, self.summed = NOWHERE, 0


class SensorSuite:
    """All sensors of one vehicle: two inertial units, each with a magnetometer, and a GPS."""

    def __init__(
        self,
        settings: SimSettings,
        firmware: Personality,
        trajectory: Trajectory,
        faults: FaultSchedule,
        rate_hz: int,
        seed: int,
    ) -> None:
        names = [f"{seed} {sensor}" for sensor in SENSORS]
        errors, field_ned = settings.errors, settings.earth.field_ned()
        period_ns, per_mean = firmware.mag_period_ns, firmware.mag_per_mean
        self.imus = [InertialUnit(errors, rate_hz, firmware.lowpass_hz, name) for name in names]
        self.mags = [Magnetometer(errors, field_ned, period_ns, per_mean, name) for name in names]
        self.gps = Gps(trajectory, settings.first_fix_s, seed)
        self.faults = faults

    def update(self, t_ns: int, motion: Motion) -> None:
        """Take one sample of everything."""
        t_s, active = t_ns * 1e-9, self.faults.active
        force = motion.specific_force()
        for fault in active(Part.VEHICLE, t_s):
            if fault.effect is Effect.VIBRATION:
                force = add(force, vibration(fault.size, t_s))
        for sensor in SENSORS:
            whole = active(Part.IMU, t_s, sensor)
            gyro, accel = active(Part.GYRO, t_s, sensor) + whole, active(Part.ACCEL, t_s, sensor) + whole
            self.imus[sensor].update(motion.rates, force, gyro, accel)
            self.mags[sensor].update(t_ns, motion.q_nb, active(Part.COMPASS, t_s, sensor) + whole)
        self.gps.update(t_ns, active(Part.RECEIVER, t_s))


def vibration(amplitude: float, t_s: float) -> Vec3:
    """The specific force, m/s^2, of a frame that goes round at ``VIBRATION_HZ``."""
    x, y, z = (amplitude * sin(2.0 * pi * (VIBRATION_HZ * t_s + axis / 3.0)) for axis in range(3))
    return (x, y, z)

"""How faults get into the autopilot's attitude: a model of a filter with two lanes, one for each inertial sensor.

The attitude error e (rotation vector in NED, rad) of a lane follows the gyro error w (body, rad/s) of its sensor and is
pulled to a reference r, as in a complementary filter that also estimates the gyro's bias b::

    e' = C (w - b) - PULL (e - r)            b' = LEARN C^T (e - r)

A gyro bias step of 1 deg/s gives 2.1 degrees after 3 s and at most 2.7, one of 5 deg/s 10.6 degrees at the lane switch.
ArduPilot's EKF3 in its simulator: 2.3, 2.6 and 10.9 to 11.6. References move with the errors of the accelerometer, the
compass and the receiver, so small that the errors are those of that EKF3.
"""

from math import atan2, cos, hypot, pi, radians, sin
from typing import Final

from attest_mav.algebra import add, clamp, norm, rotate, rotate_back, scale, sub
from attest_mav.sim.draws import generator
from attest_mav.sim.faults import NOWHERE, SENSORS
from attest_mav.sim.inertial import InertialUnit
from attest_mav.sim.motion import Motion
from attest_mav.sim.receiver import Gps
from attest_mav.sim.sensors import Magnetometer, SensorSuite
from attest_mav.types import G_MPS2, Quat, Vec3

PULL: Final = 0.2
"""1/s."""
LEARN: Final = 0.04
"""1/s^2."""

TILT_SHARE: Final = 0.1
"""Of the tilt that an accelerometer's error seems to show; the rest is estimated as a bias."""
HEADING_SHARE: Final = 0.15
"""Of the heading that a compass's error seems to show; the rest is estimated as an offset."""
HEADING_GATE: Final = radians(45.0)
"""A compass that is wrong by more is rejected."""

VELOCITY_S: Final = 5.0
"""Time constant for a receiver's velocity error to be taken for true: only its changes look like acceleration."""
ACCELERATION_GATE: Final = 0.5
"""m/s^2; faster changes of the receiver's velocity error are rejected."""

DEAD_RECKONING_S: Final = 15.0
"""So long without a fix is bridged without an error."""
LOST_TILT: Final = radians(4.0)
LOST_HEADING: Final = radians(3.0)
"""Errors to which the attitude drifts after that."""

FAILED_TILT: Final = radians(3.0)
FAILED_HEADING: Final = radians(10.0)
FAILED_ANGLE_S: Final = 2.35
"""A lane fails when the error of its attitude exceeds these for that time: a bias of 5 deg/s takes 3.0 s to do so."""
FAILED_ACCEL: Final = 5.0
"""m/s^2."""
FAILED_SENSOR_S: Final = 0.24
"""A lane fails when its accelerometer errs by more, or its driver gives up a sensor, for that time."""


class AttitudeError:
    """The error of one attitude. angle: e, rad in NED. learned: b, rad/s in the body."""

    def __init__(self) -> None:
        self.angle: Vec3 = NOWHERE
        self.learned: Vec3 = NOWHERE

    def step(self, dt_s: float, q_nb: Quat, rate: Vec3, reference: Vec3) -> None:
        """Advance. rate: gyro error, rad/s in the body. reference: r, rad in NED."""
        if self.angle == rate == reference == self.learned == NOWHERE:
            return
        off = sub(self.angle, reference)
        drift = sub(rotate(q_nb, sub(rate, self.learned)), scale(off, PULL))
        self.learned = add(self.learned, scale(rotate_back(q_nb, off), LEARN * dt_s))
        self.angle = add(self.angle, scale(drift, dt_s))


class Lane:
    """One inertial sensor's share of the attitude error, and whether its filter can still be used."""

    def __init__(self, imu: InertialUnit, mag: Magnetometer) -> None:
        self.imu = imu
        self.mag = mag
        self.error = AttitudeError()
        self.strain = 0.0
        """Time for which the lane has been inconsistent, as a share of the time that makes it fail."""

    @property
    def has_failed(self) -> bool:
        """Whether the autopilot leaves the lane."""
        return self.strain >= 1.0

    def step(self, dt_s: float, q_nb: Quat) -> None:
        """Take the errors of the sensor's latest sample."""
        reference = NOWHERE
        if self.imu.accel.error != NOWHERE or self.mag.error != NOWHERE:
            force = rotate(q_nb, self.imu.accel.error)
            reference = (
                -TILT_SHARE * force[1] / G_MPS2,
                TILT_SHARE * force[0] / G_MPS2,
                -HEADING_SHARE * apparent_turn(self.mag.field_ned, rotate(q_nb, self.mag.error)),
            )
        self.error.step(dt_s, q_nb, self.imu.gyro.error, reference)
        stopped = self.imu.gyro.stopped or self.imu.accel.stopped
        if stopped or norm(self.imu.accel.error) > FAILED_ACCEL:
            self.strain += dt_s / FAILED_SENSOR_S
        elif hypot(*self.error.angle[:2]) > FAILED_TILT or abs(self.error.angle[2]) > FAILED_HEADING:
            self.strain += dt_s / FAILED_ANGLE_S
        else:
            self.strain = 0.0


class Lanes:
    """Both lanes, and what the receiver does to both alike."""

    def __init__(self, sensors: SensorSuite, seed: int) -> None:
        self.sensors = sensors
        self.gps = sensors.gps
        direction = generator(str(seed), "lost").uniform(0.0, 2.0 * pi)
        self.lost: Vec3 = (LOST_TILT * cos(direction), LOST_TILT * sin(direction), LOST_HEADING)
        self.restart()

    def restart(self) -> None:
        """Begin again, without errors and with the first lane."""
        self.lanes = [Lane(self.sensors.imus[sensor], self.sensors.mags[sensor]) for sensor in SENSORS]
        self.common = AttitudeError()
        self.velocity_error: Vec3 = NOWHERE
        """The receiver's velocity error that has been taken for true, m/s."""
        self.selected = 0
        """Index of the lane whose attitude is reported."""

    def step(self, dt_s: float, t_ns: int, motion: Motion) -> bool:
        """Take the sensors' latest samples; True when another lane was selected."""
        for lane in self.lanes:
            lane.step(dt_s, motion.q_nb)
        self.common.step(dt_s, motion.q_nb, NOWHERE, self._receiver_reference(dt_s, t_ns))
        other = 1 - self.selected
        if self.lanes[self.selected].has_failed and self.lanes[other].strain == 0.0:
            self.selected = other
            return True
        return False

    @property
    def angle(self) -> Vec3:
        """Error of the reported attitude, rotation vector in NED, rad."""
        return add(self.lanes[self.selected].error.angle, self.common.angle)

    @property
    def rate(self) -> Vec3:
        """Error of the reported body rates, rad/s."""
        lane = self.lanes[self.selected]
        return sub(sub(lane.imu.gyro.error, lane.error.learned), self.common.learned)

    def _receiver_reference(self, dt_s: float, t_ns: int) -> Vec3:
        """The tilt that the receiver's velocity error looks like, or where an attitude without fixes drifts."""
        if is_lost(self.gps, t_ns):
            return self.lost
        if self.gps.error == self.velocity_error == NOWHERE:
            return NOWHERE
        acceleration = scale(sub(self.gps.error, self.velocity_error), 1.0 / VELOCITY_S)
        self.velocity_error = add(self.velocity_error, scale(acceleration, dt_s))
        north, east = (clamp(a, -ACCELERATION_GATE, ACCELERATION_GATE) for a in acceleration[:2])
        return (east / G_MPS2, -north / G_MPS2, 0.0)


def is_lost(gps: Gps, t_ns: int) -> bool:
    """Whether there were fixes, and the latest is too long ago to be bridged."""
    return gps.fix_ns > 0 and t_ns - gps.fix_ns > DEAD_RECKONING_S * 1e9


def apparent_turn(field: Vec3, error: Vec3) -> float:
    """How far the horizontal field seems turned, rad toward east; 0 beyond the gate."""
    north, east = field[0] + error[0], field[1] + error[1]
    turn = atan2(field[0] * east - field[1] * north, field[0] * north + field[1] * east)
    return turn if abs(turn) < HEADING_GATE else 0.0

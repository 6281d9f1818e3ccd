"""Two filters, sample by sample, over readings in numpy arrays: a wing that flies straight, then circles.

    .venv/bin/python examples/filters_on_arrays.py

The arrays are simulated here, without sensor errors, so that the true attitude is known; arrays of one's own take
their place. The gradient-descent filter takes the specific force for gravity and leans with the turn. The
velocity-aided filter compares the specific force with the change of the receiver's velocity, and does not.
"""

from dataclasses import dataclass
from math import degrees, radians
from typing import Final

import numpy as np
import numpy.typing as npt

from attest_mav.algebra import heading_between, q_from_euler, tilt_between
from attest_mav.estimation.alignment import ecompass
from attest_mav.filters.base import AttitudeFilter, FilterInputs, Start
from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.samples import ImuSample, VelocitySample
from attest_mav.types import G_MPS2, Quat, Vec3, VelocityOrigin

Array = npt.NDArray[np.float64]

RATE_HZ: Final = 50
FIX_EVERY: Final = 10
"""Inertial samples from one velocity fix to the next: the receiver gives 5 Hz."""
SPEED: Final = 20.0
"""m/s."""
FIELD_NED: Final = np.array([0.2, 0.0, 0.44])
"""gauss; the declination is zero."""


@dataclass(frozen=True, eq=False)
class Flight:
    """One row a sample. Body axes are forward, right, down; the world is north, east, down."""

    roll: Array
    """True roll, rad; the true pitch is zero."""
    yaw: Array
    """True yaw, rad."""
    gyro: Array
    """rad/s, body."""
    accel: Array
    """Specific force, m/s^2, body: (0, 0, -g) level and at rest."""
    mag: Array
    """gauss, body."""
    velocity: Array
    """m/s, NED."""

    def true_attitude(self, k: int) -> Quat:
        """The attitude at sample k, body to NED."""
        return q_from_euler(float(self.roll[k]), 0.0, float(self.yaw[k]))


def circling_flight(bank_deg: float, straight_s: float, turn_s: float) -> Flight:
    """Level and straight, then a coordinated turn whose bank is reached within two seconds."""
    t = np.arange(round((straight_s + turn_s) * RATE_HZ)) / RATE_HZ
    share = np.clip((t - straight_s) / 2.0, 0.0, 1.0)
    roll = radians(bank_deg) * share * share * (3.0 - 2.0 * share)
    yaw_rate = G_MPS2 * np.tan(roll) / SPEED
    yaw = np.cumsum(yaw_rate) / RATE_HZ
    level = np.zeros(len(t))
    gyro = np.column_stack((np.gradient(roll, t), yaw_rate * np.sin(roll), yaw_rate * np.cos(roll)))
    accel = np.column_stack((level, level, -G_MPS2 / np.cos(roll)))
    north, east, down = FIELD_NED
    across = east * np.cos(yaw) - north * np.sin(yaw)
    mag = np.column_stack(
        (
            north * np.cos(yaw) + east * np.sin(yaw),
            across * np.cos(roll) + down * np.sin(roll),
            down * np.cos(roll) - across * np.sin(roll),
        )
    )
    velocity = SPEED * np.column_stack((np.cos(yaw), np.sin(yaw), level))
    return Flight(roll, yaw, gyro, accel, mag, velocity)


def vector(row: Array) -> Vec3:
    """A row of an array as the filters take it."""
    x, y, z = row.tolist()
    return (x, y, z)


def inertial_sample(flight: Flight, k: int) -> ImuSample:
    """The readings of row k. Names and ids tell streams apart; here is only one."""
    t_ns = round(k * 1e9 / RATE_HZ)
    return ImuSample("arrays", 1, 1, t_ns, t_ns, vector(flight.gyro[k]), vector(flight.accel[k]), vector(flight.mag[k]))


def velocity_fix(flight: Flight, k: int) -> VelocitySample:
    """The newest fix at row k."""
    at = k - k % FIX_EVERY
    t_ns = round(at * 1e9 / RATE_HZ)
    return VelocitySample("receiver", 1, 1, t_ns, t_ns, vector(flight.velocity[at]), True, VelocityOrigin.RECEIVER)


def errors(attitude_filter: AttitudeFilter, flight: Flight) -> Array:
    """Tilt and heading error at each sample, degrees; NaN while the filter has no attitude yet."""
    first = inertial_sample(flight, 0)
    q_nb, north = ecompass(first.accel, first.mag)
    state = attitude_filter.initial(Start(q_nb, (0.0, 0.0, 0.0), north, first.accel, first.mag))
    found = np.full((len(flight.roll), 2), np.nan)
    for k in range(1, len(flight.roll)):
        inputs = FilterInputs(velocity=velocity_fix(flight, k), declination=0.0, zero_mean_velocity=False)
        state = attitude_filter.step(state, 1.0 / RATE_HZ, inertial_sample(flight, k), inputs)
        if state.aligned:
            truth = flight.true_attitude(k)
            found[k] = degrees(tilt_between(state.q_nb, truth)), degrees(heading_between(state.q_nb, truth))
    return found


def main() -> None:
    """Print the errors of both filters, every ten seconds."""
    flight = circling_flight(bank_deg=40.0, straight_s=20.0, turn_s=60.0)
    # These readings are neither late nor low-passed, as an autopilot's messages are.
    undelayed = FlightParameters(low_pass_hz=0.0, fix_delay_s=0.0, mag_delay_s=0.0)
    filters = (GradientDescent(), VelocityAided(undelayed))
    columns = [errors(one, flight) for one in filters]
    print("degrees  " + "".join(f"{one.name:>24}" for one in filters))
    print("time s   " + f"{'tilt   heading':>24}" * len(filters))
    for k in range(10 * RATE_HZ - 1, len(flight.roll), 10 * RATE_HZ):
        cells = "".join(f"{column[k, 0]:14.2f}{column[k, 1]:10.2f}" for column in columns)
        print(f"{(k + 1) / RATE_HZ:6.0f}   {cells}")


if __name__ == "__main__":
    main()

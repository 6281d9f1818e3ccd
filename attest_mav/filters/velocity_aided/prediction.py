"""Prediction: dead reckoning of attitude and velocity from the gyro and the accelerometer, and its process noise.

Motion between two samples is unobserved. Its size is estimated from the second difference of the readings; the largest
one of the last seconds sets the process noise, which so scales with rate and motion and keeps sigma honest at 4 Hz.
Integration: Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., chapter 5,
over a flat Earth that does not turn; noise as in section 14.2.
"""

from math import exp, pi, sqrt
from typing import Final

from attest_mav.algebra import add, largest, mat_vec, norm, q_exp, q_mul, q_to_matrix, q_unit, scale, square, sub
from attest_mav.filters.velocity_aided.covariance import ProcessNoise, drifted, propagated
from attest_mav.filters.velocity_aided.history import DeltaVelocityHistory, appended
from attest_mav.filters.velocity_aided.imu_memory import ImuMemory, ThreePoint, three_point_of
from attest_mav.filters.velocity_aided.nav_state import (
    DEADBAND_ACCEL,
    DEADBAND_RATE,
    NavigationState,
    body_rate,
    deadband,
)
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.reading import Reading
from attest_mav.filters.velocity_aided.white_noise import observed
from attest_mav.low_pass import aliased_share
from attest_mav.matrices import add_diagonal, mat_add, mat_scale, rotated_diagonal
from attest_mav.types import Mat3, Vec3

OTHER_AXES: Final = 0.6
"""Share of the accelerometer's whole second difference that each of its axes may have missed at least."""
SATURATED_RATE: Final = 1.0
"""rad/s: the second difference that a saturated sensor may hide."""
FAST_TURN: Final = 8.0
"""rad/s: a saturated gyro that reads more may hide as much as it reads."""
SATURATED_ACCEL: Final = 20.0
"""m/s^2: the same for the accelerometer, and for one that cannot be read."""
LOST_HEADING: Final = 0.4
"""rad: a heading sigma above this is a lost heading, whose effect is not linear any more."""
HEADING_NOISE_INTERVAL_S: Final = 0.2
"""The second-order effect of an unknown heading is treated as noise that is independent every 0.2 s."""
HELD_SAMPLES: Final = 8.0
"""The largest second difference decays over at least so many steps: a slow stream shows a manoeuvre in few of them."""


def predict(
    nav: NavigationState,
    memory: ImuMemory,
    reading: Reading,
    dt_s: float,
    t_ns: int,
    has_north: bool,
    parameters: FlightParameters,
) -> tuple[NavigationState, ImuMemory]:
    """State and memory ``dt_s`` later, at the reading taken then. has_north: velocity fixes arrive, which have one."""
    three_point = three_point_of(memory, reading, dt_s)
    rate = body_rate(nav, sub(scale(add(memory.gyro, reading.gyro), 0.5), three_point.trapezoid_excess))
    before = q_to_matrix(nav.q_nb)
    q_nb = q_unit(q_mul(nav.q_nb, q_exp(scale(rate, 0.5 * dt_s))))
    after = q_to_matrix(q_nb)
    specific_force = mat_vec(after, sub(reading.accel, nav.accel_bias))
    delta_velocity = scale(add(memory.specific_force, specific_force), 0.5 * dt_s)
    gravity_dt = parameters.gravity * dt_s
    velocity = add(nav.velocity, (delta_velocity[0], delta_velocity[1], delta_velocity[2] + gravity_dt))
    rotation_dt: Mat3 = mat_scale(mat_add(before, after), 0.5 * dt_s)
    memory_after = _remember(memory, reading, three_point, dt_s, parameters, specific_force,
                             appended(memory.history, t_ns, delta_velocity))  # fmt: skip
    heading_noise = _nonlinear_heading_noise(delta_velocity, nav.heading_sigma, dt_s) if has_north else 0.0
    noise = _process_noise(norm(rate), memory_after, heading_noise, rotation_dt, dt_s, parameters)
    velocity_change = deadband(sub(velocity, nav.velocity), DEADBAND_ACCEL * dt_s)
    lever = (velocity_change[0], velocity_change[1], velocity_change[2] - gravity_dt)
    drift_kept = max(0.0, 1.0 - dt_s / parameters.gyro_drift_s)
    covariance = propagated(nav.covariance, rotation_dt, lever, deadband(rate, DEADBAND_RATE), noise)
    covariance = drifted(covariance, dt_s, drift_kept)
    return nav.propagated(q_nb, velocity, dt_s, drift_kept, covariance), memory_after


def _remember(
    before: ImuMemory,
    reading: Reading,
    three_point: ThreePoint,
    dt_s: float,
    parameters: FlightParameters,
    specific_force: Vec3,
    history: DeltaVelocityHistory,
) -> ImuMemory:
    """The memory after a step."""
    fade = exp(-dt_s / max(parameters.aliasing_hold_s, HELD_SAMPLES * dt_s))
    share = aliased_share(parameters.low_pass_hz, dt_s)
    gyro_now = share * norm(three_point.gyro_second_difference)
    if reading.saturated:
        rate = norm(reading.gyro)
        gyro_now = rate if rate > FAST_TURN else SATURATED_RATE
    unseen = SATURATED_ACCEL if reading.saturated else 0.0
    x, y, z = three_point.accel_second_difference
    held_x, held_y, held_z = before.accel_aliasing
    return ImuMemory(
        reading.gyro,
        reading.accel,
        three_point.gyro_change,
        three_point.accel_change,
        dt_s,
        specific_force,
        max(gyro_now, fade * before.gyro_aliasing),
        (
            largest(abs(x), unseen, fade * held_x),
            largest(abs(y), unseen, fade * held_y),
            largest(abs(z), unseen, fade * held_z),
        ),
        observed(before.gyro_white, three_point.gyro_second_difference, dt_s),
        observed(before.accel_white, three_point.accel_second_difference, dt_s),
        history,
    )


def _nonlinear_heading_noise(delta_velocity: Vec3, heading_sigma: float, dt_s: float) -> float:
    """Variance of the second-order effect of a lost heading on the velocity, (m/s)^2.

    A heading error h turns a velocity gain p by p h (first order, in the Jacobian) and shortens it by p h^2 / 2 (second
    order, added here as noise). Without a magnetometer this is most of it until a manoeuvre has shown the heading.
    """
    if heading_sigma < LOST_HEADING:
        return 0.0
    across = 0.5 * square(min(heading_sigma, pi))
    x, y, _ = delta_velocity
    return (x * x + y * y) * across * across * HEADING_NOISE_INTERVAL_S / dt_s


def _process_noise(
    rate: float,
    memory: ImuMemory,
    heading_noise: float,
    rotation_dt: Mat3,
    dt_s: float,
    parameters: FlightParameters,
) -> ProcessNoise:
    """The noise of a step at this rate, rad/s. rotation_dt: body to NED times the step."""
    x, y, z = memory.accel_aliasing
    share = square(parameters.accel_aliasing)
    seen_s = parameters.accel_noise_seen_s
    unseen_share = seen_s / (seen_s + memory.accel_white.changing_s)
    least = max(square(parameters.accel_noise), square(parameters.accel_noise_unseen) * unseen_share)
    white = max(least / dt_s, memory.accel_white.variance)
    every_axis = max(white, share * OTHER_AXES**2 * (x * x + y * y + z * z))
    hidden = (max(share * x * x, every_axis), max(share * y * y, every_axis), max(share * z * z, every_axis))
    gyro_noise = max(parameters.gyro_noise, sqrt(memory.gyro_white.variance * dt_s))
    return ProcessNoise(
        square(gyro_noise + parameters.gyro_rate_noise * rate) * dt_s
        + square(parameters.gyro_aliasing * memory.gyro_aliasing * dt_s),
        add_diagonal(rotated_diagonal(rotation_dt, hidden), heading_noise),
        square(parameters.gyro_bias_walk) * dt_s,
        square(parameters.accel_bias_walk) * dt_s if parameters.accel_bias_sigma > 0.0 else 0.0,
        square(parameters.hard_iron_walk) * dt_s if parameters.hard_iron > 0.0 else 0.0,
        2.0 * square(parameters.gyro_drift_sigma) * dt_s / parameters.gyro_drift_s,
    )

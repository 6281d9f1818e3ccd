"""Prediction: dead reckoning of attitude and velocity from the gyro and the accelerometer, and its process noise.

Motion between two samples is unobserved. Its size is estimated from the second difference of the readings; the largest
one of the last seconds sets the process noise, which so scales with rate and motion and keeps sigma honest at 4 Hz.
Integration: Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., chapter 5,
over a flat Earth that does not turn; noise as in section 14.2.
"""

from math import exp, pi, sqrt
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, largest, mat_vec, norm, q_exp, q_mul, q_to_matrix, q_unit, scale, square, sub
from attest_mav.filters.velocity_aided.covariance import ProcessNoise, propagated
from attest_mav.filters.velocity_aided.history import DeltaVelocityHistory, appended, empty_history
from attest_mav.filters.velocity_aided.nav_state import (
    DEADBAND_ACCEL,
    DEADBAND_RATE,
    NavigationState,
    body_rate,
    deadband,
)
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.reading import Reading
from attest_mav.filters.velocity_aided.white_noise import WhiteNoise, no_white_noise, observed
from attest_mav.low_pass import aliased_share
from attest_mav.matrices import add_diagonal, mat_add, mat_scale, rotated_diagonal
from attest_mav.record import Record
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
MAX_STEP_RATIO: Final = 1.5
"""Two steps whose lengths differ by no more than this factor count as even."""
HELD_SAMPLES: Final = 8.0
"""The largest second difference decays over at least so many steps: a slow stream shows a manoeuvre in few of them."""


@mypyc_attr(acyclic=True, free_list_len=1)
class ImuMemory(Record):
    """The memory of dead reckoning between two samples."""

    def __init__(
        self,
        gyro: Vec3,
        accel: Vec3,
        gyro_change: Vec3,
        accel_change: Vec3,
        dt_s: float,
        specific_force: Vec3,
        gyro_aliasing: float,
        accel_aliasing: Vec3,
        gyro_white: WhiteNoise,
        accel_white: WhiteNoise,
        history: DeltaVelocityHistory,
    ) -> None:
        self.gyro: Final = gyro
        """The last gyro reading, rad/s."""
        self.accel: Final = accel
        """The last accelerometer reading, m/s^2."""
        self.gyro_change: Final = gyro_change
        """The last gyro reading minus the one before, rad/s."""
        self.accel_change: Final = accel_change
        """The last accelerometer reading minus the one before, m/s^2."""
        self.dt_s: Final = dt_s
        """Time between these two, s."""
        self.specific_force: Final = specific_force
        """The last specific force without bias, NED, m/s^2."""
        self.gyro_aliasing: Final = gyro_aliasing
        """Largest second difference of the gyro of late that its low-pass lets hide, rad/s, decaying."""
        self.accel_aliasing: Final = accel_aliasing
        """Largest second difference of the accelerometer of late in each axis of the body, m/s^2, decaying."""
        self.gyro_white: Final = gyro_white
        """White noise of the gyro, rad/s."""
        self.accel_white: Final = accel_white
        """White noise of the accelerometer, m/s^2."""
        self.history: Final = history
        """Recent gains of velocity."""

    @property
    def hidden_acceleration(self) -> float:
        """Size of the acceleration that the samples of late may not have shown, m/s^2."""
        return norm(self.accel_aliasing)

    @property
    def angular_acceleration(self) -> Vec3:
        """By the last two gyro readings, rad/s^2; zero before the second."""
        return scale(self.gyro_change, 1.0 / self.dt_s) if self.dt_s > 0.0 else (0.0, 0.0, 0.0)

    def with_attitude(self, nav: NavigationState) -> "ImuMemory":
        """The memory after a correction: the last specific force as the corrected state sees it."""
        return ImuMemory(
            self.gyro,
            self.accel,
            self.gyro_change,
            self.accel_change,
            self.dt_s,
            specific_force_ned(nav, self.accel),
            self.gyro_aliasing,
            self.accel_aliasing,
            self.gyro_white,
            self.accel_white,
            self.history,
        )


def initial_memory(nav: NavigationState, reading: Reading, t_ns: int) -> ImuMemory:
    """The memory at the first sample of a navigation."""
    zero: Vec3 = (0.0, 0.0, 0.0)
    force = specific_force_ned(nav, reading.accel)
    quiet = no_white_noise()
    return ImuMemory(reading.gyro, reading.accel, zero, zero, 0.0, force, 0.0, zero, quiet, quiet, empty_history(t_ns))


def specific_force_ned(nav: NavigationState, accel: Vec3) -> Vec3:
    """C (f - a), NED, m/s^2."""
    return mat_vec(q_to_matrix(nav.q_nb), sub(accel, nav.accel_bias))


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
    three_point = _three_point(memory, reading, dt_s)
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
    covariance = propagated(nav.covariance, rotation_dt, lever, deadband(rate, DEADBAND_RATE), noise)
    return nav.propagated(q_nb, velocity, covariance), memory_after


def _remember(
    before: ImuMemory,
    reading: Reading,
    three_point: "ThreePoint",
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


@mypyc_attr(acyclic=True, free_list_len=1)
class ThreePoint(Record):
    """Differences of the last three readings."""

    def __init__(
        self,
        gyro_change: Vec3,
        accel_change: Vec3,
        gyro_second_difference: Vec3,
        accel_second_difference: Vec3,
        trapezoid_excess: Vec3,
    ) -> None:
        self.gyro_change: Final = gyro_change
        """First difference of the gyro, rad/s."""
        self.accel_change: Final = accel_change
        """First difference of the accelerometer, m/s^2."""
        self.gyro_second_difference: Final = gyro_second_difference
        """Second difference of the gyro, rad/s."""
        self.accel_second_difference: Final = accel_second_difference
        """Second difference of the accelerometer, m/s^2."""
        self.trapezoid_excess: Final = trapezoid_excess
        """Mean rate by the trapezoid minus that by the three-point rule of Adams and Moulton, rad/s: the latter is
        (5 w2 + 8 w1 - w0) / 12, exact for a rate with a constant second derivative."""


def _three_point(memory: ImuMemory, reading: Reading, dt_s: float) -> ThreePoint:
    """The differences at this reading. Uneven steps have no three-point rule."""
    gyro_change, accel_change = sub(reading.gyro, memory.gyro), sub(reading.accel, memory.accel)
    second_difference = sub(gyro_change, memory.gyro_change)
    even = MAX_STEP_RATIO * dt_s > memory.dt_s > dt_s / MAX_STEP_RATIO
    excess: Vec3 = scale(second_difference, 1.0 / 12.0) if even else (0.0, 0.0, 0.0)
    accel_second_difference = sub(accel_change, memory.accel_change)
    return ThreePoint(gyro_change, accel_change, second_difference, accel_second_difference, excess)


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
    white = max(square(parameters.accel_noise) / dt_s, memory.accel_white.variance)
    least = max(white, share * OTHER_AXES**2 * (x * x + y * y + z * z))
    unseen = (max(share * x * x, least), max(share * y * y, least), max(share * z * z, least))
    gyro_noise = max(parameters.gyro_noise, sqrt(memory.gyro_white.variance * dt_s))
    return ProcessNoise(
        square(gyro_noise + parameters.gyro_rate_noise * rate) * dt_s
        + square(parameters.gyro_aliasing * memory.gyro_aliasing * dt_s),
        add_diagonal(rotated_diagonal(rotation_dt, unseen), heading_noise),
        square(parameters.gyro_bias_walk) * dt_s,
        square(parameters.accel_bias_walk) * dt_s if parameters.accel_bias_sigma > 0.0 else 0.0,
        square(parameters.hard_iron_walk) * dt_s if parameters.hard_iron > 0.0 else 0.0,
    )

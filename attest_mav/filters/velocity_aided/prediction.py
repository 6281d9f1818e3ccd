"""Dead reckoning between measurements: attitude and velocity from the gyro and the accelerometer.

Telemetry samples a filtered sensor now and then, so what happened between two samples is unknown in proportion to how
sharply the readings bend. That bend, remembered for a while, is the noise of the step: it scales itself with rate and
motion, and at 4 Hz it is what keeps sigma honest.
"""

from math import exp, pi
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, is_finite, mat_vec, norm, q_exp, q_mul, q_to_matrix, q_unit, scale, sub
from attest_mav.filters.velocity_aided.covariance import ProcessNoise
from attest_mav.filters.velocity_aided.history import DeltaVelocityHistory, appended
from attest_mav.filters.velocity_aided.nav_state import (
    DEADBAND_ACCEL,
    DEADBAND_RATE,
    NavigationState,
    body_rate,
    deadband,
    predicted,
)
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.matrices import mat_add, mat_scale
from attest_mav.types import ImuSample, Mat3, Vec3

MAX_RATE: Final = 1e3
"""rad/s: a gyro that reports this much is not read."""
MAX_ACCEL: Final = 1e4
"""m/s^2: the same for the accelerometer."""
SATURATED_RATE: Final = 1.0
"""rad/s: what a saturated sensor may hide."""
SATURATED_ACCEL: Final = 20.0
"""m/s^2: the same for the accelerometer, and for one that cannot be read."""


LOST_HEADING: Final = 0.4
"""rad: a heading less certain than this is lost."""
HEADING_NOISE_INTERVAL_S: Final = 0.2
"""What a lost heading bends is counted once in this time, as if it were new each time."""
MAX_STEP_RATIO: Final = 1.5
"""Steps are even while neither is longer than the other by this factor."""


@mypyc_attr(acyclic=True)
class ImuMemory:
    """What dead reckoning remembers from one sample to the next.

    gyro, accel: the last readings, rad/s and m/s^2. change_w, change_f: their differences from those before. dt_s: the
    step between. force: the last specific force in NED, m/s^2. unrest_w, unrest_f: the remembered largest bends. track:
    the recent velocity gains.
    """

    def __init__(
        self,
        gyro: Vec3,
        accel: Vec3,
        gyro_change: Vec3,
        accel_change: Vec3,
        dt_s: float,
        specific_force: Vec3,
        gyro_aliasing: float,
        accel_aliasing: float,
        history: DeltaVelocityHistory,
    ) -> None:
        self.gyro: Final = gyro
        self.accel: Final = accel
        self.gyro_change: Final = gyro_change
        self.accel_change: Final = accel_change
        self.dt_s: Final = dt_s
        self.specific_force: Final = specific_force
        self.gyro_aliasing: Final = gyro_aliasing
        self.accel_aliasing: Final = accel_aliasing
        self.history: Final = history


@mypyc_attr(acyclic=True)
class Reading:
    """Gyro (rad/s) and accelerometer (m/s^2) of one sample as they are used."""

    def __init__(self, gyro: Vec3, accel: Vec3, saturated: bool) -> None:
        self.gyro: Final = gyro
        self.accel: Final = accel
        self.saturated: Final = saturated


def read(sample: ImuSample, before: Vec3) -> Reading:
    """The sample's readings with half a unit given back; ``before`` stands in for an accelerometer without a value."""
    usable = is_finite(sample.accel) and norm(sample.accel) < MAX_ACCEL
    accel = sample.accel if usable else before
    saturated = sample.saturated or not usable
    quantum = sample.quantum
    return Reading(
        dequantised(sample.gyro, quantum.gyro), dequantised(accel, quantum.accel) if usable else accel, saturated
    )


def dequantised(v: Vec3, unit: float) -> Vec3:
    """The middle of the interval that truncation toward zero has mapped to v; zero, and exact readings, stay."""
    if unit <= 0.0:
        return v
    return (_middle(v[0], unit), _middle(v[1], unit), _middle(v[2], unit))


def _middle(x: float, unit: float) -> float:
    return x + 0.5 * unit if x > 0.0 else x - 0.5 * unit if x < 0.0 else 0.0


def specific_force_ned(nav: NavigationState, accel: Vec3) -> Vec3:
    """C (f - a), NED, m/s^2."""
    return mat_vec(q_to_matrix(nav.q_nb), sub(accel, nav.accel_bias))


def predict(
    nav: NavigationState,
    memory: ImuMemory,
    reading: Reading,
    dt_s: float,
    t_ns: int,
    aided: bool,
    parameters: FlightParameters,
) -> tuple[NavigationState, ImuMemory]:
    """Motion and memory ``dt_s`` later, at the reading taken then. aided: velocity fixes arrive, which have a north."""
    three_point = _three_point(memory, reading, dt_s)
    rate = body_rate(nav, sub(scale(add(memory.gyro, reading.gyro), 0.5), three_point.trapezoid_excess))
    before = q_to_matrix(nav.q_nb)
    q_nb = q_unit(q_mul(nav.q_nb, q_exp(scale(rate, 0.5 * dt_s))))
    after = q_to_matrix(q_nb)
    specific_force = mat_vec(after, sub(reading.accel, nav.accel_bias))
    delta_velocity = scale(add(memory.specific_force, specific_force), 0.5 * dt_s)
    velocity = add(nav.velocity, (delta_velocity[0], delta_velocity[1], delta_velocity[2] + parameters.gravity * dt_s))
    rotation_dt: Mat3 = mat_scale(mat_add(before, after), 0.5 * dt_s)
    fade = exp(-dt_s / parameters.aliasing_hold_s)
    gyro_aliasing = max(
        SATURATED_RATE if reading.saturated else three_point.gyro_second_difference, fade * memory.gyro_aliasing
    )
    accel_aliasing = max(
        SATURATED_ACCEL if reading.saturated else three_point.accel_second_difference, fade * memory.accel_aliasing
    )
    heading_noise = _nonlinear_heading_noise(delta_velocity, nav.heading_sigma, dt_s) if aided else 0.0
    noise = _process_noise(norm(rate), gyro_aliasing, accel_aliasing, heading_noise, dt_s, parameters)
    history = appended(memory.history, t_ns, delta_velocity)
    after_step = ImuMemory(
        reading.gyro,
        reading.accel,
        three_point.gyro_change,
        three_point.accel_change,
        dt_s,
        specific_force,
        gyro_aliasing,
        accel_aliasing,
        history,
    )
    velocity_change = deadband(sub(velocity, nav.velocity), DEADBAND_ACCEL * dt_s)
    moving_delta_velocity = (velocity_change[0], velocity_change[1], velocity_change[2] - parameters.gravity * dt_s)
    return predicted(
        nav, q_nb, velocity, rotation_dt, moving_delta_velocity, deadband(rate, DEADBAND_RATE), noise
    ), after_step


@mypyc_attr(acyclic=True)
class ThreePoint:
    """How the readings go on: their changes, how sharply they bend (second differences), and ``arch``.

    arch: what the trapezoid has too much of a rate that bends evenly, rad/s: the three-point rule of Adams and Moulton
    is (5 w2 + 8 w1 - w0) / 12.
    """

    def __init__(
        self,
        gyro_change: Vec3,
        accel_change: Vec3,
        gyro_second_difference: float,
        accel_second_difference: float,
        trapezoid_excess: Vec3,
    ) -> None:
        self.gyro_change: Final = gyro_change
        self.accel_change: Final = accel_change
        self.gyro_second_difference: Final = gyro_second_difference
        self.accel_second_difference: Final = accel_second_difference
        self.trapezoid_excess: Final = trapezoid_excess


def _three_point(memory: ImuMemory, reading: Reading, dt_s: float) -> ThreePoint:
    """The shape at this reading. Uneven steps have no rule of three points."""
    gyro_change, accel_change = sub(reading.gyro, memory.gyro), sub(reading.accel, memory.accel)
    second_difference = sub(gyro_change, memory.gyro_change)
    even = MAX_STEP_RATIO * dt_s > memory.dt_s > dt_s / MAX_STEP_RATIO
    trapezoid_excess: Vec3 = scale(second_difference, 1.0 / 12.0) if even else (0.0, 0.0, 0.0)
    return ThreePoint(
        gyro_change,
        accel_change,
        norm(second_difference),
        norm(sub(accel_change, memory.accel_change)),
        trapezoid_excess,
    )


def _nonlinear_heading_noise(delta_velocity: Vec3, heading_sigma: float, dt_s: float) -> float:
    """Variance of what a lost heading does to the velocity beyond what is linear in its error, (m/s)^2.

    A push p turned by an angle h is off by p h, and p h^2 / 2 across that: without a magnetometer this is most of it
    until a manoeuvre has shown the heading.
    """
    if heading_sigma < LOST_HEADING:
        return 0.0
    across = 0.5 * min(heading_sigma, pi) ** 2
    return (
        (delta_velocity[0] * delta_velocity[0] + delta_velocity[1] * delta_velocity[1])
        * across
        * across
        * HEADING_NOISE_INTERVAL_S
        / dt_s
    )


def _process_noise(
    rate: float,
    gyro_aliasing: float,
    accel_aliasing: float,
    heading_noise: float,
    dt_s: float,
    parameters: FlightParameters,
) -> ProcessNoise:
    """The noise of a step at this rate, rad/s."""
    return ProcessNoise(
        (parameters.gyro_noise + parameters.gyro_rate_noise * rate) ** 2 * dt_s
        + (parameters.gyro_aliasing * gyro_aliasing * dt_s) ** 2,
        parameters.accel_noise**2 * dt_s + (parameters.accel_aliasing * accel_aliasing * dt_s) ** 2 + heading_noise,
        parameters.gyro_bias_walk**2 * dt_s,
        parameters.accel_bias_walk**2 * dt_s if parameters.accel_bias_sigma > 0.0 else 0.0,
        parameters.hard_iron_walk**2 * dt_s if parameters.hard_iron > 0.0 else 0.0,
    )


def with_attitude(memory: ImuMemory, nav: NavigationState) -> ImuMemory:
    """The memory after the attitude was corrected: the last specific force as the corrected attitude sees it."""
    return ImuMemory(
        memory.gyro,
        memory.accel,
        memory.gyro_change,
        memory.accel_change,
        memory.dt_s,
        specific_force_ned(nav, memory.accel),
        memory.gyro_aliasing,
        memory.accel_aliasing,
        memory.history,
    )

"""Dead reckoning between measurements: attitude and velocity from the gyro and the accelerometer.

Telemetry samples a filtered sensor now and then, so what happened between two samples is unknown in proportion to how
sharply the readings bend. That bend, remembered for a while, is the noise of the step: it scales itself with rate and
motion, and at 4 Hz it is what keeps sigma honest.
"""

from math import exp, pi
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, is_finite, mat_vec, norm, q_exp, q_mul, q_to_matrix, q_unit, scale, sub
from attest_mav.filters.velocity_aided.covariance import Growth
from attest_mav.filters.velocity_aided.history import Track, longer
from attest_mav.filters.velocity_aided.nav_state import STILL_ACCEL, STILL_RATE, Motion, moved, rate_of, shown
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
BENT_S: Final = 0.2
"""What a lost heading bends is counted once in this time, as if it were new each time."""
UNEVEN: Final = 1.5
"""Steps are even while neither is longer than the other by this factor."""


@mypyc_attr(acyclic=True)
class Strapdown:
    """What dead reckoning remembers from one sample to the next.

    gyro, accel: the last readings, rad/s and m/s^2. change_w, change_f: their differences from those before. dt_s: the
    step between. force: the last specific force in NED, m/s^2. unrest_w, unrest_f: the remembered largest bends. track:
    the recent velocity gains.
    """

    def __init__(
        self,
        gyro: Vec3,
        accel: Vec3,
        change_w: Vec3,
        change_f: Vec3,
        dt_s: float,
        force: Vec3,
        unrest_w: float,
        unrest_f: float,
        track: Track,
    ) -> None:
        self.gyro: Final = gyro
        self.accel: Final = accel
        self.change_w: Final = change_w
        self.change_f: Final = change_f
        self.dt_s: Final = dt_s
        self.force: Final = force
        self.unrest_w: Final = unrest_w
        self.unrest_f: Final = unrest_f
        self.track: Final = track


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


def specific_force(motion: Motion, accel: Vec3) -> Vec3:
    """C (f - a), NED, m/s^2."""
    return mat_vec(q_to_matrix(motion.q_nb), sub(accel, motion.accel_bias))


def advanced(
    motion: Motion,
    memory: Strapdown,
    reading: Reading,
    dt_s: float,
    t_ns: int,
    aided: bool,
    settings: FlightParameters,
) -> tuple[Motion, Strapdown]:
    """Motion and memory ``dt_s`` later, at the reading taken then. aided: velocity fixes arrive, which have a north."""
    shape = _shape(memory, reading, dt_s)
    rate = rate_of(motion, sub(scale(add(memory.gyro, reading.gyro), 0.5), shape.arch))
    before = q_to_matrix(motion.q_nb)
    q_nb = q_unit(q_mul(motion.q_nb, q_exp(scale(rate, 0.5 * dt_s))))
    after = q_to_matrix(q_nb)
    force = mat_vec(after, sub(reading.accel, motion.accel_bias))
    push = scale(add(memory.force, force), 0.5 * dt_s)
    velocity = add(motion.velocity, (push[0], push[1], push[2] + settings.gravity * dt_s))
    turn: Mat3 = mat_scale(mat_add(before, after), 0.5 * dt_s)
    fade = exp(-dt_s / settings.aliasing_hold_s)
    unrest_w = max(SATURATED_RATE if reading.saturated else shape.bend_w, fade * memory.unrest_w)
    unrest_f = max(SATURATED_ACCEL if reading.saturated else shape.bend_f, fade * memory.unrest_f)
    bent = _bent(push, motion.heading_sigma, dt_s) if aided else 0.0
    growth = _growth(norm(rate), unrest_w, unrest_f, bent, dt_s, settings)
    track = longer(memory.track, t_ns, push)
    after_step = Strapdown(
        reading.gyro, reading.accel, shape.change_w, shape.change_f, dt_s, force, unrest_w, unrest_f, track
    )
    gained = shown(sub(velocity, motion.velocity), STILL_ACCEL * dt_s)
    seen_push = (gained[0], gained[1], gained[2] - settings.gravity * dt_s)
    return moved(motion, q_nb, velocity, turn, seen_push, shown(rate, STILL_RATE), growth), after_step


@mypyc_attr(acyclic=True)
class Shape:
    """How the readings go on: their changes, how sharply they bend (second differences), and ``arch``.

    arch: what the trapezoid has too much of a rate that bends evenly, rad/s: the three-point rule of Adams and Moulton
    is (5 w2 + 8 w1 - w0) / 12.
    """

    def __init__(self, change_w: Vec3, change_f: Vec3, bend_w: float, bend_f: float, arch: Vec3) -> None:
        self.change_w: Final = change_w
        self.change_f: Final = change_f
        self.bend_w: Final = bend_w
        self.bend_f: Final = bend_f
        self.arch: Final = arch


def _shape(memory: Strapdown, reading: Reading, dt_s: float) -> Shape:
    """The shape at this reading. Uneven steps have no rule of three points."""
    change_w, change_f = sub(reading.gyro, memory.gyro), sub(reading.accel, memory.accel)
    bend = sub(change_w, memory.change_w)
    even = UNEVEN * dt_s > memory.dt_s > dt_s / UNEVEN
    arch: Vec3 = scale(bend, 1.0 / 12.0) if even else (0.0, 0.0, 0.0)
    return Shape(change_w, change_f, norm(bend), norm(sub(change_f, memory.change_f)), arch)


def _bent(push: Vec3, heading_sigma: float, dt_s: float) -> float:
    """Variance of what a lost heading does to the velocity beyond what is linear in its error, (m/s)^2.

    A push p turned by an angle h is off by p h, and p h^2 / 2 across that: without a magnetometer this is most of it
    until a manoeuvre has shown the heading.
    """
    if heading_sigma < LOST_HEADING:
        return 0.0
    across = 0.5 * min(heading_sigma, pi) ** 2
    return (push[0] * push[0] + push[1] * push[1]) * across * across * BENT_S / dt_s


def _growth(
    rate: float, unrest_w: float, unrest_f: float, bent: float, dt_s: float, settings: FlightParameters
) -> Growth:
    """The noise of a step at this rate, rad/s."""
    return Growth(
        (settings.gyro_noise + settings.gyro_rate_noise * rate) ** 2 * dt_s
        + (settings.gyro_aliasing * unrest_w * dt_s) ** 2,
        settings.accel_noise**2 * dt_s + (settings.accel_aliasing * unrest_f * dt_s) ** 2 + bent,
        settings.gyro_bias_walk**2 * dt_s,
        settings.accel_bias_walk**2 * dt_s if settings.accel_bias_sigma > 0.0 else 0.0,
        settings.hard_iron_walk**2 * dt_s if settings.hard_iron > 0.0 else 0.0,
    )


def turned_memory(memory: Strapdown, motion: Motion) -> Strapdown:
    """The memory after the attitude was corrected: the last specific force as the corrected attitude sees it."""
    return Strapdown(
        memory.gyro,
        memory.accel,
        memory.change_w,
        memory.change_f,
        memory.dt_s,
        specific_force(motion, memory.accel),
        memory.unrest_w,
        memory.unrest_f,
        memory.track,
    )

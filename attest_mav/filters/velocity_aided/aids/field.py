"""The magnetic field in NED as the attitude levels it, its measurement of the heading, and its whole residual.

The heading measurement alone goes into the filter. The whole residual, three components against a reference direction,
shows errors of two of the three gyro axes at the rate of the magnetometer, and is for a monitor to judge by.
"""

from math import cos, sin
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import cross, dot, mat_vec, norm, q_exp, q_mul, q_to_matrix, scale, sub, unit_axis
from attest_mav.filters.velocity_aided.measurement import CrossCovariance, Measurement
from attest_mav.filters.velocity_aided.nav_state import (
    DEADBAND_RATE,
    NavigationState,
    body_rate,
    cross_covariance_of,
    deadband,
)
from attest_mav.filters.velocity_aided.reading import field_of
from attest_mav.matrices import mat_t_vec
from attest_mav.record import Record
from attest_mav.samples import ImuSample
from attest_mav.types import Mat3, Vec3


@mypyc_attr(acyclic=True)
class LevelledField(Record):
    """One reading, turned into NED by the attitude at its time and freed of hard iron."""

    def __init__(
        self,
        measurement: Measurement,
        direction: Vec3,
        strength: float,
        rate: float,
        reading: Vec3,
        attitude: Mat3,
        north: float,
    ) -> None:
        self.measurement: Final = measurement
        """The component along magnetic east as a share of the strength, with its sign changed; zero in truth."""
        self.direction: Final = direction
        """NED, unit length."""
        self.strength: Final = strength
        """gauss."""
        self.rate: Final = rate
        """Angular rate of the body, rad/s."""
        self.reading: Final = reading
        """The reading itself, body, gauss."""
        self.attitude: Final = attitude
        """C at its time."""
        self.north: Final = north
        """Magnetic north east of true north, rad."""


def levelled_field(nav: NavigationState, field: Vec3, rate: Vec3, declination: float) -> LevelledField:
    """The reading ``field`` (gauss, body) of a body that turns at ``rate`` (rad/s); declination: assumed, rad."""
    iron_free = sub(field, nav.hard_iron)
    strength = norm(iron_free)
    then = _attitude_then(nav, rate)
    direction = scale(mat_vec(then, iron_free), 1.0 / strength)
    north = declination + nav.declination_error
    east: Vec3 = (-sin(north), cos(north), 0.0)
    lag = mat_vec(then, scale(cross(deadband(rate, DEADBAND_RATE), iron_free), 1.0 / strength))
    measurement = Measurement(
        -dot(east, direction),
        t=cross(direction, east),
        m=scale(mat_t_vec(then, east), -1.0 / strength),
        d=(-dot(east, lag), 0.0, -(cos(north) * direction[0] + sin(north) * direction[1])),
    )
    return LevelledField(measurement, direction, strength, norm(rate), field, then, north)


def _attitude_then(nav: NavigationState, rate: Vec3) -> Mat3:
    """C at the time of the reading: the lag is short enough to turn back at the present rate."""
    return q_to_matrix(q_mul(nav.q_nb, q_exp(scale(rate, -0.5 * nav.mag_lag_s))))


@mypyc_attr(acyclic=True)
class FieldResidual(Record):
    """A reading's direction against a reference, in NED."""

    def __init__(self, direction: Vec3, residual: Vec3, covariance: Mat3) -> None:
        self.direction: Final = direction
        """The reading's direction, unit length."""
        self.residual: Final = residual
        """Direction minus reference."""
        self.covariance: Final = covariance
        """Of the residual, as far as the state's own errors make it; the reading's noise comes to it."""


def field_residual(nav: NavigationState, gyro: Vec3, sample: ImuSample, reference: Vec3) -> FieldResidual | None:
    """The whole residual of a sample's field, None where it has none. reference: unit vector in NED.

    gyro: the reading that turns the attitude back by the magnetometer's lag, rad/s.
    """
    field = field_of(sample)
    if field is None:
        return None
    rate = body_rate(nav, gyro)
    iron_free = sub(field, nav.hard_iron)
    length = norm(iron_free)
    then = _attitude_then(nav, rate)
    direction = scale(mat_vec(then, iron_free), 1.0 / length)
    lag = mat_vec(then, scale(cross(deadband(rate, DEADBAND_RATE), iron_free), 1.0 / length))
    north = _component(then, direction, lag, length, reference, 0)
    east = _component(then, direction, lag, length, reference, 1)
    down = _component(then, direction, lag, length, reference, 2)
    p_north, p_east = cross_covariance_of(nav, north), cross_covariance_of(nav, east)
    ne, nd, ed = _covariance(east, p_north), _covariance(down, p_north), _covariance(down, p_east)
    covariance = (
        (p_north.state_variance, ne, nd),
        (ne, p_east.state_variance, ed),
        (nd, ed, cross_covariance_of(nav, down).state_variance),
    )
    return FieldResidual(direction, sub(direction, reference), covariance)


def _component(then: Mat3, direction: Vec3, lag: Vec3, strength: float, reference: Vec3, axis: int) -> Measurement:
    """One component of reference minus direction, linear in the error: the truth is the reference.

    Hard iron along the field changes the strength and not the direction.
    """
    e = unit_axis(axis)
    across = sub(e, scale(direction, direction[axis]))
    return Measurement(
        reference[axis] - direction[axis],
        t=cross(direction, e),
        m=scale(mat_t_vec(then, across), -1.0 / strength),
        d=(-lag[axis], 0.0, 0.0),
    )


def _covariance(a: Measurement, p_b: CrossCovariance) -> float:
    """h_a^T P h_b."""
    return dot(a.t, p_b.t) + dot(a.v, p_b.v) + dot(a.b, p_b.b) + dot(a.m, p_b.m) + dot(a.d, p_b.d)

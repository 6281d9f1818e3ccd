"""Sensor errors of earlier flights: the start of the state from them, and their refutation.

An error wanders from flight to flight as a Gauss-Markov process between what was learned and what is known of any
sensor: with the share c of the variance that is kept, x = sqrt(c) x_l + (1 - sqrt(c)) x_0 and P = c P_l + (1 - c) P_0.
(Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., sections 3.2.2 and
4.4.1.)

A sensor that was calibrated or replaced since then has other errors. Where a Kalman filter is right, an estimate moves
from x_0 with the variance P_0 - P; one that has moved by more than four such sigmas refutes what was learned, and the
filter goes on as if nothing had been.
"""

from math import exp, sqrt
from typing import Final

from attest_mav.algebra import dot, square, sub
from attest_mav.filters.calibration import SensorCalibration, SensorChanges, SensorErrors, UncertainVector
from attest_mav.filters.velocity_aided.covariance_blocks import ErrorBlock, decoupled
from attest_mav.filters.velocity_aided.nav_state import NavigationState
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.matrices import diagonal, symmetric
from attest_mav.types import Mat3, Vec3

KEPT_AT_START: Final = 0.9
"""Share of the variance that outlasts a start: another temperature, load and place of cables. An accelerometer is then
known to 4 mg, and the iron to 3 mG."""
MEMORY_S: Final = 180 * 86400.0
"""Time constant with which that share falls, s."""
LEARNED: Final = 0.5
"""A flight has shown the errors when the variance of the accelerometer's bias has fallen to this share in each axis:
gravity shows the one along the vertical to a vehicle that stands."""
REFUTING_SIGMAS: Final = 4.0
RESTING: Final = 3.0
"""Sigma of an attitude that rests on an error, in the angles that the error makes."""
HORIZONTAL_FIELD: Final = 0.2
"""gauss: of the Earth, about; relates hard iron to heading."""


def learned(
    nav: NavigationState, begun_with: SensorErrors | None, parameters: FlightParameters
) -> SensorCalibration | None:
    """The lasting errors as this state knows them; None before its flight has shown them.

    begun_with: the errors that it began with, None for those of any sensor. A session without a manoeuvre shows none,
    and must not take the place of an earlier flight.
    """
    before = (unknown(parameters) if begun_with is None else begun_with).accel_bias.covariance
    if not all(nav.covariance.aa[axis][axis] < LEARNED * before[axis][axis] for axis in range(3)):
        return None
    errors = known_by(nav)
    return SensorCalibration(errors.accel_bias, errors.hard_iron)


def known_by(nav: NavigationState) -> SensorErrors:
    """The lasting errors as this state has them, shown or not."""
    return SensorErrors(
        UncertainVector(nav.accel_bias, symmetric(nav.covariance.aa)),
        UncertainVector(nav.hard_iron, symmetric(nav.covariance.mm)),
    )


def unknown(parameters: FlightParameters) -> SensorErrors:
    """The errors of any sensor: zero, with the sigmas that the parameters have for it."""
    return SensorErrors(_any_sensor(parameters.accel_bias_sigma), _any_sensor(parameters.hard_iron))


def at_start(known: SensorCalibration, parameters: FlightParameters) -> SensorErrors:
    """The same errors at the start of another flight, as far as the parameters let them be estimated."""
    share = KEPT_AT_START * exp(-known.age_s / MEMORY_S)
    return SensorErrors(
        _wandered(known.accel_bias, share, parameters.accel_bias_sigma),
        _wandered(known.hard_iron, share, parameters.hard_iron),
    )


def is_refuted(nav: NavigationState, begun: SensorErrors) -> bool:
    """Whether the state contradicts the errors that it began with."""
    p = nav.covariance
    return has_left(nav.accel_bias, p.aa, begun.accel_bias) or has_left(nav.hard_iron, p.mm, begun.hard_iron)


def without(nav: NavigationState, parameters: FlightParameters) -> NavigationState:
    """The state as uncertain as if no earlier flight had told of the sensor; its estimates stay where they are."""
    accel, iron = square(parameters.accel_bias_sigma), square(parameters.hard_iron)
    tilt, heading = accel / square(parameters.gravity), iron / square(HORIZONTAL_FIELD)
    return (
        nav.with_added_variance(ErrorBlock.ACCEL_BIAS, (accel, accel, accel))
        .with_added_variance(ErrorBlock.HARD_IRON, (iron, iron, iron))
        .with_added_variance(ErrorBlock.ATTITUDE, (tilt, tilt, heading))
    )


def after(nav: NavigationState, changes: SensorChanges, parameters: FlightParameters) -> NavigationState:
    """The state after changes of its sensors, whose errors are new.

    The attitude rests on the old ones. It becomes less certain than the new ones are, so that gravity and the field
    turn it, and show no error of a sensor.
    """
    before = known_by(nav)
    bias = before.accel_bias.after(changes.accelerometer) or _any_sensor(parameters.accel_bias_sigma)
    iron = before.hard_iron.after(changes.magnetometer) or _any_sensor(parameters.hard_iron)
    p, tilt, heading = nav.covariance, 0.0, 0.0
    if changes.accelerometer is not None:
        p = decoupled(p, ErrorBlock.ACCEL_BIAS, bias.covariance)
        tilt = _step_square(before.accel_bias, bias) / square(parameters.gravity)
    if changes.magnetometer is not None:
        p = decoupled(p, ErrorBlock.HARD_IRON, iron.covariance)
        heading = _step_square(before.hard_iron, iron) / square(HORIZONTAL_FIELD)
    changed = nav.with_sensor_errors(bias.mean, iron.mean, p)
    return changed.with_added_variance(ErrorBlock.ATTITUDE, (tilt, tilt, heading))


def _step_square(before: UncertainVector, now: UncertainVector) -> float:
    """Square of ``RESTING`` times the change of an error in one direction."""
    step = sub(now.mean, before.mean)
    return square(RESTING) * (dot(step, step) + max(now.covariance[axis][axis] for axis in range(3)))


def _any_sensor(sigma: float) -> UncertainVector:
    return UncertainVector((0.0, 0.0, 0.0), diagonal(square(sigma)))


def _wandered(known: UncertainVector | None, share: float, unknown_sigma: float) -> UncertainVector:
    """An error after the time between two flights; one that is not known, or not estimated (sigma 0), is zero."""
    if known is None or unknown_sigma == 0.0:
        return _any_sensor(unknown_sigma)
    factor, lost = sqrt(share), (1.0 - share) * square(unknown_sigma)
    x, y, z = known.mean
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = known.covariance
    covariance: Mat3 = (
        (share * xx + lost, share * xy, share * xz),
        (share * xy, share * yy + lost, share * yz),
        (share * xz, share * yz, share * zz + lost),
    )
    return UncertainVector((factor * x, factor * y, factor * z), covariance)


def has_left(now: Vec3, covariance: Mat3, begun: UncertainVector) -> bool:
    """Whether an estimate has moved further from its beginning than chance and its own sigma then explain."""
    return any(
        _moved_too_far(now[axis] - begun.mean[axis], begun.covariance[axis][axis], covariance[axis][axis])
        for axis in range(3)
    )


def _moved_too_far(change: float, before: float, after: float) -> bool:
    """before, after: variances."""
    return square(change) > max(before, square(REFUTING_SIGMAS) * (before - after))

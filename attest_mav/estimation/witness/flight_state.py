"""The state of a velocity-aided filter as the witness reads it, and as it goes on under another assumption.

Every function gives a new state; the equations of the filter stay as they are.
"""

from typing import Final, cast

from mypy_extensions import mypyc_attr

from attest_mav.algebra import add, norm, q_exp, q_mul, scale, sub
from attest_mav.estimation.field_evidence import FieldReading
from attest_mav.filters.base import FilterState
from attest_mav.filters.velocity_aided.aids.field import levelled_field
from attest_mav.filters.velocity_aided.aids.gnss_velocity import fuse_velocity
from attest_mav.filters.velocity_aided.covariance_blocks import ErrorBlock, decoupled
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.filters.velocity_aided.nav_state import NavigationState, body_rate
from attest_mav.filters.velocity_aided.navigation import Navigation
from attest_mav.filters.velocity_aided.reading import field_of
from attest_mav.filters.velocity_aided.state import VelocityAidedState
from attest_mav.innovation import Innovation
from attest_mav.samples import ImuSample, VelocitySample
from attest_mav.types import Vec3

UNKNOWN_VELOCITY: Final = 100.0
"""(m/s)^2: variance of a velocity of which nothing is known any more."""


@mypyc_attr(acyclic=True)  # as Sample
class FixRecord:
    """A velocity fix beside the estimate, whether it was used or not."""

    def __init__(self, t_ns: int, innovation: Vec3, nis: float) -> None:
        self.t_ns: Final = t_ns
        """The fix's own time stamp, ns."""
        self.innovation: Final = innovation
        """NED, m/s; 0 for an axis that is not measured."""
        self.nis: Final = nis
        """Normalised innovation squared, mean of the axes."""


def navigation_of(state: FilterState | None) -> Navigation | None:
    """Navigation state of a flight filter; None while it aligns, and for any other filter."""
    if not isinstance(state, VelocityAidedState) or state.alignment is not None:
        return None
    return state.navigation


def used_fix(state: FilterState) -> FixRecord | None:
    """The fix that the last step used, None if it used none."""
    navigation = navigation_of(state)
    if navigation is None or not navigation.has_stepped:
        return None
    innovation = navigation.gnss.innovation
    return None if innovation is None or not innovation.is_used else _record(innovation)


def unused_fix(one: VelocityAided, state: FilterState, fix: VelocitySample) -> FixRecord | None:
    """The fix beside a state that does not use it; None if it is older than the velocity history."""
    navigation = navigation_of(state)
    if navigation is None:
        return None
    _, tried = fuse_velocity(navigation.estimate, navigation.imu, navigation.gnss, fix, False, one.parameters)
    innovation = tried.innovation
    return None if innovation is None or not innovation.is_used else _record(innovation)


def _record(innovation: Innovation) -> FixRecord:
    residual = innovation.residual
    down = residual[2] if len(residual) > 2 else 0.0
    return FixRecord(innovation.t_ns, (residual[0], residual[1], down), innovation.nis)


def field_direction(state: FilterState, sample: ImuSample) -> Vec3 | None:
    """Direction of the magnetic field in NED by the sample's reading; None without a reading or an attitude."""
    navigation, field = navigation_of(state), field_of(sample)
    if navigation is None or field is None or not norm(sub(field, navigation.estimate.hard_iron)) > 0.0:
        return None
    rate = body_rate(navigation.estimate, navigation.imu.gyro)
    return levelled_field(navigation.estimate, field, rate, navigation.assumed_declination).direction


def field_reading(
    lane: str, state: FilterState, sample: ImuSample, hard_iron: Vec3, apart_s: float, inclination: float
) -> FieldReading | None:
    """The sample's reading with the attitude of a lane at its time, None without a reading or an attitude.

    hard_iron: of the reading, gauss. apart_s: from the lane's state to the sample, s. inclination: of the Earth's
    field, rad, NaN where it is not known.
    """
    navigation, field = navigation_of(state), field_of(sample)
    if navigation is None or field is None:
        return None
    nav = navigation.estimate
    turn = scale(body_rate(nav, navigation.imu.gyro), 0.5 * (apart_s - nav.mag_lag_s))
    return FieldReading(field, hard_iron, lane, q_mul(nav.q_nb, q_exp(turn)), sample.t_ns, inclination)


def has_field_reading(state: FilterState) -> bool:
    """True when the last step had a new reading of the field that it could use."""
    navigation = navigation_of(state)
    return navigation is not None and navigation.magnetometer.since_reading_s == 0.0


def accel_bias(state: FilterState) -> Vec3:
    """Bias of the accelerometer by the filter, m/s^2; zero while it aligns."""
    navigation = navigation_of(state)
    return (0.0, 0.0, 0.0) if navigation is None else navigation.estimate.accel_bias


def accel_bias_variance(state: FilterState) -> Vec3:
    """Variances of that bias, (m/s^2)^2; zero while the filter aligns."""
    navigation = navigation_of(state)
    if navigation is None:
        return (0.0, 0.0, 0.0)
    aa = navigation.estimate.covariance.aa
    return (aa[0][0], aa[1][1], aa[2][2])


def is_calibrated(state: FilterState) -> bool:
    """True while the filter goes on from sensor errors of earlier flights."""
    navigation = navigation_of(state)
    return navigation is not None and navigation.begun_with is not None


def hard_iron(state: FilterState) -> Vec3:
    """Bias of the magnetometer by the filter, gauss; zero while it aligns."""
    navigation = navigation_of(state)
    return (0.0, 0.0, 0.0) if navigation is None else navigation.estimate.hard_iron


def velocity_of(state: FilterState) -> Vec3:
    """Velocity by the filter, NED, m/s; zero while it aligns."""
    navigation = navigation_of(state)
    return (0.0, 0.0, 0.0) if navigation is None else navigation.estimate.velocity


def fix_lag_of(state: FilterState) -> float:
    """Lag of the velocity fixes behind the inertial readings by the filter, s; 0 while it aligns."""
    navigation = navigation_of(state)
    return 0.0 if navigation is None else navigation.estimate.fix_lag_s


def with_velocity_unknown(one: VelocityAided, state: FilterState) -> FilterState:
    """The state that knows nothing of its velocity any more; whatever depended on it is free of it."""
    navigation = navigation_of(state)
    if navigation is None:
        return state
    return _with_estimate(one, state, navigation.estimate.decoupled(ErrorBlock.VELOCITY, UNKNOWN_VELOCITY))


def with_added_variance(one: VelocityAided, state: FilterState, error: ErrorBlock, variance: float) -> FilterState:
    """The state with one of its errors less certain by this variance in each axis, in the error's unit squared."""
    navigation = navigation_of(state)
    if navigation is None:
        return state
    return _with_estimate(one, state, navigation.estimate.with_added_variance(error, (variance, variance, variance)))


def with_delay_variance(one: VelocityAided, state: FilterState, variance: float) -> FilterState:
    """The state with the delay of its fixes less certain, s^2."""
    navigation = navigation_of(state)
    if navigation is None:
        return state
    return _with_estimate(one, state, navigation.estimate.with_added_variance(ErrorBlock.DELAYS, (0.0, variance, 0.0)))


def with_accel_bias_variance(one: VelocityAided, state: FilterState, variance: float) -> FilterState:
    """The state with the accelerometer's bias less certain by this variance, (m/s^2)^2 an axis, and so its tilt."""
    navigation = navigation_of(state)
    if navigation is None:
        return state
    tilt = variance / one.parameters.gravity**2
    nav = navigation.estimate.with_added_variance(ErrorBlock.ACCEL_BIAS, (variance, variance, variance))
    return _with_estimate(one, state, nav.with_added_variance(ErrorBlock.ATTITUDE, (tilt, tilt, 0.0)))


def on_another_sensor(
    one: VelocityAided,
    state: FilterState,
    own: FilterState,
    gyro_offset: Vec3,
    accel_offset: Vec3,
    bias_variance: float,
) -> FilterState:
    """The state as another inertial sensor goes on from it, which reads more by these offsets, rad/s and m/s^2.

    own: a state of that sensor, which has the hard iron of its magnetometer. bias_variance: of the remaining gyro
    bias, (rad/s)^2.
    """
    navigation, before = navigation_of(state), navigation_of(own)
    if navigation is None:
        return state
    nav = navigation.estimate
    theirs = nav if before is None else before.estimate
    moved = NavigationState(
        nav.q_nb,
        nav.velocity,
        add(nav.gyro_bias, gyro_offset),
        nav.gyro_drift,
        nav.gyro_scale,
        add(nav.accel_bias, accel_offset),
        theirs.hard_iron,
        nav.mag_lag_s,
        nav.fix_lag_s,
        nav.declination_error,
        decoupled(nav.covariance, ErrorBlock.HARD_IRON, theirs.covariance.mm),
    )
    variance = (bias_variance, bias_variance, bias_variance)
    moved = moved.with_added_variance(ErrorBlock.GYRO_BIAS, variance)
    return one.with_estimate(cast("VelocityAidedState", state), moved, is_same_sensor=False)


def _with_estimate(one: VelocityAided, state: FilterState, estimate: NavigationState) -> FilterState:
    return one.with_estimate(cast("VelocityAidedState", state), estimate)


def shifted(fix: VelocitySample, by_s: float) -> VelocitySample:
    """The same fix, so much older than its time stamp says."""
    return fix if by_s == 0.0 else fix.with_time(fix.t_ns - int(1e9 * by_s))

"""The state of a velocity-aided filter as the witness reads it, and as it goes on under another assumption.

Every function gives a new state; the equations of the filter stay as they are.
"""

from math import hypot
from typing import Final

from attest_mav.algebra import add, norm, sub
from attest_mav.filters.base import FilterState
from attest_mav.filters.velocity_aided.aids.gnss_velocity import fuse_velocity, is_velocity
from attest_mav.filters.velocity_aided.aids.magnetometer import field_of, heading_measurement
from attest_mav.filters.velocity_aided.control import Navigation
from attest_mav.filters.velocity_aided.covariance import Covariance
from attest_mav.filters.velocity_aided.nav_state import NavigationState, body_rate
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.prediction import ImuMemory
from attest_mav.filters.velocity_aided.state import VelocityAidedState
from attest_mav.matrices import add_diagonal
from attest_mav.types import ImuSample, Mat3, Vec3, VelocitySample

ZERO: Final = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
UNKNOWN_VELOCITY: Final = 100.0
"""(m/s)^2: variance of a velocity of which nothing is known any more."""


class FixRecord:
    """A velocity fix beside the estimate, whether it was used or not.

    t_ns: the fix's own time stamp. innovation: NED, m/s. nis: its normalised square, mean of the axes.
    """

    def __init__(self, t_ns: int, innovation: Vec3, nis: float) -> None:
        self.t_ns: Final = t_ns
        self.innovation: Final = innovation
        self.nis: Final = nis


def navigation_of(state: FilterState | None) -> Navigation | None:
    """What a flight filter navigates by; None while it aligns, and for any other filter."""
    if not isinstance(state, VelocityAidedState) or state.alignment is not None:
        return None
    return state.navigation


def used_fix(state: FilterState) -> FixRecord | None:
    """The fix that the last step used, None if it used none."""
    navigation = navigation_of(state)
    if navigation is None or navigation.gnss.since_fused_s > 0.0 or not navigation.gnss.source:
        return None
    gnss = navigation.gnss
    return FixRecord(gnss.t_ns, gnss.innovation, gnss.nis)


def unused_fix(state: FilterState, fix: VelocitySample, parameters: FlightParameters) -> FixRecord | None:
    """The fix beside a state that does not use it; None if it is older than the velocity history."""
    navigation = navigation_of(state)
    if navigation is None or not is_velocity(fix):
        return None
    nav, imu, gnss = navigation.estimate, navigation.imu, navigation.gnss
    _, tried = fuse_velocity(nav, imu.history, gnss, fix, False, parameters)
    return None if tried is gnss else FixRecord(fix.t_ns, tried.innovation, tried.nis)


def field_direction(state: FilterState, sample: ImuSample) -> Vec3 | None:
    """Direction of the magnetic field in NED by the sample's reading; None without a reading or an attitude."""
    navigation = navigation_of(state)
    field = field_of(sample)
    if navigation is None or field is None or not norm(sub(field, navigation.estimate.hard_iron)) > 0.0:
        return None
    rate = body_rate(navigation.estimate, navigation.imu.gyro)
    return heading_measurement(navigation.estimate, field, rate, navigation.declination)[1]


def gyro_bias(state: FilterState) -> Vec3:
    """Bias of the gyro by the filter, rad/s."""
    return state.gyro_bias


def accel_bias(state: FilterState) -> Vec3:
    """Bias of the accelerometer by the filter, m/s^2; zero while it aligns."""
    navigation = navigation_of(state)
    return (0.0, 0.0, 0.0) if navigation is None else navigation.estimate.accel_bias


def with_velocity_unknown(state: FilterState) -> FilterState:
    """The state that knows nothing of its velocity any more; whatever depended on it is free of it."""
    navigation = navigation_of(state)
    if navigation is None:
        return state
    p = navigation.estimate.p
    vv: Mat3 = add_diagonal(ZERO, UNKNOWN_VELOCITY)
    return _with_covariance(
        state,
        Covariance(
            p.tt, ZERO, p.tb, p.ts, p.ta, p.tm, p.td,
            vv, ZERO, ZERO, ZERO, ZERO, ZERO,
            p.bb, p.bs, p.ba, p.bm, p.bd,
            p.ss, p.sa, p.sm, p.sd, p.aa, p.am, p.ad, p.mm, p.md, p.dd,
        ),
    )  # fmt: skip


def with_variance_added(
    state: FilterState,
    attitude: float = 0.0,
    gyro_bias: float = 0.0,
    accel_bias: float = 0.0,
    fix_delay: float = 0.0,
) -> FilterState:
    """The state less sure, by these variances per axis: rad^2, (rad/s)^2, (m/s^2)^2, s^2."""
    navigation = navigation_of(state)
    if navigation is None:
        return state
    p = navigation.estimate.p
    (d1, d2, d3), (d4, d5, d6), (d7, d8, d9) = p.dd
    dd: Mat3 = ((d1, d2, d3), (d4, d5 + fix_delay, d6), (d7, d8, d9))
    return _with_covariance(
        state,
        Covariance(
            add_diagonal(p.tt, attitude), p.tv, p.tb, p.ts, p.ta, p.tm, p.td,
            p.vv, p.vb, p.vs, p.va, p.vm, p.vd,
            add_diagonal(p.bb, gyro_bias), p.bs, p.ba, p.bm, p.bd,
            p.ss, p.sa, p.sm, p.sd, add_diagonal(p.aa, accel_bias), p.am, p.ad, p.mm, p.md, dd,
        ),
    )  # fmt: skip


def on_another_sensor(
    state: FilterState, gyro_offset: Vec3, accel_offset: Vec3, sample: ImuSample, bias_variance: float
) -> FilterState:
    """The state as another inertial sensor goes on from it.

    gyro_offset, accel_offset: what that sensor reads more, rad/s and m/s^2. sample: its newest. bias_variance: of what
    is left of the gyro's bias, (rad/s)^2.
    """
    navigation = navigation_of(state)
    if navigation is None:
        return state
    nav, imu = navigation.estimate, navigation.imu
    moved = NavigationState(
        nav.q_nb,
        nav.velocity,
        add(nav.gyro_bias, gyro_offset),
        nav.gyro_scale,
        add(nav.accel_bias, accel_offset),
        nav.hard_iron,
        nav.delays,
        nav.p,
    )
    memory = ImuMemory(
        sample.gyro,
        sample.accel,
        imu.gyro_change,
        imu.accel_change,
        imu.dt_s,
        imu.specific_force,
        imu.gyro_aliasing,
        imu.accel_aliasing,
        imu.history,
    )
    return with_variance_added(_with_navigation(state, _replaced(navigation, moved, memory)), gyro_bias=bias_variance)


def _with_covariance(state: FilterState, p: Covariance) -> FilterState:
    navigation = navigation_of(state)
    if navigation is None:
        return state
    nav = navigation.estimate
    changed = NavigationState(
        nav.q_nb,
        nav.velocity,
        nav.gyro_bias,
        nav.gyro_scale,
        nav.accel_bias,
        nav.hard_iron,
        nav.delays,
        p,
    )
    return _with_navigation(state, _replaced(navigation, changed, navigation.imu))


def _replaced(navigation: Navigation, nav: NavigationState, imu: ImuMemory) -> Navigation:
    return Navigation(
        nav,
        imu,
        navigation.gnss,
        navigation.magnetometer,
        navigation.stationary,
        navigation.wind,
        navigation.declination,
        navigation.declination_known,
        navigation.mode,
    )


def _with_navigation(state: FilterState, navigation: Navigation) -> FilterState:
    """The state with this estimate; the attitude shown stays, since no estimate of it has changed."""
    if not isinstance(state, VelocityAidedState):
        return state
    nav = navigation.estimate
    return VelocityAidedState(
        state.q_nb,
        nav.gyro_bias,
        state.accel_used,
        state.mag_used,
        hypot(nav.tilt_sigma, state.reset_sigma),
        hypot(nav.heading_sigma, state.reset_sigma),
        None,
        navigation,
        0.0,
        False,
        state.reset_sigma,
    )


def velocity_of(state: FilterState) -> Vec3:
    """Velocity by the filter, NED, m/s; zero while it aligns."""
    navigation = navigation_of(state)
    return (0.0, 0.0, 0.0) if navigation is None else navigation.estimate.velocity


def fix_delay_of(state: FilterState) -> float:
    """Delay of the velocity fixes by the filter, s."""
    navigation = navigation_of(state)
    return 0.0 if navigation is None else navigation.estimate.delays[1]


def shifted(fix: VelocitySample, by_s: float) -> VelocitySample:
    """The same fix, so much older than its time stamp says."""
    if by_s == 0.0:
        return fix
    return VelocitySample(
        fix.source,
        fix.system,
        fix.component,
        fix.t_ns - int(1e9 * by_s),
        fix.rx_ns,
        fix.v_ned,
        fix.vertical_known,
        fix.origin,
        fix.sigma,
    )

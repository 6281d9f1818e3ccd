"""Alignment: the navigation at its start, and what a restart keeps of the one before.

(Filter initialisation: Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed.,
chapter 3; which errors survive a reset is the choice of this filter: all of the sensors', none of the motion's.)
"""

from math import isfinite
from typing import Final

from attest_mav.filters.calibration import SensorCalibration, SensorErrors
from attest_mav.filters.velocity_aided.aids.airspeed import unknown_wind
from attest_mav.filters.velocity_aided.aids.fallback import Fallback
from attest_mav.filters.velocity_aided.aids.gnss_velocity import initial_gnss_velocity
from attest_mav.filters.velocity_aided.aids.magnetometer import initial_magnetometer
from attest_mav.filters.velocity_aided.aids.zero_motion import initial_stationary
from attest_mav.filters.velocity_aided.alignment.solve import AlignmentMethod, InitialState
from attest_mav.filters.velocity_aided.calibration import at_start, unknown
from attest_mav.filters.velocity_aided.control import NO_FALLBACK
from attest_mav.filters.velocity_aided.covariance_blocks import ErrorBlock, diagonal_covariance
from attest_mav.filters.velocity_aided.imu_memory import initial_memory
from attest_mav.filters.velocity_aided.lags import first_lag_covariance, nominal_fix_lag_s, nominal_mag_lag_s
from attest_mav.filters.velocity_aided.nav_state import NavigationState
from attest_mav.filters.velocity_aided.navigation import AidingMode, Navigation
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.reading import Reading
from attest_mav.matrices import diagonal
from attest_mav.types import Vec3, VelocityOrigin

UNKNOWN_DECLINATION: Final = 0.3
"""rad: 1-sigma; where people fly, magnetic north is rarely further from true north."""


def first_navigation(
    initial: InitialState,
    reading: Reading,
    t_ns: int,
    bias: Vec3,
    declination: float,
    parameters: FlightParameters,
    calibration: SensorCalibration | None = None,
) -> Navigation:
    """The first navigation, at the reading of ``t_ns``.

    bias: of the gyro, as far as it is known, rad/s. declination: rad, NaN when it is not known. calibration: sensor
    errors by earlier flights.
    """
    declination_known = isfinite(declination)
    begun_with = None if calibration is None else at_start(calibration, parameters)
    nav = _first_state(initial, bias, declination_known, parameters, begun_with)
    return Navigation(
        estimate=nav,
        imu=initial_memory(nav, reading, t_ns),
        gnss=initial_gnss_velocity(parameters).after_reset(initial.method == AlignmentMethod.VELOCITY),
        magnetometer=initial_magnetometer(parameters),
        iron=None,
        stationary=initial_stationary(reading),
        wind=unknown_wind(),
        fallback=NO_FALLBACK,
        declination=declination if declination_known else None,
        mode=AidingMode.COASTING,
        begun_with=begun_with,
        has_stepped=False,
    )


def restarted_navigation(
    initial: InitialState,
    before: Navigation,
    reading: Reading,
    t_ns: int,
    gap_s: float,
    parameters: FlightParameters,
) -> Navigation:
    """The navigation after a gap or a failure, at the reading of ``t_ns``: the sensor errors stay as they are known.

    gap_s: time since the earlier navigation ended, in which the gyro's bias has wandered, by no more
    than that of any gyro.
    """
    velocity_variance = initial.velocity_sigma**2
    nav = before.estimate.restarted(initial.q_nb, initial.attitude, initial.velocity, velocity_variance)
    wandered = parameters.gyro_bias_walk**2 * gap_s + (parameters.gyro_drift_sigma * gap_s) ** 2
    added = min(wandered, parameters.gyro_bias_sigma**2)
    nav = nav.with_added_variance(ErrorBlock.GYRO_BIAS, (added, added, added))
    return Navigation(
        estimate=nav,
        imu=initial_memory(nav, reading, t_ns),
        gnss=before.gnss.after_reset(initial.method == AlignmentMethod.VELOCITY),
        magnetometer=before.magnetometer.after_reset(),
        iron=None if before.iron is None else before.iron.in_another_field(),
        stationary=initial_stationary(reading),
        wind=before.wind,
        fallback=Fallback(before.fallback.since_update_s, None),
        declination=before.declination,
        mode=AidingMode.COASTING,
        begun_with=before.begun_with,
        has_stepped=False,
    )


def _first_state(
    initial: InitialState,
    bias: Vec3,
    declination_known: bool,
    parameters: FlightParameters,
    begun_with: SensorErrors | None,
) -> NavigationState:
    """The state of a first start. bias: of the gyro, rad/s."""
    declination_sigma = parameters.declination_sigma if declination_known else UNKNOWN_DECLINATION
    zero: Vec3 = (0.0, 0.0, 0.0)
    known = unknown(parameters) if begun_with is None else begun_with
    return NavigationState(
        q_nb=initial.q_nb,
        velocity=initial.velocity,
        gyro_bias=bias,
        gyro_drift=zero,
        gyro_scale=zero,
        accel_bias=known.accel_bias.mean,
        hard_iron=known.hard_iron.mean,
        mag_lag_s=nominal_mag_lag_s(parameters),
        fix_lag_s=nominal_fix_lag_s(VelocityOrigin.RECEIVER, parameters),
        declination_error=0.0,
        covariance=diagonal_covariance(
            [
                initial.attitude,
                diagonal(initial.velocity_sigma**2),
                diagonal(parameters.gyro_bias_sigma**2),
                diagonal(parameters.gyro_scale_sigma**2),
                known.accel_bias.covariance,
                known.hard_iron.covariance,
                first_lag_covariance(declination_sigma, parameters),
                diagonal(parameters.gyro_drift_sigma**2),
            ]
        ),
    )

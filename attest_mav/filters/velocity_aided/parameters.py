"""The parameters of the flight filter: one set for every vehicle and rate.

Noises are standard deviations; "per root second" is the square root of a spectral density. docs/measurements.md has
the effect of each part. (Sensor noise models: Groves, Principles of GNSS, Inertial, and Multisensor Integrated
Navigation Systems, 2nd ed., sections 4.4 and 14.2.6.)
"""

from dataclasses import dataclass
from math import radians
from typing import Final

from attest_mav.filters.parameter_check import check_parameters
from attest_mav.record import Record
from attest_mav.types import G_MPS2

_POSITIVE: Final = (
    "velocity_sigma",
    "velocity_gate",
    "mag_sigma",
    "mag_knee",
    "mag_gate",
    "aliasing_hold_s",
    "disturbance_hold_s",
    "gyro_drift_s",
    "accel_noise_seen_s",
    "align_tilt",
    "align_heading",
    "gravity",
)
"""Parameters that are not zero either."""


@dataclass(frozen=True)
class FlightParameters(Record):
    """Properties of the vehicle, process noise, measurement noise and gates, and the start, in this order."""

    low_pass_hz: float = 20.0
    """Hz. Corner of the autopilot's second-order low-pass on gyro and accelerometer (INS_GYRO_FILTER); 0 for none. Its
    group delay is taken off the output: an error of 10 Hz shifts the output by a few ms times the rate."""
    low_pass_delay_sigma: float = 0.02
    """s. 1-sigma of that group delay while the corner is only assumed; 0 once it is known. Corners of 5 to 80 Hz make
    45 to 3 ms. Turns reduce it, see ``lags``; times the rate, the rest is part of the output's sigma."""
    fix_delay_s: float = 0.10
    """s. Age of a receiver's velocity at the time that its message names (GPS_DELAY_MS); the estimate starts there."""
    fix_delay_sigma: float = 0.04
    """s. 1-sigma of that delay at the start; smaller trusts the setting, larger learns it in the first manoeuvres."""
    own_delay_s: float = 0.01
    """s. The same age for velocities of the autopilot's own estimator, which extrapolates to the present."""
    own_delay_sigma: float = 0.01
    """s. 1-sigma of that delay."""
    mag_delay_s: float = 0.055
    """s. Age of the magnetometer's reading at the time of its message; RAW_IMU repeats a mean of 10 Hz, which is 45 ms
    late when it is new, and 55 ms where a message of 50 Hz shows it first."""
    mag_delay_sigma: float = 0.03
    """s. 1-sigma of that delay at the start."""
    declination_sigma: float = 0.02
    """rad. 1-sigma of the declination at the place together with the mounting of the compass."""
    hard_iron: float = 0.010
    """gauss. 1-sigma of the magnetometer's bias that calibration leaves, per axis; 0 leaves it out of the state."""
    hard_iron_walk: float = 1e-4
    """gauss per root s. Drift of that bias."""
    gyro_bias_sigma: float = radians(0.3)
    """rad/s. 1-sigma of the gyro's bias at the start, per axis."""
    gyro_drift_sigma: float = 2.5e-5
    """rad/s^2. 1-sigma of the rate at which that bias drifts, as it does while a sensor warms up: 0.09 deg/s a minute;
    0 leaves it out of the state."""
    gyro_drift_s: float = 300.0
    """s. Time constant with which such a drift ends."""
    gyro_scale_sigma: float = 0.004
    """1. 1-sigma of the gyro's scale error, per axis; 0 leaves it out of the state."""
    accel_bias_sigma: float = 0.123
    """m/s^2. 1-sigma of the accelerometer's bias at the start, per axis; 0 leaves it out of the state."""
    speed_noise: float = 4.0
    """m/s per root Hz. Noise of airspeed along the nose, and of zero sideways and downwards, of a vehicle that goes
    where it points; smaller takes slip and gusts for tilt."""

    gyro_noise: float = 1e-4
    """rad per root s. White noise of the gyro; in flight the larger one counts that its readings show."""
    gyro_rate_noise: float = 5e-4
    """rad per root s for each rad/s. Noise that grows with the rate: misalignment, timing."""
    accel_noise: float = 0.01
    """m/s per root s. White noise of the accelerometer; in flight the larger one counts that its readings show."""
    accel_noise_unseen: float = 0.047
    """m/s per root s. The same while readings that change have not shown it: a weak witness of bias against tilt must
    not count before the take-off is over."""
    accel_noise_seen_s: float = 40.0
    """s. Length of such readings that halves this variance, as the prior of a variance fades in its mean."""
    gyro_bias_walk: float = 1.6e-4
    """rad/s per root s. Drift of the gyro's bias. Too small and the estimate cannot follow a warming gyro; too large
    and the heading wanders with every disturbance of the field."""
    accel_bias_walk: float = 1e-4
    """m/s^2 per root s. Drift of the accelerometer's bias."""
    gyro_aliasing: float = 0.22
    """1. Share of the gyro's second difference that may have been missed between two samples far apart; the low-pass
    takes its part from samples that are near (``aliased_share``). This noise keeps sigma true at 4 Hz; too small and a
    fast manoeuvre between samples goes unnoticed."""
    accel_aliasing: float = 0.09
    """1. The same for the accelerometer, axis by axis, whatever the low-pass: vibration has an axis."""
    aliasing_hold_s: float = 0.5
    """s. Time constant with which the largest second difference decays, or eight steps where these are longer."""

    velocity_sigma: float = 0.25
    """m/s. Noise of a fix at the start; from then on it is 2.5 times the rms of the innovations. Also the largest noise
    that the consistency test allows for."""
    velocity_floor: float = 0.04
    """m/s. Least noise of a fix: errors that last do not show in innovations."""
    velocity_ceiling: float = 1.0
    """m/s. Largest noise of a fix, short of the inflation to the gate."""
    fix_jitter_s: float = 0.036
    """s. Jitter of a fix's time; as noise it is multiplied by the acceleration, and in the consistency test by the
    acceleration that the inertial samples may not have shown too."""
    fix_spacing_s: float = 0.19
    """s. Fixes that come faster are skipped, for their errors are the same."""
    velocity_gate: float = 6.0
    """sigmas. A fix beyond has its variance inflated until it lies on the gate."""
    mag_sigma: float = 0.02
    """Share of the field. Noise of a magnetometer reading at the start; then twice the rms of the innovations."""
    mag_floor: float = 0.005
    """Share of the field. Least noise of a reading."""
    mag_ceiling: float = 0.05
    """Share of the field. Largest noise of a reading that agrees."""
    mag_spacing_s: float = 0.05
    """s. Readings that come faster are skipped."""
    mag_knee: float = 1.5
    """sigmas. From here on a reading's variance grows with its residual (paper 2, eq. (16))."""
    mag_jitter_s: float = 0.04
    """s. Jitter of a reading's time; as noise it is multiplied by the rate."""
    mag_gate: float = 4.0
    """sigmas. A reading beyond tells of a disturbance as large as its residual."""
    disturbance_free: float = 0.02
    """Share of the field. Deviation of its strength or inclination that is no disturbance."""
    disturbance_weight: float = 3.0
    """1. Noise of the heading for a disturbance seen in strength and inclination; larger relies on the gyro sooner."""
    disturbance_hold_s: float = 30.0
    """s. Time constant with which a disturbance decays once it is not seen any more."""
    rest_floor: float = 6e-4
    """rad/s. Least sigma of the gyro's bias at rest: an int16 of 1 mrad/s hides less."""
    gravity_noise: float = 3.0
    """m/s^2 per root Hz. Horizontal acceleration of a vehicle whose velocity is not known; smaller leans in turns."""
    place_noise: float = 0.35
    """m/s per root Hz. Noise of zero velocity where the mean velocity is zero."""
    coast_s: float = 30.0
    """s. Time for which a lost velocity is carried on before gravity takes its place."""
    restart_nis: float = 12.0
    """1. Mean normalised innovation squared of the velocity above which the attitude is reset."""

    align_tilt: float = radians(5.0)
    """rad. 1-sigma of the tilt with which an alignment ends."""
    align_heading: float = radians(20.0)
    """rad. 1-sigma of the heading with which an alignment ends."""
    align_patience_s: float = 5.0
    """s. After this time an alignment ends with the attitude that it has."""
    valid_tilt: float = radians(1.0)
    """rad. 1-sigma of the tilt below which the attitude is called valid."""
    gravity: float = G_MPS2
    """m/s^2. Local gravity."""

    def __post_init__(self) -> None:
        """Refuse parameters that make no sense."""
        check_parameters(self, positive=_POSITIVE)


BARE_SENSOR: Final = FlightParameters(
    low_pass_hz=0.0,
    low_pass_delay_sigma=0.0,
    fix_delay_s=0.0,
    mag_delay_s=0.0,
    mag_delay_sigma=0.003,
    own_delay_s=0.0,
    accel_bias_sigma=0.08,
    gyro_rate_noise=2e-3,
    accel_noise=0.015,
    accel_noise_unseen=0.015,
)
"""Parameters for readings as a sensor gives them: neither low-passed nor late, as an autopilot's messages are. Its axes
are misaligned by some tenths of a per cent, which is noise that grows with the rate; its accelerometer is not shaken by
motors, and nothing but the sensor's own noise and bias is between it and the velocity."""

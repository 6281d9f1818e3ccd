"""The parameters of the flight filter: one set for every vehicle and rate."""

from dataclasses import dataclass
from math import radians

from attest_mav.types import G_MPS2


@dataclass(frozen=True)
class FlightParameters:
    """Noises are standard deviations; "per root second" is the square root of a spectral density.

    Of the vehicle:

    low_pass_hz: corner of the autopilot's second-order low-pass on gyro and accelerometer (INS_GYRO_FILTER); 0 for
    none. Its group delay is added to the output; wrong by 10 Hz it costs some milliseconds of the turn rate.
    low_pass_delay_sigma: of that delay, s, while the corner is only assumed; 0 once it is known.
    fix_delay_s, fix_delay_sigma: age of the velocity in GPS_RAW_INT at the time it names (GPS_DELAY_MS); it is
    estimated from there. own_delay_s, own_delay_sigma: the same for velocities of the autopilot's own filter.
    mag_delay_s, mag_delay_sigma: lag of the magnetometer, estimated from there. RAW_IMU repeats a 10 Hz mean.
    declination_sigma: of the declination at the place, and of how the compass is mounted, rad.
    hard_iron: what calibration leaves of the magnetometer's bias, per axis, gauss; hard_iron_walk: its drift.
    gyro_bias_sigma: at the start, rad/s. gyro_scale_sigma: of the gyro's scale, a share.
    accel_bias_sigma: m/s^2; 0 leaves the accelerometer's bias out.
    speed_noise: of the airspeed along the nose, and of zero sideways and downwards, where a wing flies, m/s per
    root Hz.

    Of the process:

    gyro_noise: rad per root s, and gyro_rate_noise: as much for each rad/s of rate. accel_noise: m/s per root s.
    gyro_bias_walk: rad/s per root s. Too small and the filter cannot follow the warming gyro; too large and the heading
    wanders with every disturbance of the field. accel_bias_walk: m/s^2 per root s. gyro_aliasing, accel_aliasing: share
    of the bend of the readings (their second difference) that may have been missed between two samples; the largest is
    remembered for aliasing_hold_s. They make sigma tell the truth at 4 Hz; too small and a fast manoeuvre between
    samples goes unnoticed.

    Of the measurements:

    velocity_sigma: m/s, at the start; from then on it follows the innovations (twice their rms) between
    velocity_floor and velocity_ceiling. fix_jitter_s: of the time of a fix. fix_spacing_s: faster fixes are skipped,
    for their errors are the same. velocity_gate: sigmas beyond which the variance is inflated until the residual
    lies on the gate.
    mag_sigma, mag_floor, mag_ceiling: the same three for the magnetometer, as a share of the field. mag_jitter_s: of
    the time of a reading. mag_spacing_s: readings that come faster are skipped. mag_knee: sigmas from which its
    variance grows with the residual (paper 2, eq. (16)). mag_gate: sigmas from which a
    reading tells of a disturbance as large as itself.
    disturbance_free: deviation of the field's strength or dip, as a share, that is no disturbance.
    disturbance_weight: how much of a visible disturbance is believed to lie across the heading; it is remembered
    for disturbance_hold_s.
    rest_floor: what rest tells of the gyro's bias at best, rad/s: an int16 of 1 mrad/s hides less.
    gravity_noise: of the horizontal acceleration of a vehicle whose velocity is not known, m/s^2 per root Hz.
    place_noise: of zero velocity where the motion stays in place, m/s per root Hz.
    coast_s: how long a lost velocity is carried on before anything is put in its place.
    restart_nis: mean normalised innovation squared of the velocity above which the attitude is given up.

    Of the start: align_tilt, align_heading: rad, the filter starts when it knows them this well.
    align_patience_s: after this long it starts with what it has. valid_tilt: rad, 1-sigma below which the attitude
    is called valid. gravity: m/s^2.
    """

    low_pass_hz: float = 20.0
    low_pass_delay_sigma: float = 0.008
    fix_delay_s: float = 0.10
    fix_delay_sigma: float = 0.04
    own_delay_s: float = 0.01
    own_delay_sigma: float = 0.01
    mag_delay_s: float = 0.06
    mag_delay_sigma: float = 0.05
    declination_sigma: float = radians(1.0)
    hard_iron: float = 0.010
    hard_iron_walk: float = 1e-4
    gyro_bias_sigma: float = radians(0.3)
    gyro_scale_sigma: float = 0.004
    accel_bias_sigma: float = 0.09
    speed_noise: float = 4.0
    gyro_noise: float = 1e-4
    gyro_rate_noise: float = 2e-3
    accel_noise: float = 0.02
    gyro_bias_walk: float = 2e-4
    accel_bias_walk: float = 1e-4
    gyro_aliasing: float = 0.22
    accel_aliasing: float = 0.1
    aliasing_hold_s: float = 2.0
    velocity_sigma: float = 0.25
    velocity_floor: float = 0.05
    velocity_ceiling: float = 0.5
    fix_jitter_s: float = 0.03
    fix_spacing_s: float = 0.19
    velocity_gate: float = 6.0
    mag_sigma: float = 0.02
    mag_floor: float = 0.005
    mag_ceiling: float = 0.05
    mag_spacing_s: float = 0.05
    mag_knee: float = 1.5
    mag_jitter_s: float = 0.04
    mag_gate: float = 4.0
    disturbance_free: float = 0.02
    disturbance_weight: float = 3.0
    disturbance_hold_s: float = 30.0
    rest_floor: float = 6e-4
    gravity_noise: float = 3.0
    place_noise: float = 0.35
    coast_s: float = 30.0
    restart_nis: float = 12.0
    align_tilt: float = radians(5.0)
    align_heading: float = radians(20.0)
    align_patience_s: float = 5.0
    valid_tilt: float = radians(1.0)
    gravity: float = G_MPS2

"""The magnetometer: one row that turns the heading, and a watch on the field.

The row is the field's component along magnetic east, which is zero in truth. The field's strength and dip do not
enter it, so no model of them is needed; they are watched instead, for a disturbance shows in them too. What
can be seen of a disturbance is taken as the size of what cannot, for as long as ``disturbance_hold_s``.

RAW_IMU repeats a magnetometer of 10 Hz: a reading is new when it differs from the one before. At rest it may
stay the same for good reason, and is used again now and then.
"""

from math import cos, exp, sin, sqrt
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import clamp, cross, dot, mat_vec, norm, q_exp, q_mul, q_to_matrix, scale, sub
from attest_mav.filters.velocity_aided.covariance import Measurement
from attest_mav.filters.velocity_aided.nav_state import (
    DEADBAND_RATE,
    NavigationState,
    cross_covariance_of,
    deadband,
    fuse,
)
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.prediction import dequantised
from attest_mav.matrices import mat_t_vec
from attest_mav.types import ImuSample, Vec3

MAX_FIELD: Final = 1e3
"""gauss: a reading of this length or more is no field."""
REUSE_S: Final = 0.5
"""At rest an unchanged reading is used again after this long."""
REST_RATE: Final = 0.02
"""rad/s."""
POWER_SHARE: Final = 0.02
"""Share of a new innovation in their remembered mean square."""
POWER_STEP: Final = 9.0
"""One innovation counts for at most this many times the mean square."""
NOISE_FACTOR: Final = 2.0
"""The noise of a reading as a multiple of the innovations' rms."""
USUAL_S: Final = 60.0
"""Time constant with which the usual strength and dip follow an undisturbed field."""
LAG_ERROR_S: Final = 0.03
"""Of the magnetometer's lag: a turn by this much is no deviation of the dip."""


@mypyc_attr(acyclic=True)
class Magnetometer:
    """What is remembered of the field, and the record of the last reading.

    last: the last reading, gauss, as received. held_s: since one was used. lost_s: since a reading
    corrected the heading. strength: gauss, and dip (sine), as they usually are; strength 0 before the first.
    disturbance: remembered deviation from the usual, as a share of the field. power: mean square innovation.
    innovation: of the last reading, as a share of the field (east positive to the left); nis: its normalised square.
    used: whether this step's reading corrected the heading.
    """

    def __init__(
        self,
        last_reading: Vec3,
        since_reading_s: float,
        since_accepted_s: float,
        usual_strength: float,
        usual_inclination_sine: float,
        disturbance: float,
        innovation_power: float,
        innovation: float,
        nis: float,
        used: bool,
    ) -> None:
        self.last_reading: Final = last_reading
        self.since_reading_s: Final = since_reading_s
        self.since_accepted_s: Final = since_accepted_s
        self.usual_strength: Final = usual_strength
        self.usual_inclination_sine: Final = usual_inclination_sine
        self.disturbance: Final = disturbance
        self.innovation_power: Final = innovation_power
        self.innovation: Final = innovation
        self.nis: Final = nis
        self.used: Final = used


def initial_magnetometer(parameters: FlightParameters) -> Magnetometer:
    """Before the first reading."""
    innovation_power = (parameters.mag_sigma / NOISE_FACTOR) ** 2
    return Magnetometer((0.0, 0.0, 0.0), 0.0, 1e9, 0.0, 0.0, 0.0, innovation_power, 0.0, 0.0, False)


def field_of(sample: ImuSample) -> Vec3 | None:
    """The sample's field, gauss, with half a unit given back; None when it is none."""
    mag = sample.mag
    if mag is None or not 0.0 < norm(mag) < MAX_FIELD:
        return None
    return dequantised(mag, sample.quantum.mag)


def reading_is_due(magnetometer: Magnetometer, sample: ImuSample, dt_s: float, parameters: FlightParameters) -> bool:
    """True when the sample's reading is a new one, and far enough from the last one used.

    One that comes too soon is not used later: it would be older than its lag says.
    """
    since_s = magnetometer.since_reading_s + dt_s
    if sample.mag != magnetometer.last_reading:
        return since_s > parameters.mag_spacing_s or magnetometer.usual_strength <= 0.0
    return since_s > REUSE_S and norm(sample.gyro) < REST_RATE


def skip_reading(magnetometer: Magnetometer, sample: ImuSample, dt_s: float) -> Magnetometer:
    """The memory after a step whose reading is not used."""
    return Magnetometer(
        magnetometer.last_reading if sample.mag is None else sample.mag,
        magnetometer.since_reading_s + dt_s,
        magnetometer.since_accepted_s,
        magnetometer.usual_strength,
        magnetometer.usual_inclination_sine,
        magnetometer.disturbance,
        magnetometer.innovation_power,
        magnetometer.innovation,
        magnetometer.nis,
        False,
    )


def fuse_magnetometer(
    nav: NavigationState,
    magnetometer: Magnetometer,
    sample: ImuSample,
    field: Vec3,
    rate: Vec3,
    dt_s: float,
    declination: float,
    estimates_sensors: bool,
    parameters: FlightParameters,
) -> tuple[NavigationState, Magnetometer]:
    """Motion and memory after a new reading. ``field``: gauss. ``rate``: of the body, rad/s.

    teaches: it may tell something of the sensors.
    """
    measurement, direction, strength = heading_measurement(nav, field, rate, declination)
    monitored = _monitor_field(magnetometer, nav, strength, direction[2], norm(rate), dt_s, parameters)
    cross_cov = cross_covariance_of(nav, measurement)
    sigma = clamp(NOISE_FACTOR * sqrt(magnetometer.innovation_power), parameters.mag_floor, parameters.mag_ceiling)
    nominal_variance = sigma * sigma + (parameters.mag_jitter_s * measurement.d[0]) ** 2
    normalised = abs(measurement.residual) / sqrt(cross_cov.state_variance + nominal_variance)
    agrees = normalised < parameters.mag_gate
    disturbance = monitored.disturbance if agrees else max(monitored.disturbance, abs(measurement.residual))
    # Equivalent variance of paper 2, eq. (16): from the knee on it grows with the residual.
    variance = (
        nominal_variance * max(1.0, normalised / parameters.mag_knee)
        + (parameters.disturbance_weight * disturbance) ** 2
    )
    innovation_power = magnetometer.innovation_power
    if agrees:
        innovation_power += POWER_SHARE * (
            min(measurement.residual**2, POWER_STEP * innovation_power + 1e-8) - innovation_power
        )
    return fuse(nav, measurement, cross_cov, variance, estimates_sensors), Magnetometer(
        magnetometer.last_reading if sample.mag is None else sample.mag,
        0.0,
        0.0 if agrees else magnetometer.since_accepted_s + magnetometer.since_reading_s + dt_s,
        monitored.strength,
        monitored.inclination_sine,
        disturbance,
        innovation_power,
        measurement.residual,
        normalised * normalised,
        agrees,
    )


def heading_measurement(
    nav: NavigationState, field: Vec3, rate: Vec3, declination: float
) -> tuple[Measurement, Vec3, float]:
    """The row of a reading, the field's direction in NED without the iron, and its strength, gauss.

    The residual is the component along magnetic east, as a share of the strength, with its sign changed.
    """
    iron_free = sub(field, nav.hard_iron)
    strength = norm(iron_free)
    # The attitude at the time of the reading: the lag is short enough to turn back at the present rate.
    then = q_to_matrix(q_mul(nav.q_nb, q_exp(scale(rate, -0.5 * nav.delays[0]))))
    direction = scale(mat_vec(then, iron_free), 1.0 / strength)
    north = declination + nav.delays[2]
    east: Vec3 = (-sin(north), cos(north), 0.0)
    lag = mat_vec(then, scale(cross(deadband(rate, DEADBAND_RATE), iron_free), 1.0 / strength))
    measurement = Measurement(
        -dot(east, direction),
        t=cross(direction, east),
        m=scale(mat_t_vec(then, east), -1.0 / strength),
        d=(-dot(east, lag), 0.0, -(cos(north) * direction[0] + sin(north) * direction[1])),
    )
    return measurement, direction, strength


@mypyc_attr(acyclic=True)
class MonitoredField:
    """The usual field and the remembered disturbance after a reading."""

    def __init__(self, strength: float, inclination_sine: float, disturbance: float) -> None:
        self.strength: Final = strength
        self.inclination_sine: Final = inclination_sine
        self.disturbance: Final = disturbance


def _monitor_field(
    magnetometer: Magnetometer,
    nav: NavigationState,
    strength: float,
    inclination_sine: float,
    rate: float,
    dt_s: float,
    parameters: FlightParameters,
) -> MonitoredField:
    """Compare strength and dip with the usual ones. The dip may also be off by what the tilt may be off."""
    if magnetometer.usual_strength <= 0.0:
        return MonitoredField(strength, inclination_sine, 0.0)
    free = parameters.disturbance_free
    off_strength = max(0.0, abs(strength / magnetometer.usual_strength - 1.0) - free)
    off_inclination = max(
        0.0,
        abs(inclination_sine - magnetometer.usual_inclination_sine) - free - 3.0 * nav.tilt_sigma - LAG_ERROR_S * rate,
    )
    off = sqrt(off_strength * off_strength + off_inclination * off_inclination)
    since_s = magnetometer.since_reading_s + dt_s
    disturbance = max(off, magnetometer.disturbance * exp(-since_s / parameters.disturbance_hold_s))
    if off >= free:
        return MonitoredField(magnetometer.usual_strength, magnetometer.usual_inclination_sine, disturbance)
    share = min(1.0, since_s / USUAL_S)
    return MonitoredField(
        magnetometer.usual_strength + share * (strength - magnetometer.usual_strength),
        magnetometer.usual_inclination_sine + share * (inclination_sine - magnetometer.usual_inclination_sine),
        disturbance,
    )

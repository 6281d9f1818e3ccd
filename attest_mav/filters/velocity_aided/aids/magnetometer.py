"""The magnetometer: one measurement that turns the heading, and a monitor of the field.

The measurement is the field's component along magnetic east, which is zero in truth. Strength and inclination are not
fused, so no model of them is needed; they are monitored. A deviation there is taken as the size of the unobservable
disturbance of the heading, for as long as ``disturbance_hold_s``. (Magnetic heading and its errors: Groves, Principles
of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., section 6.1.1.)

RAW_IMU repeats a magnetometer of 10 Hz: a reading is new when it differs from the one before. At rest it may stay the
same for good reason, and is fused again now and then.
"""

from math import exp, inf, sqrt
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.algebra import clamp, norm, square
from attest_mav.filters.robust import averaged_power, inflation
from attest_mav.filters.velocity_aided.aids.field import LevelledField
from attest_mav.filters.velocity_aided.measurement import CrossCovariance
from attest_mav.filters.velocity_aided.nav_state import NavigationState, cross_covariance_of, fuse
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.innovation import Aid, Fusion, Innovation
from attest_mav.record import Record
from attest_mav.samples import ImuSample

REUSE_S: Final = 0.5
"""At rest an unchanged reading is fused again after this long, s."""
REST_RATE: Final = 0.02
"""rad/s: a vehicle that turns no faster may well show the same field again."""
POWER_SHARE: Final = 0.02
"""Weight of a new innovation in the running mean square."""
POWER_STEP: Final = 9.0
"""One innovation counts for at most this many times the mean square."""
POWER_FLOOR: Final = 1e-8
"""Share of the field, squared: what it may always count for."""
NOISE_FACTOR: Final = 2.0
"""The noise of a reading as a multiple of the innovations' rms."""
USUAL_S: Final = 60.0
"""Time constant with which the usual field follows an undisturbed one, s."""
LAG_ERROR_S: Final = 0.03
"""Error of the magnetometer's delay, s: a rotation by this much is no deviation of the inclination."""


@mypyc_attr(acyclic=True)
class UsualField(Record):
    """The field as it usually is."""

    def __init__(self, strength: float, inclination_sine: float) -> None:
        self.strength: Final = strength
        """gauss."""
        self.inclination_sine: Final = inclination_sine
        """Sine of the angle below the horizontal."""


@mypyc_attr(acyclic=True, free_list_len=1)
class Magnetometer(Record):
    """The state of magnetometer fusion."""

    def __init__(
        self,
        last: ImuSample | None,
        since_reading_s: float,
        since_accepted_s: float,
        usual: UsualField | None,
        disturbance: float,
        innovation_power: float,
        innovation: Innovation | None,
    ) -> None:
        self.last: Final = last
        """The last sample with a reading; None before the first."""
        self.since_reading_s: Final = since_reading_s
        """Time since a reading was fused, s."""
        self.since_accepted_s: Final = since_accepted_s
        """Time since one agreed with the heading, s; infinite before the first."""
        self.usual: Final = usual
        """The undisturbed field; None before the first reading."""
        self.disturbance: Final = disturbance
        """Largest deviation of late, as a share of the field, decaying."""
        self.innovation_power: Final = innovation_power
        """Running mean square of the innovations, a share of the field squared."""
        self.innovation: Final = innovation
        """Of this step's reading, None where it had no new one."""

    @property
    def used(self) -> bool:
        """True when this step's reading agreed with the heading."""
        return self.innovation is not None and self.innovation.fusion == Fusion.USED

    def is_new(self, sample: ImuSample) -> bool:
        """True when the sample has another reading than the last one with a reading."""
        last = self.last
        return sample.has_field and (last is None or sample.field != last.field)

    def after_reset(self) -> "Magnetometer":
        """The memory at a start: all but the record of an earlier step."""
        return Magnetometer(
            self.last,
            self.since_reading_s,
            self.since_accepted_s,
            self.usual,
            self.disturbance,
            self.innovation_power,
            None,
        )

    def without_field(self, parameters: FlightParameters) -> "Magnetometer":
        """The memory without what it has learnt of a field that had iron in it."""
        first = initial_magnetometer(parameters)
        return Magnetometer(
            self.last,
            self.since_reading_s,
            self.since_accepted_s,
            first.usual,
            first.disturbance,
            first.innovation_power,
            self.innovation,
        )

    def skipped(self, sample: ImuSample, dt_s: float, innovation: Innovation | None) -> "Magnetometer":
        """The memory after a step without a reading to be fused. innovation: of one that cannot be, if it is new."""
        return Magnetometer(
            sample if sample.has_field else self.last,
            self.since_reading_s + dt_s,
            self.since_accepted_s,
            self.usual,
            self.disturbance,
            self.innovation_power,
            innovation,
        )


def initial_magnetometer(parameters: FlightParameters) -> Magnetometer:
    """The state of fusion before the first reading."""
    return Magnetometer(None, 0.0, inf, None, 0.0, (parameters.mag_sigma / NOISE_FACTOR) ** 2, None)


def reading_is_due(magnetometer: Magnetometer, sample: ImuSample, dt_s: float, parameters: FlightParameters) -> bool:
    """True when the sample's reading is a new one, and far enough from the last one that was fused.

    One that comes too soon is not fused later: it would be older than its delay says.
    """
    since_s = magnetometer.since_reading_s + dt_s
    if magnetometer.is_new(sample):
        return since_s > parameters.mag_spacing_s or magnetometer.usual is None
    return since_s > REUSE_S and norm(sample.gyro) < REST_RATE


def fuse_magnetometer(
    nav: NavigationState,
    magnetometer: Magnetometer,
    sample: ImuSample,
    field: LevelledField,
    dt_s: float,
    estimates_sensors: bool,
    parameters: FlightParameters,
) -> tuple[NavigationState, Magnetometer]:
    """State and memory after a new reading. ``field``: the sample's.

    estimates_sensors: whether it may estimate the sensor errors, or only considers them.
    """
    measurement = field.measurement
    residual = measurement.residual
    since_s = magnetometer.since_reading_s + dt_s
    deviation = _deviation(magnetometer.usual, field, nav.tilt_sigma, parameters)
    disturbance = max(deviation, magnetometer.disturbance * exp(-since_s / parameters.disturbance_hold_s))
    cross_cov = cross_covariance_of(nav, measurement)
    nominal = _nominal_variance(magnetometer.innovation_power, measurement.d[0], parameters)
    normalised = abs(residual) / sqrt(cross_cov.state_variance + nominal)
    agrees = normalised < parameters.mag_gate
    power = magnetometer.innovation_power
    if agrees:
        power = averaged_power(power, square(residual), POWER_SHARE, POWER_STEP, POWER_FLOOR)
    else:
        disturbance = max(disturbance, abs(residual))
    inflated = nominal * inflation(normalised, parameters.mag_knee)
    variance = inflated + square(parameters.disturbance_weight * disturbance)
    return fuse(nav, measurement, cross_cov, variance, estimates_sensors), Magnetometer(
        sample,
        0.0,
        0.0 if agrees else magnetometer.since_accepted_s + magnetometer.since_reading_s + dt_s,
        _followed(magnetometer.usual, field, deviation < parameters.disturbance_free, since_s),
        disturbance,
        power,
        _innovation(sample, residual, cross_cov, nominal, agrees),
    )


def _nominal_variance(innovation_power: float, delay_jacobian: float, parameters: FlightParameters) -> float:
    """The variance of a reading that agrees: by the innovations, and by the jitter of its time."""
    sigma = clamp(NOISE_FACTOR * sqrt(innovation_power), parameters.mag_floor, parameters.mag_ceiling)
    return sigma * sigma + square(parameters.mag_jitter_s * delay_jacobian)


def _innovation(
    sample: ImuSample, residual: float, cross_cov: CrossCovariance, nominal: float, agrees: bool
) -> Innovation:
    """The record of a reading that was fused. The prediction is zero, so the observation is the residual."""
    fusion = Fusion.USED if agrees else Fusion.INFLATED
    variance = (cross_cov.state_variance + nominal,)
    return Innovation(Aid.MAGNETOMETER, fusion, sample.t_ns, (residual,), (residual,), variance)


def _deviation(
    usual: UsualField | None, field: LevelledField, tilt_sigma: float, parameters: FlightParameters
) -> float:
    """Deviation of strength and inclination from the usual ones beyond what is free, as a share of the field.

    The inclination may also be off by what the tilt may be off, and by the rotation during the delay's error.
    """
    if usual is None:
        return 0.0
    free = parameters.disturbance_free
    strength = max(0.0, abs(field.strength / usual.strength - 1.0) - free)
    off = abs(field.direction[2] - usual.inclination_sine)
    inclination = max(0.0, off - free - 3.0 * tilt_sigma - LAG_ERROR_S * field.rate)
    return sqrt(strength * strength + inclination * inclination)


def _followed(usual: UsualField | None, field: LevelledField, is_undisturbed: bool, since_s: float) -> UsualField:
    """The usual field after this reading."""
    sine = field.direction[2]
    if usual is None:
        return UsualField(field.strength, sine)
    if not is_undisturbed:
        return usual
    share = min(1.0, since_s / USUAL_S)
    return UsualField(
        usual.strength + share * (field.strength - usual.strength),
        usual.inclination_sine + share * (sine - usual.inclination_sine),
    )

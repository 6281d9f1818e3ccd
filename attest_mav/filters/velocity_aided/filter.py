"""Velocity-aided flight filter: the attitude of a vehicle that manoeuvres, from its velocity.

In flight the accelerometer does not show gravity, but it shows how the velocity must change if the attitude is right.
The filter integrates gyro and accelerometer and compares with the velocity fixes of the receiver; the difference is
mostly tilt, and in manoeuvres heading. The magnetometer turns the heading only as far as the velocity lets it. Each
effect of telemetry (truncation, low-pass, delays, aliasing) is corrected or estimated.

One filter serves every condition: it changes the aids that correct it, and says which (``AidingMode``).
docs/filters/velocity-aided.md has the equations, docs/measurements.md the contribution of each part. An integrated
navigation without position: Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd
ed., chapter 14.
"""

from dataclasses import dataclass, field, replace
from math import asin, isfinite, nan, pi, sqrt
from typing import Final, cast

from attest_mav.algebra import add, clamp, hypotenuse, norm, q_continuous, q_exp, q_mul, rotate, scale, square, sub
from attest_mav.filters.base import AttitudeFilter, FilterInputs, FilterState, Start
from attest_mav.filters.calibration import SensorCalibration, SensorChanges
from attest_mav.filters.velocity_aided.aids.field import FieldResidual, field_residual
from attest_mav.filters.velocity_aided.alignment.collect import accumulate, new_alignment
from attest_mav.filters.velocity_aided.alignment.initialize import first_navigation, restarted_navigation
from attest_mav.filters.velocity_aided.alignment.solve import solve_alignment
from attest_mav.filters.velocity_aided.calibration import learned
from attest_mav.filters.velocity_aided.control import navigate
from attest_mav.filters.velocity_aided.lags import low_pass_delay
from attest_mav.filters.velocity_aided.nav_state import NavigationState, body_rate
from attest_mav.filters.velocity_aided.navigation import AidingMode, Navigation
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.reading import Reading, read
from attest_mav.filters.velocity_aided.reset import (
    LONGEST_GAP_S,
    MAX_TILT_SIGMA,
    after_gap,
    is_impossible,
    is_lost,
    reset_sigma_after,
    reset_sigma_decay,
)
from attest_mav.filters.velocity_aided.state import VelocityAidedState, aligning_state
from attest_mav.plausible import is_rate
from attest_mav.samples import ImuSample
from attest_mav.types import Quat, Vec3
from attest_mav.vehicle_settings import Setting, VehicleSettings

USUAL_MAG_DELAY_S: Final = FlightParameters().mag_delay_s
"""The magnetometer's delay if nobody has set it, which a log's own takes the place of, s."""


@dataclass(frozen=True)
class VelocityAided(AttitudeFilter):
    """The filter with its parameters."""

    parameters: FlightParameters = field(default_factory=FlightParameters)
    """Noises, limits, and properties of the vehicle."""
    low_pass_from_vehicle: bool = True
    """Whether the autopilot may tell a better ``low_pass_hz``."""
    fix_delay_from_vehicle: bool = True
    """Whether the autopilot may tell a better ``fix_delay_s``."""
    calibration: SensorCalibration | None = None
    """Errors of the sensor by earlier flights, None where they are not known."""

    @property
    def name(self) -> str:
        """``velocity-aided``."""
        return "velocity-aided"

    @property
    def aligns_itself(self) -> bool:
        """True: it starts in motion too, and after a gap."""
        return True

    @property
    def uses_body_velocity(self) -> bool:
        """False: it takes the velocity in NED."""
        return False

    @property
    def default_settings(self) -> VehicleSettings:
        """The parameters that the vehicle may tell."""
        parameters = self.parameters
        return VehicleSettings(
            parameters.low_pass_hz if self.low_pass_from_vehicle else nan,
            parameters.fix_delay_s if self.fix_delay_from_vehicle else nan,
        )

    def with_vehicle_settings(self, known: VehicleSettings) -> "VelocityAided":
        """The filter with the known settings. One that navigates goes on estimating the delay from where it is."""
        parameters = self.parameters
        low_pass = self.low_pass_from_vehicle and isfinite(known.low_pass_hz)
        if low_pass:
            sigma_s = known.get_or(Setting.LOW_PASS_DELAY_SIGMA_S, 0.0)
            parameters = replace(parameters, low_pass_delay_sigma=sigma_s)
        fix_delay = self.fix_delay_from_vehicle and isfinite(known.fix_delay_s)
        mag_delay_s = parameters.mag_delay_s
        is_usual = mag_delay_s == USUAL_MAG_DELAY_S
        informed = replace(
            parameters,
            low_pass_hz=known.low_pass_hz if low_pass else parameters.low_pass_hz,
            fix_delay_s=known.fix_delay_s if fix_delay else parameters.fix_delay_s,
            mag_delay_s=known.get_or(Setting.FIELD_DELAY_S, mag_delay_s) if is_usual else mag_delay_s,
        )
        return replace(self, parameters=informed)

    def with_calibration(self, known: SensorCalibration | None) -> "VelocityAided":
        """The filter that begins with these errors of its sensor, with None those of any sensor."""
        return replace(self, calibration=known)

    def after_changes(self, state: FilterState, changes: SensorChanges) -> FilterState:
        """See ``AttitudeFilter``; one that aligns after a gap keeps the errors for its restart."""
        before = cast("VelocityAidedState", state)
        if before.navigation is None:
            return state
        return before.with_navigation(before.navigation.after_changes(changes, self.parameters))

    def learned(self, state: FilterState) -> SensorCalibration | None:
        """The errors of the sensor as the flight has shown them; None while the filter aligns, and before that."""
        navigation = cast("VelocityAidedState", state).navigation
        if navigation is None or not state.aligned:
            return None
        return learned(navigation.estimate, navigation.begun_with, self.parameters)

    def valid(self, state: FilterState) -> bool:
        """True while the tilt is known well enough to judge others by it."""
        return state.tilt_sigma < self.parameters.valid_tilt

    def initial(self, start: Start) -> VelocityAidedState:
        """Begin to align. The start's attitude is only shown until the filter has its own; its bias is taken."""
        return VelocityAidedState(start.q_nb, start.gyro_bias, False, False, pi, pi, None, None, 0.0, False, 0.0)

    def step(self, state: FilterState, dt_s: float, sample: ImuSample, inputs: FilterInputs) -> VelocityAidedState:
        """One step; ``dt_s`` may be of any length: after too long a one alignment begins again."""
        before = cast("VelocityAidedState", state)
        if not (is_rate(sample.gyro) and dt_s > 0.0):
            return before
        parameters = self.parameters
        navigation = before.navigation
        if navigation is None:
            reading = read(sample, (0.0, 0.0, -parameters.gravity))
            return self._align(before, None, reading, sample, inputs, dt_s)
        navigation = navigation.with_declination(inputs.declination, parameters)
        reading = read(sample, navigation.imu.accel)
        if before.alignment is not None or is_lost(dt_s, inputs):
            return self._align(before, navigation, reading, sample, inputs, dt_s)
        navigation = navigate(after_gap(navigation, dt_s, inputs), reading, sample, inputs, dt_s, parameters)
        navigation = navigation.without_refuted_calibration(parameters)
        nav = navigation.estimate
        if not nav.is_valid:
            start = new_alignment(reading, sample.t_ns)
            return aligning_state(before.q_nb, (0.0, 0.0, 0.0), start, None, 0.0, False, 0.0)
        contradicted = navigation.gnss.mean_nis > parameters.restart_nis or is_impossible(navigation)
        if contradicted or nav.tilt_sigma > MAX_TILT_SIGMA:
            # The velocity contradicts the attitude for too long, or too much was hidden by a saturated sensor.
            start = new_alignment(reading, sample.t_ns)
            sigma = before.reset_sigma
            return aligning_state(before.q_nb, nav.gyro_bias, start, navigation, 0.0, contradicted, sigma)
        return self._navigating(navigation, before.q_nb, reset_sigma_decay(navigation, dt_s) * before.reset_sigma)

    def with_estimate(
        self, state: VelocityAidedState, estimate: NavigationState, is_same_sensor: bool = True
    ) -> VelocityAidedState:
        """An aligned state with another estimate in it, as a hypothesis about the past is run again from.

        is_same_sensor: whether it is of the sensor that the state is of.
        """
        navigation = state.navigation
        if navigation is None or state.alignment is not None:
            return state
        changed = navigation.with_estimate(estimate, is_same_sensor)
        return self._navigating(changed, state.q_nb, state.reset_sigma)

    def field_residual(self, state: VelocityAidedState, sample: ImuSample, reference: Vec3) -> FieldResidual | None:
        """The whole residual of the sample's magnetic field, for the state after that sample.

        reference: the field's usual direction, unit vector in NED. None while the filter aligns, or without a field.
        """
        navigation = state.navigation
        if navigation is None or state.alignment is not None:
            return None
        return field_residual(navigation.estimate, navigation.imu.gyro, sample, reference)

    def _align(
        self,
        before: VelocityAidedState,
        navigation: Navigation | None,
        reading: Reading,
        sample: ImuSample,
        inputs: FilterInputs,
        dt_s: float,
    ) -> VelocityAidedState:
        """One sample more for the alignment, or its end."""
        parameters = self.parameters
        alignment = before.alignment
        if alignment is None or is_lost(dt_s, inputs) or sample.saturated or alignment.began_saturated:
            alignment = new_alignment(reading, sample.t_ns)
        else:
            alignment = accumulate(alignment, reading, sample, inputs, before.gyro_bias, dt_s, parameters)
        declination, inclination = _field_angles(navigation, inputs)
        initial = solve_alignment(alignment, declination, inclination, parameters)
        gap_s = before.gap_s + dt_s
        by_innovations = before.reset_by_innovations and not is_lost(dt_s, inputs)
        if initial is None:
            turn = scale(sub(reading.gyro, before.gyro_bias), 0.5 * min(dt_s, LONGEST_GAP_S))
            q_nb = q_mul(before.q_nb, q_exp(turn))
            sigma = before.reset_sigma
            return aligning_state(q_nb, before.gyro_bias, alignment, navigation, gap_s, by_innovations, sigma)
        if navigation is None:
            bias, known = before.gyro_bias, self.calibration
            begun = first_navigation(initial, reading, sample.t_ns, bias, inputs.declination, parameters, known)
        else:
            begun = restarted_navigation(initial, navigation, reading, sample.t_ns, gap_s, parameters)
        earlier = navigation.estimate if navigation is not None and by_innovations else None
        sigma = reset_sigma_after(before.reset_sigma, initial.method, begun.estimate, before.q_nb, earlier)
        return self._navigating(begun, before.q_nb, sigma)

    def _navigating(self, navigation: Navigation, previous: Quat, reset_sigma: float) -> VelocityAidedState:
        """The state that shows this estimate: the attitude now, not the one that the low-passed sensors see."""
        nav = navigation.estimate
        rate = body_rate(nav, navigation.imu.gyro)
        low_pass = low_pass_delay(nav, navigation.imu.dt_s, self.parameters)
        lag_s, acceleration = low_pass.delay_s, navigation.imu.angular_acceleration
        # A second-order low-pass with the delay L is behind by exactly L w + L^2/2 dw/dt, both as it shows them.
        behind = add(scale(rate, lag_s), scale(acceleration, 0.5 * lag_s * lag_s))
        q_nb = q_mul(nav.q_nb, q_exp(scale(behind, 0.5)))
        # One that is only assumed leaves the attitude uncertain along the rotation.
        by_lag = add(rate, scale(acceleration, lag_s))
        lag_x, lag_y, lag_z = scale(rotate(q_nb, by_lag), low_pass.sigma_s)
        tilt_variance = square(nav.tilt_sigma) + square(reset_sigma) + square(lag_x) + square(lag_y)
        return VelocityAidedState(
            q_continuous(q_nb, previous),
            nav.gyro_bias,
            navigation.mode == AidingMode.GRAVITY,
            navigation.magnetometer.used,
            sqrt(tilt_variance),
            hypotenuse(norm((nav.heading_sigma, reset_sigma, lag_z)), navigation.unshown_iron_sigma),
            None,
            navigation,
            0.0,
            False,
            reset_sigma,
        )


def _field_angles(navigation: Navigation | None, inputs: FilterInputs) -> tuple[float, float]:
    """Declination and inclination of the field for an alignment, rad; inclination NaN where it is not known."""
    inclination = inputs.inclination
    if navigation is None:
        return inputs.declination if isfinite(inputs.declination) else 0.0, inclination
    usual = navigation.magnetometer.usual
    if not isfinite(inclination) and usual is not None:
        inclination = asin(clamp(usual.inclination_sine, -1.0, 1.0))
    return navigation.assumed_declination + navigation.estimate.declination_error, inclination

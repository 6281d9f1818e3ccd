"""Velocity-aided flight filter: the attitude of a vehicle that manoeuvres, from its velocity.

In flight the accelerometer does not show gravity, but it shows how the velocity must change if the attitude is right.
The filter integrates gyro and accelerometer and compares with the velocity fixes of the receiver; what disagrees is
mostly tilt, and in manoeuvres heading. The magnetometer turns the heading only as far as the velocity lets it. What
telemetry does to the signals (truncation, low-pass, delays, aliasing) is undone or estimated.

One filter serves every condition: it changes the rows that correct it, and says which (``Aid``).
docs/filters/velocity-aided.md has the equations, docs/measurements.md the contribution of each part.
"""

from dataclasses import dataclass, field, replace
from math import asin, exp, hypot, isfinite, nan, pi
from typing import Final, cast

from attest_mav.algebra import (
    clamp,
    heading_between,
    is_finite,
    norm,
    q_continuous,
    q_exp,
    q_mul,
    scale,
    sub,
    tilt_between,
)
from attest_mav.filters.base import AttitudeFilter, FilterInputs, FilterState, Start
from attest_mav.filters.velocity_aided.aids.gnss_velocity import low_pass_delay_s
from attest_mav.filters.velocity_aided.aids.magnetometer import field_of
from attest_mav.filters.velocity_aided.alignment.collect import Alignment, accumulate, new_alignment
from attest_mav.filters.velocity_aided.alignment.initialize import initialize, with_declination
from attest_mav.filters.velocity_aided.alignment.solve import ASSUMED_GRAVITY_TILT, AlignmentMethod, solve_alignment
from attest_mav.filters.velocity_aided.control import AidingMode, Navigation, has_wing_airspeed, navigate
from attest_mav.filters.velocity_aided.nav_state import NavigationState, body_rate, is_sound
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.prediction import MAX_RATE, Reading, read
from attest_mav.filters.velocity_aided.state import VelocityAidedState
from attest_mav.types import ImuSample, Quat, Vec3, VehicleSettings

LONGEST_STEP_S: Final = 1.0
"""After a longer gap the attitude is lost, and alignment begins again."""
MAX_TILT_SIGMA: Final = 0.6
"""rad: with a tilt less certain than this the rows are not linear in the error any more, and lead astray."""
RESET_SIGMA_S: Final = 10.0
"""When fixes contradict an attitude and make another one of their own, either may be wrong: a receiver can freeze. The
difference is doubt, which fades with this time constant while the fixes agree with what they made. An attitude that
was guessed in motion begins with doubt too."""
RESET_SIGMA_GRAVITY_S: Final = 60.0
"""The same while the mean specific force is all there is: it takes some turns until their accelerations cancel."""


def _reset_sigma_decay(navigation: Navigation, dt_s: float) -> float:
    """The share of the doubt that is left after a step."""
    if navigation.gnss.mean_nis >= 1.0 or navigation.mode == AidingMode.AIRSPEED:
        # A wing's air speed holds an attitude, but does not find one: circling, it agrees with a wrong one for minutes.
        return 1.0
    return exp(-dt_s / (RESET_SIGMA_GRAVITY_S if navigation.mode == AidingMode.GRAVITY else RESET_SIGMA_S))


def _attitude_jump(after: NavigationState, carried: Quat, before: NavigationState) -> float:
    """How far a new attitude is from the old one carried on, rad; 0 while the old one's own sigmas explain it."""
    tilt, heading = tilt_between(after.q_nb, carried), abs(heading_between(after.q_nb, carried))
    explained = tilt < 3.0 * before.tilt_sigma and heading < 3.0 * before.heading_sigma
    return 0.0 if explained else max(tilt, heading)


@dataclass(frozen=True)
class VelocityAided(AttitudeFilter):
    """The filter with its parameters.

    low_pass_from_vehicle, fix_delay_from_vehicle: whether the autopilot may tell better ones.
    """

    parameters: FlightParameters = field(default_factory=FlightParameters)
    low_pass_from_vehicle: bool = True
    fix_delay_from_vehicle: bool = True

    @property
    def name(self) -> str:
        """``velocity-aided``."""
        return "velocity-aided"

    @property
    def aligns_itself(self) -> bool:
        """True: it starts in motion too, and after a gap."""
        return True

    @property
    def default_settings(self) -> VehicleSettings:
        """The parameters that are open."""
        parameters = self.parameters
        return VehicleSettings(
            parameters.low_pass_hz if self.low_pass_from_vehicle else nan,
            parameters.fix_delay_s if self.fix_delay_from_vehicle else nan,
        )

    def with_vehicle_settings(self, known_settings: VehicleSettings) -> "VelocityAided":
        """The filter with the facts in its open parameters. One that flies estimates the delay from where it is."""
        parameters = self.parameters
        low_pass = self.low_pass_from_vehicle and isfinite(known_settings.low_pass_hz)
        fix_delay = self.fix_delay_from_vehicle and isfinite(known_settings.fix_delay_s)
        known = replace(
            parameters,
            low_pass_hz=known_settings.low_pass_hz if low_pass else parameters.low_pass_hz,
            fix_delay_s=known_settings.fix_delay_s if fix_delay else parameters.fix_delay_s,
        )
        return VelocityAided(known, self.low_pass_from_vehicle, self.fix_delay_from_vehicle)

    def valid(self, state: FilterState) -> bool:
        """True while the tilt is known well enough to judge others by it."""
        return state.tilt_sigma < self.parameters.valid_tilt

    def initial(self, start: Start) -> VelocityAidedState:
        """Begin to align. The start's attitude is only shown until the filter has its own; its bias is taken."""
        return VelocityAidedState(start.q_nb, start.gyro_bias, False, False, pi, pi, None, None, 0.0, False, 0.0)

    def step(self, state: FilterState, dt_s: float, sample: ImuSample, inputs: FilterInputs) -> VelocityAidedState:
        """One step; ``dt_s`` may be longer than 1 s: then alignment begins again."""
        before = cast("VelocityAidedState", state)
        if not (is_finite(sample.gyro) and norm(sample.gyro) < MAX_RATE and dt_s > 0.0):
            return before
        parameters = self.parameters
        navigation = before.navigation
        if navigation is None:
            reading = read(sample, (0.0, 0.0, -parameters.gravity))
            return self._align(before, None, reading, sample, inputs, dt_s)
        navigation = with_declination(navigation, inputs.declination, parameters)
        reading = read(sample, navigation.imu.accel)
        if before.alignment is not None or dt_s > LONGEST_STEP_S:
            return self._align(before, navigation, reading, sample, inputs, dt_s)
        navigation = navigate(navigation, reading, sample, inputs, dt_s, parameters)
        if not is_sound(navigation.estimate):
            return self._not_aligned(
                before.q_nb, (0.0, 0.0, 0.0), new_alignment(reading, sample.t_ns), None, 0.0, False, 0.0
            )
        reset_by_innovations = navigation.gnss.mean_nis > parameters.restart_nis
        if reset_by_innovations or navigation.estimate.tilt_sigma > MAX_TILT_SIGMA:
            # The velocity contradicts the attitude for too long, or too much was hidden by a saturated sensor.
            bias, begun = navigation.estimate.gyro_bias, new_alignment(reading, sample.t_ns)
            return self._not_aligned(
                before.q_nb, bias, begun, navigation, 0.0, reset_by_innovations, before.reset_sigma
            )
        return self._navigating(navigation, before.q_nb, _reset_sigma_decay(navigation, dt_s) * before.reset_sigma)

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
        bias = before.gyro_bias
        alignment = before.alignment
        reset_by_innovations = before.reset_by_innovations and dt_s <= LONGEST_STEP_S
        if alignment is None or dt_s > LONGEST_STEP_S or sample.saturated or alignment.began_saturated:
            alignment = new_alignment(reading, sample.t_ns)
        else:
            new = field_of(sample) if sample.mag != alignment.last_mag else None
            fix = inputs.velocity
            flies = not inputs.zero_mean_velocity and has_wing_airspeed(inputs)
            alignment = accumulate(alignment, reading, sample.mag, new, fix, flies, bias, dt_s, sample.t_ns, parameters)
        inclination = inputs.inclination
        if not isfinite(inclination) and navigation is not None:
            inclination = asin(clamp(navigation.magnetometer.usual_inclination_sine, -1.0, 1.0))
        declination = inputs.declination if isfinite(inputs.declination) else 0.0
        if navigation is not None:
            declination = navigation.declination + navigation.estimate.delays[2]
        initial = solve_alignment(alignment, declination, inclination, parameters)
        gap_s = before.gap_s + dt_s
        if initial is None:
            rotation = scale(sub(reading.gyro, bias), 0.5 * min(dt_s, LONGEST_STEP_S))
            q_nb = q_mul(before.q_nb, q_exp(rotation))
            return self._not_aligned(q_nb, bias, alignment, navigation, gap_s, reset_by_innovations, before.reset_sigma)
        begun = initialize(initial, navigation, reading, sample.t_ns, bias, inputs.declination, gap_s, parameters)
        reset_sigma = (
            max(before.reset_sigma, ASSUMED_GRAVITY_TILT)
            if initial.method == AlignmentMethod.ASSUMED_GRAVITY
            else before.reset_sigma
        )
        if reset_by_innovations and navigation is not None:
            reset_sigma = max(reset_sigma, _attitude_jump(begun.estimate, before.q_nb, navigation.estimate))
        return self._navigating(begun, before.q_nb, reset_sigma)

    def _not_aligned(
        self,
        q_nb: Quat,
        bias: Vec3,
        alignment: Alignment,
        navigation: Navigation | None,
        gap_s: float,
        reset_by_innovations: bool,
        reset_sigma: float,
    ) -> VelocityAidedState:
        """The state of an alignment that is not over."""
        return VelocityAidedState(
            q_nb, bias, False, False, pi, pi, alignment, navigation, gap_s, reset_by_innovations, reset_sigma
        )

    def _navigating(self, navigation: Navigation, previous: Quat, reset_sigma: float) -> VelocityAidedState:
        """The state that shows this estimate: the attitude now, not the one that the low-passed sensors see."""
        nav = navigation.estimate
        rate = body_rate(nav, navigation.imu.gyro)
        q_nb = q_mul(nav.q_nb, q_exp(scale(rate, 0.5 * low_pass_delay_s(self.parameters))))
        return VelocityAidedState(
            q_continuous(q_nb, previous),
            nav.gyro_bias,
            navigation.mode == AidingMode.GRAVITY,
            navigation.magnetometer.used,
            hypot(nav.tilt_sigma, reset_sigma),
            hypot(nav.heading_sigma, reset_sigma),
            None,
            navigation,
            0.0,
            False,
            reset_sigma,
        )

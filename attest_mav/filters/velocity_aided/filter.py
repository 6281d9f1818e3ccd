"""Velocity-aided flight filter: the attitude of a vehicle that manoeuvres, from its velocity.

In flight the accelerometer does not show gravity, but it shows how the velocity must change if the attitude is right.
The filter integrates gyro and accelerometer and compares with the velocity fixes of the receiver; what disagrees is
mostly tilt, and in manoeuvres heading. The magnetometer turns the heading only as far as the velocity lets it. What
telemetry does to the signals (truncation, low-pass, delays, aliasing) is undone or estimated.

One filter serves every condition: it changes the rows that correct it, and says which (``Aid``).
docs/flight.md has the equations, and what each part is worth.
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
from attest_mav.filters.velocity_aided.alignment.collect import Alignment, continued, started
from attest_mav.filters.velocity_aided.alignment.initialize import beginning, redeclined
from attest_mav.filters.velocity_aided.alignment.solve import GUESSED_TILT, Basis, outcome
from attest_mav.filters.velocity_aided.control import Aid, Flying, flown, is_wing_flying
from attest_mav.filters.velocity_aided.nav_state import Motion, is_sound, rate_of
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.prediction import MAX_RATE, Reading, read
from attest_mav.filters.velocity_aided.state import VelocityAidedState
from attest_mav.types import ImuSample, Quat, Vec3, VehicleSettings

LONGEST_STEP_S: Final = 1.0
"""After a longer gap the attitude is lost, and alignment begins again."""
TILT_LOST: Final = 0.6
"""rad: with a tilt less certain than this the rows are not linear in the error any more, and lead astray."""
DOUBT_S: Final = 10.0
"""When fixes contradict an attitude and make another one of their own, either may be wrong: a receiver can freeze. The
difference is doubt, which fades with this time constant while the fixes agree with what they made. An attitude that
was guessed in motion begins with doubt too."""
GRAVITY_DOUBT_S: Final = 60.0
"""The same while the mean specific force is all there is: it takes some turns until their accelerations cancel."""


def _kept_doubt(flying: Flying, dt_s: float) -> float:
    """The share of the doubt that is left after a step."""
    if flying.fixes.mean_nis >= 1.0 or flying.aid == Aid.AIRSPEED:
        # A wing's air speed holds an attitude, but does not find one: circling, it agrees with a wrong one for minutes.
        return 1.0
    return exp(-dt_s / (GRAVITY_DOUBT_S if flying.aid == Aid.GRAVITY else DOUBT_S))


def _contradiction(after: Motion, carried: Quat, before: Motion) -> float:
    """How far a new attitude is from the old one carried on, rad; 0 while the old one's own sigmas explain it."""
    tilt, heading = tilt_between(after.q_nb, carried), abs(heading_between(after.q_nb, carried))
    explained = tilt < 3.0 * before.tilt_sigma and heading < 3.0 * before.heading_sigma
    return 0.0 if explained else max(tilt, heading)


@dataclass(frozen=True)
class VelocityAided(AttitudeFilter):
    """The filter with its parameters. low_pass_open, fix_delay_open: whether the autopilot may tell better ones."""

    parameters: FlightParameters = field(default_factory=FlightParameters)
    low_pass_open: bool = True
    fix_delay_open: bool = True

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
        settings = self.parameters
        return VehicleSettings(
            settings.low_pass_hz if self.low_pass_open else nan, settings.fix_delay_s if self.fix_delay_open else nan
        )

    def with_vehicle_settings(self, facts: VehicleSettings) -> "VelocityAided":
        """The filter with the facts in its open parameters. One that flies estimates the delay from where it is."""
        settings = self.parameters
        low_pass = self.low_pass_open and isfinite(facts.low_pass_hz)
        fix_delay = self.fix_delay_open and isfinite(facts.fix_delay_s)
        known = replace(
            settings,
            low_pass_hz=facts.low_pass_hz if low_pass else settings.low_pass_hz,
            fix_delay_s=facts.fix_delay_s if fix_delay else settings.fix_delay_s,
        )
        return VelocityAided(known, self.low_pass_open, self.fix_delay_open)

    def valid(self, state: FilterState) -> bool:
        """True while the tilt is known well enough to judge others by it."""
        return state.tilt_sigma < self.parameters.valid_tilt

    def initial(self, start: Start) -> VelocityAidedState:
        """Begin to align. The start's attitude is only shown until the filter has its own; its bias is taken."""
        return VelocityAidedState(start.q_nb, start.gyro_bias, False, False, pi, pi, None, None, 0.0, False, 0.0)

    def step(self, state: FilterState, dt_s: float, sample: ImuSample, aids: FilterInputs) -> VelocityAidedState:
        """One step; ``dt_s`` may be longer than 1 s: then alignment begins again."""
        before = cast("VelocityAidedState", state)
        if not (is_finite(sample.gyro) and norm(sample.gyro) < MAX_RATE and dt_s > 0.0):
            return before
        settings = self.parameters
        flying = before.flying
        if flying is None:
            reading = read(sample, (0.0, 0.0, -settings.gravity))
            return self._aligning(before, None, reading, sample, aids, dt_s)
        flying = redeclined(flying, aids.declination, settings)
        reading = read(sample, flying.strapdown.accel)
        if before.alignment is not None or dt_s > LONGEST_STEP_S:
            return self._aligning(before, flying, reading, sample, aids, dt_s)
        flying = flown(flying, reading, sample, aids, dt_s, settings)
        if not is_sound(flying.motion):
            return self._waiting(before.q_nb, (0.0, 0.0, 0.0), started(reading, sample.t_ns), None, 0.0, False, 0.0)
        contested = flying.fixes.mean_nis > settings.restart_nis
        if contested or flying.motion.tilt_sigma > TILT_LOST:
            # The velocity contradicts the attitude for too long, or too much was hidden by a saturated sensor.
            bias, begun = flying.motion.gyro_bias, started(reading, sample.t_ns)
            return self._waiting(before.q_nb, bias, begun, flying, 0.0, contested, before.doubt)
        return self._shown(flying, before.q_nb, _kept_doubt(flying, dt_s) * before.doubt)

    def _aligning(
        self,
        before: VelocityAidedState,
        flying: Flying | None,
        reading: Reading,
        sample: ImuSample,
        aids: FilterInputs,
        dt_s: float,
    ) -> VelocityAidedState:
        """One sample more for the alignment, or its end."""
        settings = self.parameters
        bias = before.gyro_bias
        so_far = before.alignment
        contested = before.contested and dt_s <= LONGEST_STEP_S
        if so_far is None or dt_s > LONGEST_STEP_S or sample.saturated or so_far.saturated:
            so_far = started(reading, sample.t_ns)
        else:
            new = field_of(sample) if sample.mag != so_far.mag else None
            fix = aids.velocity
            flies = not aids.zero_mean_velocity and is_wing_flying(aids)
            so_far = continued(so_far, reading, sample.mag, new, fix, flies, bias, dt_s, sample.t_ns, settings)
        dip = aids.inclination
        if not isfinite(dip) and flying is not None:
            dip = asin(clamp(flying.compass.dip, -1.0, 1.0))
        declination = aids.declination if isfinite(aids.declination) else 0.0
        if flying is not None:
            declination = flying.declination + flying.motion.delays[2]
        begin = outcome(so_far, declination, dip, settings)
        gap_s = before.gap_s + dt_s
        if begin is None:
            turn = scale(sub(reading.gyro, bias), 0.5 * min(dt_s, LONGEST_STEP_S))
            q_nb = q_mul(before.q_nb, q_exp(turn))
            return self._waiting(q_nb, bias, so_far, flying, gap_s, contested, before.doubt)
        begun = beginning(begin, flying, reading, sample.t_ns, bias, aids.declination, gap_s, settings)
        doubt = max(before.doubt, GUESSED_TILT) if begin.basis == Basis.GUESS else before.doubt
        if contested and flying is not None:
            doubt = max(doubt, _contradiction(begun.motion, before.q_nb, flying.motion))
        return self._shown(begun, before.q_nb, doubt)

    def _waiting(
        self,
        q_nb: Quat,
        bias: Vec3,
        so_far: Alignment,
        flying: Flying | None,
        gap_s: float,
        contested: bool,
        doubt: float,
    ) -> VelocityAidedState:
        """The state of an alignment that is not over."""
        return VelocityAidedState(q_nb, bias, False, False, pi, pi, so_far, flying, gap_s, contested, doubt)

    def _shown(self, flying: Flying, previous: Quat, doubt: float) -> VelocityAidedState:
        """The state that shows this estimate: the attitude now, not the one that the low-passed sensors see."""
        motion = flying.motion
        rate = rate_of(motion, flying.strapdown.gyro)
        q_nb = q_mul(motion.q_nb, q_exp(scale(rate, 0.5 * low_pass_delay_s(self.parameters))))
        return VelocityAidedState(
            q_continuous(q_nb, previous),
            motion.gyro_bias,
            flying.aid == Aid.GRAVITY,
            flying.compass.used,
            hypot(motion.tilt_sigma, doubt),
            hypot(motion.heading_sigma, doubt),
            None,
            flying,
            0.0,
            False,
            doubt,
        )

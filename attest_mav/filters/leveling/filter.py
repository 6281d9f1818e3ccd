"""Leveling extended Kalman filter: roll and pitch of a vehicle that moves, from its speed (paper 3).

The velocity tells gravity from acceleration: the filter integrates the accelerometer and compares the result with a
measured forward speed, or with zero when the vehicle stands. The filter therefore levels in turns, where one that
takes the accelerometer for gravity leans with the vehicle, and from any start, in motion too. A vehicle is assumed to
move along its nose; for one that moves sideways the inputs must give that speed (``BodyVelocity.side``).

The heading is kept as the north direction in the body: the gyro turns this vector, the magnetometer corrects it.
docs/filters/leveling.md has the equations as mended.
"""

from dataclasses import dataclass
from math import ceil, isnan, nan, pi
from typing import Final, cast

from attest_mav.algebra import (
    down_in_body,
    mat_vec,
    norm,
    q_continuous,
    q_from_matrix,
    q_to_matrix,
    scale,
    sub,
)
from attest_mav.filters.base import (
    MAX_CORRECTION_DT_S,
    AttitudeFilter,
    FilterInputs,
    FilterState,
    Start,
)
from attest_mav.filters.leveling.model import LevelState, is_sound, predicted, with_variance_floor
from attest_mav.filters.leveling.north import (
    NorthVector,
    direction,
    earth_rate,
    heading_error,
    level_axes,
    made_level,
    north_from_heading,
    turned_east,
)
from attest_mav.filters.leveling.state import LengthFusion, LevelingState, VelocityFusion, VelocityModel, unchanged
from attest_mav.filters.leveling.update import constrain_length, fuse_speed, hold_velocity, lateral_velocity
from attest_mav.filters.parameter_check import check_parameters
from attest_mav.innovation import Fusion
from attest_mav.matrices import axes_turn, diagonal, largest_variance
from attest_mav.plausible import MAX_SPEED, is_force, is_heading, is_rate
from attest_mav.samples import ImuSample
from attest_mav.types import G_MPS2, NO_TIME, North, Vec3

LONGEST_STEP_S: Final = 0.1
"""A longer step is taken in parts of ``PART_S`` at most, s."""
PART_S: Final = 0.02
"""s."""
LEVEL_FOUND: Final = 0.05
"""Standard deviation of the components of the down vector below which the attitude counts as found."""
SATURATION_NOISE: Final = 10.0
"""The process noise of a step with a saturated sensor is this many times the usual."""
BLIND_NOISE: Final = 1.0
"""(m/s)^2/s: the noise of the velocity while the accelerometer cannot be read."""


_POSITIVE: Final = (
    "r_speed",
    "r_sideslip",
    "r_stationary",
    "r_unaided",
    "r_length_start",
    "r_length",
    "heading_time_s",
    "r_heading",
    "gravity",
)
"""Parameters that are not zero either."""


@dataclass(frozen=True)
class Leveling(AttitudeFilter):
    """Parameters; the defaults are for MEMS sensors. Variances are per component."""

    q_velocity: float = 1e-3
    """(m/s)^2/s. Process noise of the velocity; too small trusts a biased accelerometer."""
    q_down: float = 1e-5
    """1/s. Process noise of the down vector; too small keeps the gyro's drift."""
    r_speed: float = 0.01
    """(m/s)^2. Variance of a forward speed."""
    r_sideslip: float = 0.09
    """(m/s)^2. Variance of the velocity sideways and downwards in the body; infinite: not used."""
    r_stationary: float = 1e-4
    """(m/s)^2. Variance of the velocity of a standing vehicle."""
    r_unaided: float = 1e3
    """(m/s)^2. Variance about the last velocity of a vehicle without a speed: large, since many measurements see the
    same motion; infinite: no constraint."""
    r_length_start: float = 0.7
    """1. Variance of the squared length of the down vector before the level is found."""
    r_length: float = 0.1
    """1. The same afterwards."""
    spacing_s: float = 0.05
    """s. Time between measurements without a reading (kept velocity, unit length)."""
    p0_velocity: float = 1.0
    """(m/s)^2. Variance of the velocity at the start."""
    p0_down: float = 0.05
    """1. Variance of the down vector at the start of a vehicle at rest."""
    p0_down_moving: float = 1.0
    """1. The same of a vehicle that did not rest."""
    heading_time_s: float = 5.0
    """s. Time constant with which the heading follows the magnetometer."""
    heading_noise: float = 1e-5
    """rad^2/s. Growth of the heading's variance."""
    r_heading: float = 2.7e-3
    """rad^2. Variance of one magnetic heading."""
    gravity: float = G_MPS2
    """m/s^2. Local gravity."""

    def __post_init__(self) -> None:
        """Refuse parameters that make no sense."""
        check_parameters(self, positive=_POSITIVE)

    @property
    def name(self) -> str:
        """``leveling``."""
        return "leveling"

    def initial(self, start: Start) -> LevelingState:
        """Start from the alignment's down direction and heading, at an unknown speed."""
        axes = q_to_matrix(start.q_nb)
        p0_down = self.p0_down if start.at_rest else self.p0_down_moving
        level = LevelState((0.0, 0.0, 0.0), axes[2], diagonal(self.p0_velocity), diagonal(0.0), diagonal(p0_down))
        # In motion the heading of the alignment is levelled by a down direction that may be far off.
        known = start.at_rest and start.north != North.RELATIVE
        north = NorthVector(axes[0], self.r_heading, known)
        model = VelocityModel(False, False, (0.0, 0.0, 0.0))
        return LevelingState(
            start.q_nb, start.gyro_bias, False, False, level, north, model, self.spacing_s, NO_TIME, None, None
        )

    def step(self, state: FilterState, dt_s: float, sample: ImuSample, inputs: FilterInputs) -> LevelingState:
        """Predict with the inertial sample, correct with the velocity as far as it is known, then turn the heading.

        Without a usable gyro the state stays as it is.
        """
        before = cast("LevelingState", state)
        gyro = sub(sample.gyro, before.gyro_bias)
        if not is_rate(gyro):
            return unchanged(before)
        was_down = down_in_body(before.q_nb)
        earth = earth_rate(before.north, was_down, inputs.latitude, inputs.declination)
        accel_usable = is_force(sample.accel) and norm(sample.accel) > 0.0
        x = self._predict(before.level, gyro, earth, dt_s, sample, accel_usable)
        since_update_s = before.since_update_s + dt_s
        due = since_update_s > self.spacing_s - 0.5 * dt_s
        x, model, velocity = self._measure_velocity(x, before.velocity_model, inputs, due)
        found = largest_variance(x.p_dd) < LEVEL_FOUND * LEVEL_FOUND
        length: LengthFusion | None = None
        if due:
            x, length = constrain_length(x, self.r_length if found else self.r_length_start)
        down = direction(x.down, was_down)
        turned = made_level(mat_vec(axes_turn(scale(sub(gyro, earth), dt_s)), before.north.direction), down)
        north = self._follow_field(before.north, turned, down, found, dt_s, sample, inputs)
        q = q_continuous(q_from_matrix(level_axes(north.direction, down)), before.q_nb)
        if not is_sound(x):
            q = (nan, nan, nan, nan)  # which asks for a new start
        return LevelingState(
            q,
            before.gyro_bias,
            accel_usable,
            north.from_field,
            with_variance_floor(x),
            north,
            model,
            0.0 if due else since_update_s,
            sample.t_ns,
            velocity,
            length,
        )

    def _predict(
        self, x: LevelState, gyro: Vec3, earth_rate_b: Vec3, dt_s: float, sample: ImuSample, accel_usable: bool
    ) -> LevelState:
        """x after dt_s. Without an accelerometer the vehicle is assumed to move evenly, with a wide margin."""
        accel = sample.accel if accel_usable else scale(x.down, -self.gravity)
        noise_factor = SATURATION_NOISE if sample.saturated else 1.0
        q_velocity = noise_factor * self.q_velocity if accel_usable else BLIND_NOISE
        noise = (q_velocity, noise_factor * self.q_down)
        parts = 1 if dt_s <= LONGEST_STEP_S else ceil(dt_s / PART_S)
        part_s = dt_s / parts
        for _ in range(parts):
            x = predicted(x, gyro, earth_rate_b, accel, self.gravity, part_s, noise)
        return x

    def _measure_velocity(
        self, x: LevelState, before: VelocityModel, inputs: FilterInputs, due: bool
    ) -> tuple[LevelState, VelocityModel, VelocityFusion | None]:
        """x after the measurements of the model in use, that model, and the record."""
        if inputs.stationary:
            if not before.stationary:
                x = self._with_restarted_velocity(x, (0.0, 0.0, 0.0))
            return hold_velocity(x, VelocityModel(True, False, (0.0, 0.0, 0.0)), self.r_stationary, due)
        velocity = inputs.body_velocity
        if velocity is None or not abs(velocity.forward) < MAX_SPEED:
            return hold_velocity(x, VelocityModel(False, False, before.velocity), self.r_unaided, due)
        if not velocity.is_new:
            return (x, VelocityModel(False, before.moving, before.velocity), None)
        if not before.moving:
            x = self._with_restarted_velocity(x, (velocity.forward, *lateral_velocity(velocity)))
        x, fusion = fuse_speed(x, velocity, self.r_speed, self.r_sideslip)
        return (x, VelocityModel(False, True, x.velocity), fusion)

    def _with_restarted_velocity(self, x: LevelState, velocity: Vec3) -> LevelState:
        """x with its velocity started anew.

        The wind that the speed sensor of a standing vehicle showed, or the velocity that a moving one had gathered,
        must not be levered into the attitude when the model changes.
        """
        return LevelState(velocity, x.down, diagonal(self.p0_velocity), diagonal(0.0), x.p_dd)

    def _follow_field(
        self,
        before: NorthVector,
        north: Vec3,
        down: Vec3,
        found: bool,
        dt_s: float,
        sample: ImuSample,
        inputs: FilterInputs,
    ) -> NorthVector:
        """The heading after this sample: as supplied, or drawn to the magnetometer, or as the gyro turned it.

        One that was not known becomes the magnetometer's, until the level is found and it counts as known.
        """
        heading = inputs.heading
        if heading is not None and is_heading(heading):
            return NorthVector(north_from_heading(heading, down, north), self.r_heading, True, Fusion.USED)
        variance = before.variance + self.heading_noise * dt_s
        error = heading_error(north, down, sample.field) if sample.has_field else nan
        if isnan(error):
            return before.turned(north, min(variance, pi * pi), Fusion.IMPLAUSIBLE if sample.has_field else None)
        innovation_variance = variance + self.r_heading
        gain = min(dt_s, MAX_CORRECTION_DT_S) / self.heading_time_s if before.known else 1.0
        variance = (1.0 - gain) * (1.0 - gain) * variance + gain * gain * self.r_heading
        known = before.known or found
        return NorthVector(
            turned_east(north, down, gain * error), variance, known, Fusion.USED, -error, innovation_variance
        )

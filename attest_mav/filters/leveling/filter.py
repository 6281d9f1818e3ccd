"""Leveling extended Kalman filter: roll and pitch of a vehicle that moves, from its speed (paper 3).

What tells gravity from acceleration is the velocity: the filter integrates the accelerometer and compares with a
measured forward speed, or with zero when the vehicle stands. It therefore levels in turns, where a filter that takes
the accelerometer for gravity leans with the vehicle, and it finds the level from any start, in motion too. It
assumes a vehicle that goes where it points; one that moves sideways must say how fast (``BodyVelocity.side``).

The heading is carried beside it, as the north direction in the body: turned with the gyro, drawn to the magnetometer.
docs/filters/leveling.md has the equations as mended.
"""

from dataclasses import dataclass
from math import ceil, isinf, isnan, nan, pi
from typing import Final, cast

from attest_mav.algebra import dot, down_in_body, mat_vec, norm, q_continuous, q_from_matrix, q_to_matrix, scale, sub
from attest_mav.filters.base import (
    MAX_CORRECTION_DT_S,
    AttitudeFilter,
    BodyVelocity,
    FilterInputs,
    FilterState,
    Start,
)
from attest_mav.filters.leveling.model import LevelState, is_sound, predicted, updated, with_variance_floor
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
from attest_mav.filters.leveling.state import LevelingState, VelocityModel, unchanged
from attest_mav.matrices import axes_turn, diagonal, largest_variance
from attest_mav.types import G_MPS2, ImuSample, North, Vec3

MAX_RATE: Final = 1e3
"""rad/s: a gyro that reports this much is not read (no sensor measures it, and its square must not overflow)."""
MAX_ACCEL: Final = 1e4
"""m/s^2: the same for the accelerometer."""
MAX_SPEED: Final = 1e4
"""m/s: the same for a speed."""
MAX_HEADING: Final = 1e4
"""rad: the same for a supplied heading."""
LONGEST_STEP_S: Final = 0.1
"""A longer step is taken in parts of ``PART_S`` at most."""
PART_S: Final = 0.02
LEVEL_FOUND: Final = 0.05
"""Standard deviation of the components of the down vector below which the attitude counts as found."""
SATURATION_NOISE: Final = 10.0
"""The process noise of a step with a saturated sensor is this many times the usual."""
BLIND_NOISE: Final = 1.0
"""(m/s)^2/s: the noise of the velocity while the accelerometer cannot be read."""


@dataclass(frozen=True)
class Leveling(AttitudeFilter):
    """Parameters; the defaults are for MEMS sensors. Variances are per component.

    q_velocity, q_down: process noise, (m/s)^2/s and 1/s.
    r_speed: of a forward speed, (m/s)^2. r_sideslip: of the velocity sideways and downwards in the body, (m/s)^2;
    infinite: these rows are not used. r_stationary: of the velocity of a standing vehicle, (m/s)^2.
    r_unaided: of the velocity of a vehicle whose speed nobody tells, about the last one known, (m/s)^2: large, since
    many rows see the same motion; infinite: nothing is assumed.
    r_length_start, r_length: of the squared length of the down vector, before and after the level is found.
    spacing_s: time between rows without a reading (kept velocity, unit length).
    p0_velocity, p0_down, p0_down_moving: variances at the start; the last for a vehicle that did not rest.
    heading_time_s: time constant with which the heading follows the magnetometer. heading_noise: growth of its
    variance, rad^2/s. r_heading: variance of one magnetic heading, rad^2. gravity: m/s^2.
    """

    q_velocity: float = 1e-3
    q_down: float = 1e-5
    r_speed: float = 0.01
    r_sideslip: float = 0.09
    r_stationary: float = 1e-4
    r_unaided: float = 1e3
    r_length_start: float = 0.7
    r_length: float = 0.1
    spacing_s: float = 0.05
    p0_velocity: float = 1.0
    p0_down: float = 0.05
    p0_down_moving: float = 1.0
    heading_time_s: float = 5.0
    heading_noise: float = 1e-5
    r_heading: float = 2.7e-3
    gravity: float = G_MPS2

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
        north = NorthVector(axes[0], self.r_heading, known, False)
        velocity_model = VelocityModel(False, False, (0.0, 0.0, 0.0))
        return LevelingState(
            start.q_nb,
            start.gyro_bias,
            False,
            False,
            level,
            north,
            velocity_model,
            self.spacing_s,
            (nan, nan, nan),
            nan,
        )

    def step(self, state: FilterState, dt_s: float, sample: ImuSample, inputs: FilterInputs) -> LevelingState:
        """Predict with the inertial sample, correct with what is known of the velocity, then turn the heading.

        Without a usable gyro it holds.
        """
        before = cast("LevelingState", state)
        gyro = sub(sample.gyro, before.gyro_bias)
        if not norm(gyro) < MAX_RATE:
            return unchanged(before)
        was_down = down_in_body(before.q_nb)
        earth_rate_b = earth_rate(before.north, was_down, inputs.latitude, inputs.declination)
        accel_usable = 0.0 < norm(sample.accel) < MAX_ACCEL
        x = self._predict(before.level, gyro, earth_rate_b, dt_s, sample, accel_usable)

        since_update_s = before.since_update_s + dt_s
        due = since_update_s > self.spacing_s - 0.5 * dt_s
        x, velocity_model, velocity_innovation = self._measure_velocity(x, before.velocity_model, inputs, due)
        level_found = largest_variance(x.p_dd) < LEVEL_FOUND * LEVEL_FOUND
        length_innovation = nan
        if due:
            length_innovation = 1.0 - dot(x.down, x.down)
            r_length = self.r_length if level_found else self.r_length_start
            x = updated(x, (0.0, 0.0, 0.0), scale(x.down, 2.0), length_innovation, r_length)

        down = direction(x.down, was_down)
        turned = mat_vec(axes_turn(scale(sub(gyro, earth_rate_b), dt_s)), before.north.direction)
        north = self._follow_field(before.north, made_level(turned, down), down, level_found, dt_s, sample, inputs)
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
            velocity_model,
            0.0 if due else since_update_s,
            velocity_innovation,
            length_innovation,
        )

    def _predict(
        self, x: LevelState, gyro: Vec3, earth_rate_b: Vec3, dt_s: float, sample: ImuSample, accel_usable: bool
    ) -> LevelState:
        """x after dt_s. Without an accelerometer the vehicle is taken to move evenly, with a wide margin."""
        accel = sample.accel if accel_usable else scale(x.down, -self.gravity)
        noise_factor = SATURATION_NOISE if sample.saturated else 1.0
        q_velocity = noise_factor * self.q_velocity if accel_usable else BLIND_NOISE
        parts = 1 if dt_s <= LONGEST_STEP_S else ceil(dt_s / PART_S)
        part_s = dt_s / parts
        for _ in range(parts):
            x = predicted(x, gyro, earth_rate_b, accel, self.gravity, part_s, q_velocity, noise_factor * self.q_down)
        return x

    def _measure_velocity(
        self, x: LevelState, before: VelocityModel, inputs: FilterInputs, due: bool
    ) -> tuple[LevelState, VelocityModel, Vec3]:
        """x after the rows of the model in use, that model, and the innovations."""
        if inputs.stationary:
            if not before.stationary:
                x = self._with_restarted_velocity(x, (0.0, 0.0, 0.0))
            return self._hold_velocity(x, VelocityModel(True, False, (0.0, 0.0, 0.0)), self.r_stationary, due)
        velocity = inputs.body_velocity
        if velocity is None or not abs(velocity.forward) < MAX_SPEED:
            return self._hold_velocity(x, VelocityModel(False, False, before.velocity), self.r_unaided, due)
        if not velocity.is_new:
            return (x, VelocityModel(False, before.moving, before.velocity), (nan, nan, nan))
        if not before.moving:
            x = self._with_restarted_velocity(x, (velocity.forward, *_lateral(velocity)))
        x, innovation = self._fuse_speed(x, velocity)
        return (x, VelocityModel(False, True, x.velocity), innovation)

    def _with_restarted_velocity(self, x: LevelState, velocity: Vec3) -> LevelState:
        """x with its velocity started anew.

        What the speed sensor of a standing vehicle showed (wind), or what a moving one had gathered, must not be
        levered into the attitude when the model changes.
        """
        return LevelState(velocity, x.down, diagonal(self.p0_velocity), diagonal(0.0), x.p_dd)

    def _hold_velocity(
        self, x: LevelState, velocity_model: VelocityModel, variance: float, due: bool
    ) -> tuple[LevelState, VelocityModel, Vec3]:
        """The rows of the stationary model, eq. (32); also, with a large variance, of a vehicle without a speed."""
        if not due or isinf(variance):
            return (x, velocity_model, (nan, nan, nan))
        x, forward = _fuse_velocity(x, (1.0, 0.0, 0.0), velocity_model.velocity[0], variance)
        x, side = _fuse_velocity(x, (0.0, 1.0, 0.0), velocity_model.velocity[1], variance)
        x, down = _fuse_velocity(x, (0.0, 0.0, 1.0), velocity_model.velocity[2], variance)
        return (x, velocity_model, (forward, side, down))

    def _fuse_speed(self, x: LevelState, velocity: BodyVelocity) -> tuple[LevelState, Vec3]:
        """The rows of the moving model, eq. (29), with those for a vehicle that goes where it points."""
        side, down = nan, nan
        x, forward = _fuse_velocity(x, (1.0, 0.0, 0.0), velocity.forward, self.r_speed)
        if velocity.lateral_known and not isinf(self.r_sideslip):
            if abs(velocity.side) < MAX_SPEED:
                x, side = _fuse_velocity(x, (0.0, 1.0, 0.0), velocity.side, self.r_sideslip)
            if abs(velocity.down) < MAX_SPEED:
                x, down = _fuse_velocity(x, (0.0, 0.0, 1.0), velocity.down, self.r_sideslip)
        return (x, (forward, side, down))

    def _follow_field(
        self,
        before: NorthVector,
        north: Vec3,
        down: Vec3,
        level_found: bool,
        dt_s: float,
        sample: ImuSample,
        inputs: FilterInputs,
    ) -> NorthVector:
        """The heading after this sample: as supplied, or drawn to the magnetometer, or as the gyro turned it.

        One that was not known becomes the magnetometer's, until the level is found and it counts as known.
        """
        heading = inputs.heading
        if heading is not None and abs(heading) < MAX_HEADING:
            return NorthVector(north_from_heading(heading, down, north), self.r_heading, True, False)
        variance = before.variance + self.heading_noise * dt_s
        error = heading_error(north, down, sample.mag) if sample.mag is not None else nan
        if isnan(error):
            return NorthVector(north, min(variance, pi * pi), before.known, False)
        gain = min(dt_s, MAX_CORRECTION_DT_S) / self.heading_time_s if before.known else 1.0
        variance = (1.0 - gain) * (1.0 - gain) * variance + gain * gain * self.r_heading
        return NorthVector(turned_east(north, down, gain * error), variance, before.known or level_found, True)


def _fuse_velocity(x: LevelState, axis: Vec3, measured: float, variance: float) -> tuple[LevelState, float]:
    """x after measuring the velocity along one axis, and the innovation."""
    innovation = measured - dot(axis, x.velocity)
    return (updated(x, axis, (0.0, 0.0, 0.0), innovation, variance), innovation)


def _lateral(velocity: BodyVelocity) -> tuple[float, float]:
    """The speeds along the body's y and z, m/s, 0 where one is not known."""
    side = velocity.side if velocity.lateral_known and abs(velocity.side) < MAX_SPEED else 0.0
    return (side, velocity.down if velocity.lateral_known and abs(velocity.down) < MAX_SPEED else 0.0)

"""A filter for readings as they come: one call a reading, without arrays."""

from collections.abc import Sequence
from math import isfinite, nan
from typing import Final

from attest_mav.algebra import q_continuous
from attest_mav.errors import ArgumentError
from attest_mav.estimation.sequence import FilterSequence, velocity_fix
from attest_mav.filters.base import AttitudeFilter
from attest_mav.innovation import Innovation
from attest_mav.library.frames import frames_named
from attest_mav.types import EarthField, North, Quat, Vec3

NS: Final = 1e9


class LiveAttitude:
    """The attitude of one sensor, brought up to date with each reading.

    ::

        live = LiveAttitude(VelocityAided(), frames="FLU/ENU")
        while True:
            q = live.update(time.monotonic(), gyro, accel, mag)

    Vectors are anything with three numbers: tuples, lists, rows of arrays. declination, inclination: of the Earth's
    field, rad, where known. in_place: until a velocity comes, the sensor is assumed to move but to stay in place.
    """

    def __init__(
        self,
        attitude_filter: AttitudeFilter,
        frames: str = "FRD/NED",
        *,
        declination: float = nan,
        inclination: float = nan,
        in_place: bool = True,
    ) -> None:
        self.frames: Final = frames_named(frames)
        self._sequence: Final = FilterSequence(attitude_filter, EarthField(declination, inclination), in_place)
        self._attitude: Quat | None = None
        self._t_ns: int | None = None

    def update(
        self,
        t: float,
        gyro: Sequence[float],
        accel: Sequence[float],
        mag: Sequence[float] | None = None,
        velocity: Sequence[float] | None = None,
    ) -> Quat | None:
        """The attitude at this reading, body to world (w, x, y, z); None while there is none.

        t: when it was taken, s, later than the one before. gyro: rad/s. accel: specific force, m/s^2. mag: gauss.
        velocity: a new fix, over ground, m/s, valid now; None on readings without one. The axes are those of
        ``frames``. ArgumentError (a ValueError) where t is not later, or a vector has not three numbers.
        """
        t_ns = self._later(t)
        body, world = self.frames.body_vector, self.frames.world_vector
        field = None if mag is None else body(_vector("mag", mag))
        rates, force = body(_vector("gyro", gyro)), body(_vector("accel", accel))
        if velocity is not None:
            self._sequence.give_velocity(velocity_fix(t_ns, world(_vector("velocity", velocity))))
        self._t_ns = t_ns
        state = self._sequence.advance(t_ns, rates, force, _known(field))
        if state is None or not state.aligned:
            self._attitude = None
            return None
        q = self.frames.attitude(state.q_nb)
        self._attitude = q if self._attitude is None else q_continuous(q, self._attitude)
        return self._attitude

    @property
    def attitude(self) -> Quat | None:
        """The attitude after the last reading, body to world; None while there is none."""
        return self._attitude

    @property
    def tilt_sigma(self) -> float:
        """1-sigma of the tilt, rad; NaN without an attitude, or for a filter without covariance."""
        state = self._sequence.state
        return nan if state is None or not state.aligned else state.tilt_sigma

    @property
    def heading_sigma(self) -> float:
        """1-sigma of the heading, rad; NaN without an attitude, or for a filter without covariance."""
        state = self._sequence.state
        return nan if state is None or not state.aligned else state.heading_sigma

    @property
    def gyro_bias(self) -> Vec3:
        """rad/s, body: the gyro shows the rate and this."""
        state = self._sequence.state
        return (0.0, 0.0, 0.0) if state is None else self.frames.body_vector(state.gyro_bias)

    @property
    def innovations(self) -> tuple[Innovation, ...]:
        """The measurements of the aids at the last reading, in FRD and NED."""
        state = self._sequence.state
        return () if state is None else state.innovations

    @property
    def north(self) -> North:
        """The north that the heading refers to."""
        return self._sequence.north

    def _later(self, t: float) -> int:
        """The time in ns, if it can be the next one."""
        if not isfinite(t):
            raise ArgumentError(f"t = {t}: expected seconds")
        t_ns = round(t * NS)
        if self._t_ns is not None and t_ns <= self._t_ns:
            raise ArgumentError(f"t = {t:.9g} s does not follow {self._t_ns / NS:.9g} s; expected a later time")
        return t_ns


def _vector(name: str, values: Sequence[float]) -> Vec3:
    """Three floats."""
    try:
        x, y, z = values
        return (float(x), float(y), float(z))
    except (TypeError, ValueError):
        raise ArgumentError(f"{name}: expected three numbers, not {values!r}") from None


def _known(field: Vec3 | None) -> Vec3 | None:
    """The field; None where it is not finite or zero, as of a sensor that has no new reading."""
    if field is None or not isfinite(sum(field)) or field == (0.0, 0.0, 0.0):
        return None
    return field

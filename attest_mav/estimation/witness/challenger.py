"""A filter that is begun anew while the lanes coast, and shows whether they, or the receiver, are right."""

from dataclasses import replace
from enum import IntEnum
from math import hypot, radians
from typing import Final

from attest_mav.algebra import heading_between, tilt_between
from attest_mav.estimation.witness.field_watch import FieldWatch
from attest_mav.estimation.witness.flight_state import field_direction, navigation_of, shifted, used_fix
from attest_mav.estimation.witness.moments import Moment
from attest_mav.filters.base import FilterState, Start
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.types import North

BIAS_SIGMA: Final = radians(0.6)
"""rad/s: of the gyro's bias at its start."""
FITS: Final = 20
"""So many fixes in a row must fit, with a tilt sigma below ``SURE``, rad."""
SURE: Final = radians(2.5)
FIT_NIS: Final = 3.0
LONG_FITS: Final = 100
"""So many need no other evidence."""
NOISIER: Final = 3.0
"""A receiver that is noisier than usual by this factor needs the longer row too: its errors may pass for motion."""
NEAR_TILT: Final = radians(2.0)
NEAR_HEADING: Final = radians(4.0)
NEAR_SIGMAS: Final = 2.0
"""An attitude this near, beside so many of its sigmas, is the same."""
LANE_SIGMAS: Final = 3.0
"""The lanes' own sigma allows for it within so many."""
REFUTED: Final = 0.04
REFUTED_USUALS: Final = 4.0
"""A field residual beyond both refutes the lanes,"""
TWICE: Final = 2.0
"""where the challenger's is smaller by this factor."""
AGAINST: Final = 0.02
AGAINST_USUALS: Final = 3.0
"""The challenger itself is refuted by a residual beyond both, where the lanes' is smaller by the same factor."""
FIELD_SHARE: Final = 0.1
NIS_SHARE: Final = 0.05


class Challenge(IntEnum):
    """Result of the challenger."""

    OPEN = 0
    NEAR = 1
    """The receiver is right, and so are the lanes."""
    FAR = 2
    """The receiver is right, the lanes are not."""


class Challenger:
    """Runs on the samples of one lane."""

    def __init__(self, shift_s: float, moment: Moment) -> None:
        self.state: FilterState | None = None
        self.fits = 0
        """Fixes in a row that fit."""
        self.mean_nis = 0.0
        """Running mean of the normalised innovation squared of its fixes."""
        self.residual = 0.0
        """Mean residual of the field."""
        self._shift_s: Final = shift_s
        self._bias: Final = moment.state.gyro_bias
        self._used_ns = -1

    def take(self, one: VelocityAided, moment: Moment, field: FieldWatch) -> None:
        """Go on to the next moment."""
        begun = replace(one, parameters=replace(one.parameters, gyro_bias_sigma=BIAS_SIGMA))
        if self.state is None:
            sample = moment.sample
            start = Start(moment.state.q_nb, self._bias, North.RELATIVE, sample.accel, sample.mag, False)
            self.state = begun.initial(start)
            return
        fix = moment.inputs.velocity
        shown = None if fix is None else shifted(fix, self._shift_s)
        self.state = begun.step(self.state, moment.dt_s, moment.sample, moment.inputs.with_velocity(shown))
        self._count()
        direction = field_direction(self.state, moment.sample)
        if direction is not None:
            self.residual += FIELD_SHARE * (field.residual_of(direction) - self.residual)

    def _count(self) -> None:
        state = self.state
        if state is None or navigation_of(state) is None:
            self.fits = 0
            return
        record = used_fix(state)
        if record is not None and record.t_ns != self._used_ns:
            self._used_ns = record.t_ns
            self.fits = self.fits + 1 if record.nis < FIT_NIS else 0
            self.mean_nis += NIS_SHARE * (min(record.nis, FIT_NIS) - self.mean_nis)

    def shows(self, lane: FilterState, field: FieldWatch, lane_residual: float, usual_nis: float) -> Challenge:
        """The result beside a lane.

        lane_residual: that lane's mean residual of the field. usual_nis: of a fix in good times, mean of the axes.
        """
        state = self.state
        if state is None or self.fits < FITS or state.tilt_sigma > SURE:
            return Challenge.OPEN
        if self.fits < LONG_FITS and self.mean_nis > NOISIER * usual_nis:
            return Challenge.OPEN
        tilt = tilt_between(state.q_nb, lane.q_nb)
        heading = abs(heading_between(state.q_nb, lane.q_nb))
        if self.residual > max(AGAINST, AGAINST_USUALS * field.usual) and self.residual > TWICE * lane_residual:
            return Challenge.OPEN
        if (
            tilt < NEAR_TILT + NEAR_SIGMAS * state.tilt_sigma
            and heading < NEAR_HEADING + NEAR_SIGMAS * state.heading_sigma
        ):
            return Challenge.NEAR
        refuted = lane_residual > max(REFUTED, REFUTED_USUALS * field.usual) and TWICE * self.residual < lane_residual
        allowed = tilt < LANE_SIGMAS * hypot(lane.tilt_sigma, state.tilt_sigma) and heading < LANE_SIGMAS * hypot(
            lane.heading_sigma, state.heading_sigma
        )
        return Challenge.FAR if refuted or allowed or self.fits >= LONG_FITS else Challenge.OPEN

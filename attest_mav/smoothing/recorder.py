"""A recorder stands in a lane in the place of a filter and keeps the readings for the smoother.

So the smoother sees what a live filter is given: the samples that the time base admits, on its clock, the fixes that
the vehicle's state lets pass, and the declination.
"""

from array import array
from math import inf, isfinite, nan
from struct import Struct
from typing import Final

import numpy as np

from attest_mav.algebra import norm, q_conj, q_mul
from attest_mav.filters.base import AttitudeFilter, FilterInputs, FilterState, Start
from attest_mav.filters.velocity_aided.aids.magnetometer import REST_RATE, REUSE_S
from attest_mav.filters.velocity_aided.aids.zero_motion import SETTLED_S
from attest_mav.filters.velocity_aided.alignment.collect import Alignment, accumulate, new_alignment
from attest_mav.filters.velocity_aided.alignment.solve import solve_alignment
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.filters.velocity_aided.reading import Reading, field_of, read
from attest_mav.filters.velocity_aided.reset import UNSEEN_GAP_S, is_lost
from attest_mav.plausible import is_rate, is_velocity
from attest_mav.samples import ImuSample, VelocitySample
from attest_mav.smoothing.readings import (
    FIELD_READING,
    FIELD_READING_FORMAT,
    READING,
    READING_FORMAT,
    Fixes,
    Recording,
    Stretch,
    usual_step_s,
)
from attest_mav.smoothing.tables import Scratch
from attest_mav.types import Vec3, VelocityOrigin

PACK_READING: Final = Struct(READING_FORMAT).pack
PACK_FIELD_READING: Final = Struct(FIELD_READING_FORMAT).pack
SETTLED_SPACING_S: Final = 10.0
"""At rest for longer than ``SETTLED_S`` one fix and one magnetometer reading in this time is kept, s: their errors stay
the same, and many of them would count as knowledge."""
UNKNOWN_HEADING: Final = 1.0
"""rad: a heading with a larger 1-sigma is not known, and no model is linear about it."""


class Recorder(AttitudeFilter):
    """Takes the steps of a lane and keeps their readings. It has no state of its own, and estimates nothing."""

    def __init__(self, parameters: FlightParameters, scratch: Scratch | None = None) -> None:
        """scratch: keeps the tables; None for memory."""
        self.parameters: Final = parameters
        """Of the model, for what is admitted."""
        self.scratch: Final = Scratch() if scratch is None else scratch
        self._readings: Final = self.scratch.table(READING)
        self._fields: Final = self.scratch.table(FIELD_READING)
        self._fixes = array("d")
        self._last_fix: VelocitySample | None = None
        self._accel: Vec3 = (0.0, 0.0, -parameters.gravity)
        self._mag: Vec3 | None = None
        self._t_s = 0.0
        self._rest_s = 0.0
        self._field_s = inf
        self._origin = VelocityOrigin.RECEIVER
        self._declination = nan
        self._alignment: Alignment | None = None
        self._alignment_row = 0
        self._begin = 0
        self._stretches: list[Stretch] = []
        self._all_stay = True

    @property
    def name(self) -> str:
        """``recorder``."""
        return "recorder"

    @property
    def aligns_itself(self) -> bool:
        """True: it takes every sample, and steps of any length."""
        return True

    def initial(self, start: Start) -> FilterState:
        """The state that never changes."""
        return FilterState(start.q_nb, start.gyro_bias, accel_used=False, mag_used=False)

    def step(self, state: FilterState, dt_s: float, sample: ImuSample, inputs: FilterInputs) -> FilterState:
        """Keep the sample's readings, and the fix if it is a new one."""
        if not (is_rate(sample.gyro) and dt_s > 0.0):
            return state
        row = len(self._readings)
        reading = read(sample, self._accel)
        self._t_s += dt_s
        if row and is_lost(dt_s, inputs):
            self._begin_stretch(row)
        self._keep(reading, sample, inputs, dt_s)
        if inputs.velocity is not None and inputs.velocity is not self._last_fix:
            self._keep_fix(inputs.velocity, sample.t_ns)
        if isfinite(inputs.declination):
            self._declination = inputs.declination
        if not self._stretches or self._stretches[-1].begin != self._begin:
            self._align(reading, sample, inputs, dt_s, row)
        return state

    def _keep(self, reading: Reading, sample: ImuSample, inputs: FilterInputs, dt_s: float) -> None:
        """Append a row."""
        self._accel = reading.accel
        self._rest_s = self._rest_s + dt_s if inputs.stationary else 0.0
        self._field_s += dt_s
        field = field_of(sample) if self._field_is_due(sample) else None
        if field is not None:
            self._field_s = 0.0
            self._fields.append(PACK_FIELD_READING(self._t_s, *field, *reading.gyro))
        self._mag = sample.mag if sample.mag is not None else self._mag
        gap_s = dt_s if inputs.samples_missing and dt_s >= UNSEEN_GAP_S else 0.0
        at_rest, stays = inputs.stationary, inputs.zero_mean_velocity
        self._all_stay = self._all_stay and stays
        numbers = (self._t_s, *reading.gyro, *reading.accel, gap_s)
        self._readings.append(PACK_READING(sample.t_ns, *numbers, reading.saturated, at_rest, stays))

    def _field_is_due(self, sample: ImuSample) -> bool:
        """Whether the sample has a new reading of the magnetometer, or one that stays the same for good reason."""
        if self._rest_s > SETTLED_S and self._field_s < SETTLED_SPACING_S:
            return False
        is_new = sample.mag is not None and sample.mag != self._mag
        if is_new:
            return self._field_s > self.parameters.mag_spacing_s
        return self._field_s > REUSE_S and norm(sample.gyro) < REST_RATE

    def _keep_fix(self, fix: VelocitySample, now_ns: int) -> None:
        """Append a fix that is far enough from the last one."""
        last = self._last_fix
        apart_s = self.parameters.fix_spacing_s if last is None else (fix.t_ns - last.t_ns) * 1e-9
        spacing_s = SETTLED_SPACING_S if self._rest_s > SETTLED_S else self.parameters.fix_spacing_s
        if not is_velocity(fix.v_ned) or (0.0 <= apart_s < spacing_s - 1e-3):
            return
        self._last_fix = fix
        self._origin = fix.origin
        sigma = 0.0 if fix.sigma is None else fix.sigma
        self._fixes.extend((self._t_s + (fix.t_ns - now_ns) * 1e-9, *fix.v_ned, fix.vertical_known, sigma))

    def _begin_stretch(self, row: int) -> None:
        """A gap: what was collected for an alignment before it is of no use."""
        if self._alignment is not None and (not self._stretches or self._stretches[-1].begin != self._begin):
            self._give_up_alignment()
        self._alignment, self._begin = None, row

    def _give_up_alignment(self) -> None:
        """A stretch too short to be aligned: it begins with the attitude of the one before, and a large sigma."""
        q_nb = self._stretches[-1].q_nb if self._stretches else (1.0, 0.0, 0.0, 0.0)
        self._stretches.append(Stretch(self._begin, self._begin, q_nb))

    def _align(self, reading: Reading, sample: ImuSample, inputs: FilterInputs, dt_s: float, row: int) -> None:
        """One sample more for the alignment of the stretch, or its end."""
        alignment = self._alignment
        if alignment is None or sample.saturated or alignment.began_saturated:
            self._alignment, self._alignment_row = new_alignment(reading, sample.t_ns), row
            return
        alignment = accumulate(alignment, reading, sample, inputs, (0.0, 0.0, 0.0), dt_s, self.parameters)
        self._alignment = alignment
        declination = self._declination if isfinite(self._declination) else 0.0
        initial = solve_alignment(alignment, declination, inputs.inclination, self.parameters)
        if initial is not None:
            q_nb = q_mul(initial.q_nb, q_conj(alignment.rotation.q_start_body))
            has_heading = initial.attitude[2][2] < UNKNOWN_HEADING**2
            self._stretches.append(Stretch(self._begin, self._alignment_row, q_nb, has_heading))

    def recording(self) -> Recording | None:
        """Everything recorded; None without an alignment anywhere, or a heading of a flight to begin with."""
        self._begin_stretch(len(self._readings))
        if not any(one.q_nb != (1.0, 0.0, 0.0, 0.0) for one in self._stretches):
            return None
        if len(self._fixes) and not self._stretches[0].has_heading:
            return None
        fixes = np.array(self._fixes).reshape(-1, 6)
        fixes = fixes[np.argsort(fixes[:, 0], kind="stable")]
        return Recording(
            self.scratch,
            self._readings,
            self._fields,
            Fixes(fixes[:, 0], fixes[:, 1:4], fixes[:, 4] > 0.0, fixes[:, 5]),
            self._origin,
            tuple(self._stretches),
            self._declination,
            usual_step_s(self._readings),
            self._all_stay and not len(fixes),
        )

"""The readings of one inertial sensor and what aids it over a whole flight, as arrays.

A recorder stands in a lane in the place of a filter, so that the smoother sees what a live filter is given: the samples
that the time base admits, on its clock, the fixes that the vehicle's state lets pass, and the declination.
"""

from array import array
from dataclasses import dataclass
from math import inf, isfinite, nan
from typing import Final

import numpy as np
from numpy.typing import NDArray

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
from attest_mav.smoothing.rotations import Array
from attest_mav.types import Quat, Vec3, VelocityOrigin

NO_VECTOR: Final = (nan, nan, nan)
SETTLED_SPACING_S: Final = 10.0
"""At rest for longer than ``SETTLED_S`` one fix and one magnetometer reading in this time is kept, s: their errors stay
the same, and many of them would count as knowledge."""


@dataclass(frozen=True)
class Fixes:
    """Velocity fixes, a row each."""

    t_s: Array
    """Time that the message names, on the clock of the readings, s."""
    velocity: Array
    """NED, m/s."""
    has_vertical: NDArray[np.bool_]
    sigma: Array
    """As the receiver reports it, m/s; 0 where it reports none."""


@dataclass(frozen=True)
class Stretch:
    """A part of the readings without a gap. Its attitude is known at one of them, from an alignment."""

    begin: int
    """Row of its first reading."""
    aligned: int
    """Row of the reading whose attitude is known."""
    q_nb: Quat
    """That attitude."""


@dataclass(frozen=True)
class Recording:
    """A whole flight. Arrays have a row for each inertial sample."""

    t_ns: NDArray[np.int64]
    """Sensor clock, ns, as the samples carry it."""
    t_s: Array
    """Time that grows over the restarts of that clock, s."""
    gyro: Array
    """Body, rad/s."""
    accel: Array
    """Specific force, body, m/s^2."""
    field: Array
    """Magnetic field, body, gauss; NaN where a sample has no new reading."""
    saturated: NDArray[np.bool_]
    gap_s: Array
    """Length of the step before, s, where samples are missing in it and a rotation may have gone unseen; else 0."""
    at_rest: NDArray[np.bool_]
    """The sensors are quiet, and the vehicle says or is known to stand."""
    stays: NDArray[np.bool_]
    """The vehicle may be taken to stay in place: it is not armed."""
    fixes: Fixes
    fix_origin: VelocityOrigin
    stretches: tuple[Stretch, ...]
    declination: float
    """Assumed, rad; NaN where it is not known, and headings are magnetic."""

    @property
    def in_place(self) -> bool:
        """Whether the sensor stays in place from beginning to end, and no velocity tells otherwise."""
        return bool(self.stays.all()) and not len(self.fixes.t_s)


class Recorder(AttitudeFilter):
    """Takes the steps of a lane and keeps their readings. It has no state of its own, and estimates nothing."""

    def __init__(self, parameters: FlightParameters) -> None:
        self.parameters: Final = parameters
        """Of the model, for what is admitted."""
        self._t_ns = array("q")
        self._rows = array("d")
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
        self._idle: FilterState | None = None

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
        row = len(self._t_ns)
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
        self._mag = sample.mag if sample.mag is not None else self._mag
        gap_s = dt_s if inputs.samples_missing and dt_s >= UNSEEN_GAP_S else 0.0
        self._t_ns.append(sample.t_ns)
        self._rows.extend((self._t_s, *reading.gyro, *reading.accel, *(NO_VECTOR if field is None else field)))
        self._rows.extend((reading.saturated, gap_s, inputs.stationary, inputs.zero_mean_velocity))

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
            self._stretches.append(Stretch(self._begin, self._alignment_row, q_nb))

    def recording(self) -> Recording | None:
        """Everything recorded; None without an alignment anywhere."""
        self._begin_stretch(len(self._t_ns))
        if not any(one.q_nb != (1.0, 0.0, 0.0, 0.0) for one in self._stretches):
            return None
        rows = np.array(self._rows).reshape(-1, 14)
        fixes = np.array(self._fixes).reshape(-1, 6)
        fixes = fixes[np.argsort(fixes[:, 0], kind="stable")]
        return Recording(
            np.array(self._t_ns),
            rows[:, 0],
            rows[:, 1:4],
            rows[:, 4:7],
            rows[:, 7:10],
            rows[:, 10] > 0.0,
            rows[:, 11],
            rows[:, 12] > 0.0,
            rows[:, 13] > 0.0,
            Fixes(fixes[:, 0], fixes[:, 1:4], fixes[:, 4] > 0.0, fixes[:, 5]),
            self._origin,
            tuple(self._stretches),
            self._declination,
        )

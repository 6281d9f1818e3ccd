"""The accuracy of the flight filter and of the smoother on recorded flights, each row with its bounds.

A row is a log under one condition. The live filter counts from 30 s after its alignment on, the smoother from the first
sample.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import nan
from typing import Final

import numpy as np
from numpy.typing import NDArray

from attest_mav.estimation.pipeline import PipelineSettings
from attest_mav.evaluation.flight_study.edits import WHOLE, Edit, with_iron, without_velocity
from attest_mav.evaluation.flight_study.figures import Figures, Line, at_least, at_most, rms
from attest_mav.evaluation.flight_study.flying import ErrorLog, Errors, recorded
from attest_mav.evaluation.flight_study.sensor_errors import ALONE, SETS, with_sensor_errors
from attest_mav.evaluation.harness import Bound
from attest_mav.filters.calibration import SensorCalibration
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.logs.source import SMOOTHED
from attest_mav.logs.tlog.source import open_tlog
from attest_mav.replay.engine import Recording, record
from attest_mav.replay.flight import AUTOPILOT, Flight
from attest_mav.replay.request import Window
from attest_mav.replay.smoothed import FlightToSmooth
from attest_mav.samples import Sample
from attest_mav.smoothing.log import smoothed_flight
from attest_mav.smoothing.tables import Scratch
from attest_mav.types import EarthField

LIVE: Final = VelocityAided().name
SEEDS: Final = 4
"""Of the sensor errors."""
DISTURBED_S: Final = 60.0
"""Length of an outage of the velocity, or of iron."""
COVERING: Final = 3.0
"""Sigmas within which the shares of errors are counted."""
Bounds = Mapping[str, Bound]
ErrorsByName = dict[str, Errors]


@dataclass(frozen=True)
class Case:
    """A log, by its file name without the ending, under a condition."""

    log: str
    condition: str
    edits: tuple[Edit, ...]
    """Each is flown; the figures are root mean squares over all."""
    bounds: Bounds
    within_s: tuple[float, ...] = ()
    """Beginnings of the disturbances of the edits, within which errors count alone."""
    by_smoothed: bool = False
    """The reference is the smoothed attitude, and the figure the autopilot's error against that over the true one."""
    earlier: str = ""
    """An earlier flight of the same sensors, which has shown their errors; "" for none."""


def _bounds(live: tuple[float, float] | None, smoothed: tuple[float, float] | None) -> dict[str, Bound]:
    """Bounds of tilt and heading, degrees, of both."""
    named = (("live", live), ("smoother", smoothed))
    bounds: dict[str, Bound] = {}
    for name, pair in named:
        if pair is not None:
            bounds |= {f"{name} tilt": at_most(pair[0]), f"{name} heading": at_most(pair[1])}
    if smoothed is not None:
        bounds |= {"smoother tilt e/s": at_most(1.2), "smoother heading e/s": at_most(1.2)}
    return bounds


def _sensors(kind: str) -> tuple[Edit, ...]:
    errors = (SETS | ALONE)[kind]
    return tuple(partial(with_sensor_errors, errors=errors, seed=seed) for seed in range(SEEDS))


def _outages(*starts: float) -> tuple[Edit, ...]:
    return tuple(partial(without_velocity, from_s=start, to_s=start + DISTURBED_S) for start in starts)


def _iron(*starts: float) -> tuple[Edit, ...]:
    return tuple(partial(with_iron, from_s=start, to_s=start + DISTURBED_S, gauss=0.2) for start in starts)


_HONEST: Final = {"live tilt e/s": at_most(1.25), "live heading e/s": at_most(1.7)}
_COVERED: Final = _HONEST | {"live tilt < 3 s %": at_least(99.0), "live heading < 3 s %": at_least(93.0)}
_NOT_TIMID: Final = {"live tilt e/s": at_least(0.3), "live heading e/s": at_least(0.3)}
"""A sigma far above the errors tells as little as one that is too small."""
_PLACES: Final = (80.0, 150.0, 210.0)
_IRON_PLACES: Final = (40.0, 130.0, 230.0)
_OUTAGE: Final = {"smoother tilt": at_most(0.06)}
_IRON_BOUNDS: Final = {"smoother tilt": at_most(0.08), "smoother heading": at_most(0.15)}


def _after(earlier: str, log: str, kind: str, live: tuple[float, float] | None, smoothed: tuple[float, float]) -> Case:
    """Sensors whose errors an earlier flight has shown."""
    bounds = _bounds(live, smoothed) | _COVERED
    return Case(log, f"{kind} sensors, after {earlier}", _sensors(kind), bounds, earlier=earlier)


CASES: Final = (
    Case("copter_square", "as it is", (WHOLE,), _bounds((0.075, 0.10), (0.03, 0.06)) | _NOT_TIMID),
    Case("copter_square", "typical sensors", _sensors("typical"), _bounds((0.43, 1.0), (0.15, 0.25)) | _HONEST),
    Case("copter_square", "poor sensors", _sensors("poor"), _bounds(None, (0.35, 0.65)) | _HONEST),
    Case("copter_square", "60 s without fixes", _outages(*_PLACES), _OUTAGE, _PLACES),
    Case("copter_square", "iron of 200 mG", _iron(*_IRON_PLACES), _IRON_BOUNDS, _IRON_PLACES),
    Case("copter_square", "judged by smoothed", (WHOLE,), {"ratio": (0.85, 1.15)}, by_smoothed=True),
    *(Case("copter_square", kind, _sensors(kind), _COVERED) for kind in ALONE),
    _after("plane_circles", "copter_square", "typical", (0.43, 1.0), (0.15, 0.25)),
    _after("plane_circles", "copter_square", "poor", None, (0.3, 0.5)),
    Case("plane_circles", "as it is", (WHOLE,), _bounds((0.085, 0.10), (0.03, 0.03)) | _NOT_TIMID),
    Case("plane_circles", "typical sensors", _sensors("typical"), _bounds((0.37, 0.42), (0.14, 0.17)) | _HONEST),
    Case("plane_circles", "poor sensors", _sensors("poor"), _bounds(None, (0.35, 0.65)) | _HONEST),
    Case("plane_circles", "60 s without fixes", _outages(*_PLACES), _OUTAGE, _PLACES),
    Case("plane_circles", "iron of 200 mG", _iron(*_IRON_PLACES), _IRON_BOUNDS, _IRON_PLACES),
    *(Case("plane_circles", kind, _sensors(kind), _COVERED) for kind in ALONE),
    _after("copter_square", "plane_circles", "typical", (0.37, 0.42), (0.14, 0.17)),
    _after("copter_square", "plane_circles", "poor", None, (0.3, 0.4)),
    Case(
        "plane_turbulent",
        "as it is",
        (WHOLE,),
        _bounds((0.5, 0.75), (0.6, 0.5)) | {"live sigma < 1 %": at_least(20.0)},
    ),
    Case("vtol_4hz", "as it is", (WHOLE,), {"smoother sure tilt": at_most(0.30)}),
)
SHORT: Final = (
    Case("copter_square_laps", "as it is", (WHOLE,), _bounds(None, (0.1, 0.1))),
    Case("plane_circles_turn", "as it is", (WHOLE,), _bounds(None, (0.8, 0.8))),
)
"""Logs of less than half a minute, too short for figures of the live filter; they are among the tests' data."""


def measured(case: Case, log: bytes, earlier: bytes = b"") -> Line:
    """The figures of a case beside its bounds. log, earlier: the bytes of the tlogs."""
    # Edits are of one sensor; a log as it is flies with all of them, as in a replay.
    recording = record(open_tlog(log), every_sensor=True) if case.edits == (WHOLE,) else recorded(log)
    if case.by_smoothed:
        return Line(_label(case), _judged(recording), case.bounds)
    before = recorded(earlier) if case.earlier else None
    flights = [
        _flown(recording, edit(recording.samples, recording.plan.imu), calibrations=_shown_by(before, edit))
        for edit in case.edits
    ]
    found: Figures = {}
    for name, key in (("live", LIVE), ("smoother", SMOOTHED)):
        parts = [_counted(flight[key], case, place) for place, flight in enumerate(flights)]
        errors = _joined(parts if name == "smoother" or case.within_s else [one.that_count() for one in parts])
        found |= {f"{name} {figure}": value for figure, value in _figures(errors).items()}
    return Line(_label(case), {name: found[name] for name in (*_SHOWN, *case.bounds)}, case.bounds)


_SHOWN: Final = ("live tilt", "live heading", "smoother tilt", "smoother heading")


def _label(case: Case) -> str:
    return f"{case.log}, {case.condition}"


def _shown_by(earlier: Recording | None, edit: Edit) -> dict[str, SensorCalibration]:
    """The errors of the sensors that an earlier flight has shown, by inertial message."""
    if earlier is None:
        return {}
    one, earth = VelocityAided().with_vehicle_settings(earlier.settings), _field(earlier)
    flight = Flight(earlier.plan, [one], earth, Window())
    for sample in edit(earlier.samples, earlier.plan.imu):
        flight.take(sample)
    flight.finish()
    return flight.runs[0].pipeline.learned


def _field(recording: Recording) -> EarthField:
    return EarthField() if recording.earth_field is None else recording.earth_field.direction


def _flown(
    recording: Recording,
    samples: Sequence[Sample],
    *,
    as_reference: bool = False,
    calibrations: dict[str, SensorCalibration] | None = None,
) -> ErrorsByName:
    """Errors of the live filter, of the smoother and of the autopilot."""
    one = VelocityAided().with_vehicle_settings(recording.settings)
    earth, plan = _field(recording), recording.plan
    known = calibrations or {}
    to_smooth = FlightToSmooth(
        samples, plan.imu, (), earth, PipelineSettings(), one.parameters, calibration=known.get(plan.imu)
    )
    log = ErrorLog()
    if as_reference:
        plan = replace(plan, reference=SMOOTHED)
    flight = Flight(plan, [one], earth, Window(), sink=log, smoothed=smoothed_flight(to_smooth, Scratch()))
    flight.runs[0].pipeline.vehicle.calibrations = known
    for sample in samples:
        flight.take(sample)
    flight.finish()
    return log.errors()


def _counted(errors: Errors, case: Case, place: int) -> Errors:
    """The compared errors of one edit, those within its disturbance where it has one."""
    if case.within_s:
        return errors.between(case.within_s[place], case.within_s[place] + DISTURBED_S)
    return errors.where(np.isfinite(errors.tilt))


def _joined(parts: Sequence[Errors]) -> Errors:
    """The errors of several flights, one after the other."""
    columns = [[one.t_s, one.tilt, one.heading, one.tilt_sigma, one.heading_sigma] for one in parts]
    t_s, tilt, heading, tilt_sigma, heading_sigma = (np.concatenate(each) for each in zip(*columns, strict=True))
    return Errors(t_s, tilt, heading, tilt_sigma, heading_sigma, np.concatenate([one.counted for one in parts]))


def _figures(errors: Errors) -> Figures:
    """Root mean squares, degrees; of error over sigma; and where the tilt's sigma is below a degree."""
    sure = errors.tilt_sigma < 1.0
    return {
        "tilt": rms(errors.tilt),
        "heading": rms(errors.heading),
        "tilt e/s": rms(errors.tilt / errors.tilt_sigma),
        "heading e/s": rms(errors.heading / errors.heading_sigma),
        "tilt < 3 s %": _percent(errors.tilt < COVERING * errors.tilt_sigma),
        "heading < 3 s %": _percent(np.abs(errors.heading) < COVERING * errors.heading_sigma),
        "sure tilt": rms(errors.tilt[sure]),
        "sigma < 1 %": _percent(sure),
    }


def _percent(chosen: NDArray[np.bool_]) -> float:
    return float(100.0 * np.mean(chosen)) if len(chosen) else nan


def _judged(recording: Recording) -> Figures:
    """The autopilot's tilt error against the smoothed attitude and against the truth, degrees, and their ratio."""
    by_truth = _flown(recording, recording.samples)[AUTOPILOT].that_count()
    by_smoothed = _flown(recording, recording.samples, as_reference=True)[AUTOPILOT].that_count()
    true, seen = rms(by_truth.tilt), rms(by_smoothed.tilt)
    return {"autopilot tilt": true, "by smoothed": seen, "ratio": seen / true}


def run(cases: Sequence[Case], read: Callable[[str], bytes | None]) -> Iterator[Line]:
    """The line of each case whose log is there. read: the bytes of the log of that name, None where it is not there."""
    for case in cases:
        log, earlier = read(case.log), read(case.earlier) if case.earlier else b""
        if log is not None and earlier is not None:
            yield measured(case, log, earlier)

"""One filter over edited samples, by the engine that replays logs, with its errors kept sample by sample."""

from array import array
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import lru_cache
from math import nan
from typing import Final

import numpy as np
from numpy.typing import NDArray

from attest_mav.errors import UsageError
from attest_mav.evaluation.flight_study.edits import Edit
from attest_mav.filters.base import AttitudeFilter
from attest_mav.filters.registry import default_filter
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.filters.velocity_aided.parameters import FlightParameters
from attest_mav.logs.tlog.source import open_tlog
from attest_mav.replay.comparison import ComparedAttitude
from attest_mav.replay.engine import Recording, record
from attest_mav.replay.flight import AUTOPILOT, Flight
from attest_mav.replay.request import Window
from attest_mav.samples import Sample
from attest_mav.types import EarthField

Column = NDArray[np.float64]


@dataclass(frozen=True)
class Errors:
    """Errors of one attitude, a column each, degrees and seconds from the first inertial sample given.

    NaN stands for no comparison, no north, or no sigma. counted: 1 for samples after the time left out.
    """

    t_s: Column
    tilt: Column
    heading: Column
    tilt_sigma: Column
    heading_sigma: Column
    counted: NDArray[np.bool_]

    def where(self, chosen: NDArray[np.bool_]) -> "Errors":
        """Some of the samples."""
        return Errors(
            self.t_s[chosen],
            self.tilt[chosen],
            self.heading[chosen],
            self.tilt_sigma[chosen],
            self.heading_sigma[chosen],
            self.counted[chosen],
        )

    def between(self, from_s: float, to_s: float) -> "Errors":
        """The compared samples of an interval."""
        return self.where((self.t_s >= from_s) & (self.t_s < to_s) & np.isfinite(self.tilt))

    def that_count(self) -> "Errors":
        """The samples that figures are made of: compared, and after the time left out."""
        return self.where(self.counted & np.isfinite(self.tilt))


class ErrorLog:
    """Takes the compared attitudes of a flight, of filters and autopilot alike."""

    def __init__(self) -> None:
        self._columns: Final[dict[str, array[float]]] = {}

    def write(self, compared: ComparedAttitude) -> None:
        """Take the next one."""
        attitude = compared.attitude
        self._columns.setdefault(compared.name, array("d")).extend(
            (
                attitude.elapsed_s,
                nan if compared.tilt is None else compared.tilt,
                nan if compared.heading is None else compared.heading,
                attitude.tilt_sigma,
                attitude.heading_sigma,
                float(attitude.counted),
            )
        )

    def errors(self) -> dict[str, Errors]:
        """By the name of filter or autopilot."""
        return {name: _errors(column) for name, column in self._columns.items()}


def _errors(flat: "array[float]") -> Errors:
    table = np.array(flat).reshape(-1, 6)
    t_s, tilt, heading, tilt_sigma, heading_sigma, counted = table.T
    return Errors(
        t_s, np.degrees(tilt), np.degrees(heading), np.degrees(tilt_sigma), np.degrees(heading_sigma), counted > 0.0
    )


@dataclass(frozen=True)
class Chosen:
    """A filter by its name, with parameters of the flight filter that differ from its defaults."""

    name: str
    parameters: Mapping[str, float] = field(default_factory=dict)

    def build(self) -> AttitudeFilter:
        """The filter; UsageError when name or parameter is not known."""
        one = default_filter(self.name)
        if not self.parameters:
            return one
        if not isinstance(one, VelocityAided):
            raise UsageError(f"--set is for velocity-aided; {self.name} has none of its parameters")
        try:
            return VelocityAided(replace(one.parameters, **self.parameters))
        except TypeError:
            known = [each.name for each in fields(FlightParameters)]
            unknown = ", ".join(sorted(set(self.parameters) - set(known)))
            raise UsageError(f"--set {unknown}: unknown parameter; expected of {', '.join(known)}") from None


@dataclass(frozen=True)
class Trial:
    """One filter over one edited recording.

    log: the bytes of the tlog, so that a trial can go to any process. skip_s: time left out of the figures.
    """

    log: bytes = field(repr=False)
    one: Chosen
    edit: Edit
    skip_s: float = 30.0


@dataclass(frozen=True)
class Flown:
    """Errors of the filter, and of the autopilot where the log has its attitude beside the reference."""

    ours: Errors
    autopilot: Errors


@lru_cache(maxsize=1)
def recorded(log: bytes) -> Recording:
    """The log decoded; trials of one log follow each other, so that each process decodes it once."""
    return record(open_tlog(log))


def flown(trial: Trial) -> Flown:
    """Run a trial."""
    recording = recorded(trial.log)
    samples = trial.edit(recording.samples, recording.plan.imu)
    return fly(recording, samples, trial.one.build(), Window(skip_s=trial.skip_s))


def fly(recording: Recording, samples: Sequence[Sample], one: AttitudeFilter, window: Window) -> Flown:
    """Run a filter over samples made of a recording, exactly as a replay would."""
    field = recording.earth_field
    log = ErrorLog()
    flight = Flight(
        recording.plan,
        [one.with_vehicle_settings(recording.settings)],
        EarthField() if field is None else field.direction,
        window,
        sink=log,
    )
    for sample in samples:
        flight.take(sample)
    flight.finish()
    errors = log.errors()
    nothing = _errors(array("d"))
    return Flown(errors.get(one.name, nothing), errors.get(AUTOPILOT, nothing))

"""The parts of a study, by name; each gives the lines of a table."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from attest_mav.evaluation.flight_study.disturbances import (
    measure_iron,
    measure_rates,
    measure_sensors,
)
from attest_mav.evaluation.flight_study.edits import WHOLE
from attest_mav.evaluation.flight_study.figures import Figures, Line, accuracy, at_least, at_most, honesty, rms
from attest_mav.evaluation.flight_study.flying import Chosen, Errors, Trial, flown
from attest_mav.evaluation.flight_study.outages import LENGTHS_S, measure_outages
from attest_mav.evaluation.flight_study.peers import peer_flown
from attest_mav.evaluation.flight_study.starts import measure_starts
from attest_mav.evaluation.harness import Bound, TrialMap
from attest_mav.filters.registry import filter_names

HONEST: Final = {"tilt in 3s %": at_least(99.0), "heading in 3s %": at_least(99.0)}
MAIN_LIMITS: Final[Mapping[str, Mapping[str, Bound]]] = {
    "copter_square": {"tilt rms": at_most(0.10), "heading rms": at_most(0.25)},
    "plane_circles": {"tilt rms": at_most(0.16), "heading rms": at_most(0.30)},
    "vtol_4hz": {"tilt rms": at_most(2.5), "heading rms": at_most(2.5), "rms at s<1": at_most(0.7)},
}
"""Of the flight filter, by the name of the log."""
CERTAIN_DEG: Final = 1.0
"""Tilt sigma below which an estimate calls itself certain."""


@dataclass(frozen=True)
class Study:
    """The logs and parts of a study.

    name: of the log without its folder and ending. airspeed: outages leave it. each: every start and
    outage has a line of its own too. peers: others in the main table.
    """

    log: bytes
    name: str
    one: Chosen
    starts: int
    seeds: int
    airspeed: bool
    each: bool = False
    peers: Sequence[str] = ()


Part = Callable[[Study, TrialMap], list[Line]]


def main_table(study: Study, trial_map: TrialMap) -> list[Line]:
    """All our filters beside the autopilot and the peers, over the recording as it is."""
    names = [study.one.name, *(name for name in filter_names() if name != study.one.name)]
    choices = [study.one, *(Chosen(name) for name in names[1:])]
    results = list(trial_map(flown, [Trial(study.log, one, WHOLE) for one in choices]))
    limits = {**HONEST, **MAIN_LIMITS.get(study.name, {})}
    autopilot = accuracy(results[0].autopilot.that_count())
    lines = [Line("autopilot, on truth" if autopilot["tilt max"] == 0.0 else "autopilot", autopilot)]
    for one, result in zip(choices, results, strict=True):
        limited = limits if one.name == "velocity-aided" else {}
        lines.append(Line(one.name, main_figures(result.ours.that_count()), limited))
    peers = trial_map(peer_flown, [(study.log, name) for name in study.peers])
    lines += [Line(name, accuracy(errors.that_count())) for name, errors in zip(study.peers, peers, strict=True)]
    return lines


def main_figures(errors: Errors) -> Figures:
    """Accuracy, honesty, and accuracy where the filter calls itself certain."""
    certain = errors.tilt_sigma < CERTAIN_DEG
    share = 100.0 * float(np.mean(certain)) if len(certain) else np.nan
    return accuracy(errors) | honesty(errors) | {"rms at s<1": rms(errors.tilt[certain]), "s<1 %": share}


def _starts(study: Study, trial_map: TrialMap) -> list[Line]:
    lines = measure_starts(study.log, study.one, study.starts, trial_map)
    return lines if study.each else lines[:1]


def _outages(study: Study, trial_map: TrialMap) -> list[Line]:
    lines = measure_outages(study.log, study.one, trial_map, airspeed=study.airspeed)
    return lines if study.each else lines[: len(LENGTHS_S)]


def _sensors(study: Study, trial_map: TrialMap) -> list[Line]:
    return measure_sensors(study.log, study.one, study.seeds, trial_map)


def _rates(study: Study, trial_map: TrialMap) -> list[Line]:
    return measure_rates(study.log, study.one, trial_map)


def _iron(study: Study, trial_map: TrialMap) -> list[Line]:
    return measure_iron(study.log, study.one, trial_map)


PARTS: Final[Mapping[str, Part]] = {
    "main": main_table,
    "starts": _starts,
    "outage": _outages,
    "sensors": _sensors,
    "rates": _rates,
    "iron": _iron,
}
"""In the order in which they are shown."""

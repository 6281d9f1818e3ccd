"""Starts in the middle of turns: how long a filter without history takes to find the attitude."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import inf, nan
from typing import Final

import numpy as np

from attest_mav.evaluation.flight_study.edits import between
from attest_mav.evaluation.flight_study.figures import Line, at_most
from attest_mav.evaluation.flight_study.flights import evenly, is_fast, turn_tilt_deg, turning_times
from attest_mav.evaluation.flight_study.flying import Chosen, Errors, Trial, flown, recorded
from attest_mav.evaluation.harness import Bound, TrialMap

FOUND_DEG: Final = 2.0
"""A tilt error below this,"""
STAYS_S: Final = 2.0
"""for this long, is an attitude that was found."""
CAP_S: Final = 60.0
"""After so long it is never found."""
SOON_S: Final = 12.0
"""Nearly every start is over by then; only the others are flown to the cap."""
LEAST_LEFT_S: Final = 20.0
"""Starts nearer to the end of the log would show nothing."""
LIMITS: Final[Mapping[str, Bound]] = {"median s": at_most(1.5), "p90 s": at_most(4.0), "never %": at_most(0.0)}


@dataclass(frozen=True)
class Start:
    """One start at a time of the log, s. found_s: until the attitude was found, infinite if it was not.

    heading: its error then; first_s, first_tilt: time and tilt error of the first output. Degrees.
    """

    at_s: float
    found_s: float
    heading: float
    first_s: float
    first_tilt: float


def measure_starts(log: bytes, one: Chosen, count: int, trial_map: TrialMap) -> list[Line]:
    """A line for so many starts, evenly spread over the turns of the flight, and one for each of them."""
    recording = recorded(log)
    times = evenly(turning_times(recording, turn_tilt_deg(recording), LEAST_LEFT_S), count)
    starts = dict(_start_all(log, one, times, SOON_S, trial_map))
    missing = [at_s for at_s in times if starts[at_s].found_s == inf]
    starts.update(_start_all(log, one, missing, CAP_S, trial_map))
    limits = LIMITS if is_fast(recording) else {}
    each = [summary(f"start at {at_s:.1f} s", [starts[at_s]], {}) for at_s in times]
    return [summary(f"{len(times)} starts in turns", list(starts.values()), limits), *each]


def _start_all(
    log: bytes, one: Chosen, times: Sequence[float], cap_s: float, trial_map: TrialMap
) -> Iterable[tuple[float, Start]]:
    """The starts at these times, each flown for the cap and a little longer."""
    trials = [
        Trial(log, one, partial(between, from_s=at_s, to_s=at_s + cap_s + STAYS_S + 0.5), skip_s=0.0) for at_s in times
    ]
    for at_s, result in zip(times, trial_map(flown, trials), strict=True):
        yield at_s, start_of(at_s, result.ours)


def start_of(at_s: float, errors: Errors) -> Start:
    """Time to an attitude, and its errors, of a flight that began there."""
    compared = errors.where(np.isfinite(errors.tilt))
    if not len(compared.t_s):
        return Start(at_s, inf, nan, nan, nan)
    first = (float(compared.t_s[0]), float(compared.tilt[0]))
    wrong = compared.t_s[compared.tilt >= FOUND_DEG]
    for place in range(len(compared.t_s)):
        found_s = float(compared.t_s[place])
        if found_s > CAP_S or found_s + STAYS_S > compared.t_s[-1]:
            break
        if not np.any((wrong >= found_s) & (wrong <= found_s + STAYS_S)):
            return Start(at_s, found_s, float(compared.heading[place]), *first)
    return Start(at_s, inf, nan, *first)


def summary(label: str, starts: Sequence[Start], limits: Mapping[str, Bound]) -> Line:
    """A line of the table."""
    found = np.array([start.found_s for start in starts])
    capped = np.minimum(found, CAP_S)
    first = np.array([start.first_tilt for start in starts])
    heading = np.abs([start.heading for start in starts])
    figures = {
        "median s": _statistic(capped, 50.0),
        "p90 s": _statistic(capped, 90.0),
        "max s": _statistic(capped, 100.0),
        "never %": 100.0 * float(np.mean(np.isinf(found))) if len(found) else nan,
        "first output s": _statistic(np.array([start.first_s for start in starts]), 50.0),
        "its tilt": _statistic(first, 50.0),
        "heading then": _statistic(heading, 50.0),
        "heading max": _statistic(heading, 100.0),
    }
    return Line(label, figures, limits)


def _statistic(values: "np.ndarray[tuple[int], np.dtype[np.float64]]", percent: float) -> float:
    known = values[~np.isnan(values)]
    return float(np.percentile(known, percent)) if len(known) else nan

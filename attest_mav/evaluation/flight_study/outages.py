"""Outages of the velocity in flight: how far the attitude drifts without it."""

from collections.abc import Mapping, Sequence
from functools import partial
from math import nan
from typing import Final

import numpy as np

from attest_mav.evaluation.flight_study.edits import between, without_velocity
from attest_mav.evaluation.flight_study.figures import Line, at_most, largest, share_within
from attest_mav.evaluation.flight_study.flights import LEARNT_S, flying_interval, is_fast
from attest_mav.evaluation.flight_study.flying import Chosen, Errors, Trial, flown, recorded
from attest_mav.evaluation.harness import Bound, TrialMap
from attest_mav.samples import Sample

LENGTHS_S: Final = (10.0, 30.0, 60.0)
SPACING_S: Final = 15.0
LIMITS: Final[Mapping[float, Mapping[str, Bound]]] = {30.0: {"at end, worst": at_most(1.2)}}
"""By length; on logs of usual rates."""


def measure_outages(
    log: bytes, one: Chosen, trial_map: TrialMap, *, airspeed: bool = True, lengths_s: Sequence[float] = LENGTHS_S
) -> list[Line]:
    """A line for each length, of outages that begin every 15 s of flight, and then one for each outage."""
    recording = recorded(log)
    first_s, last_s = flying_interval(recording)
    first_s = max(first_s, LEARNT_S)
    cases = [
        (length_s, float(start_s))
        for length_s in lengths_s
        for start_s in np.arange(first_s, last_s - length_s, SPACING_S)
    ]
    trials = [
        Trial(log, one, partial(outage, from_s=start_s, to_s=start_s + length_s, airspeed=airspeed), skip_s=0.0)
        for length_s, start_s in cases
    ]
    limits = LIMITS if is_fast(recording) else {}
    outages = [
        (length_s, start_s, flight.ours.between(start_s, start_s + length_s))
        for (length_s, start_s), flight in zip(cases, trial_map(flown, trials), strict=True)
    ]
    compared = [one_of for one_of in outages if len(one_of[2].tilt)]
    lines = [
        _outage_line(
            f"no velocity for {length_s:g} s",
            [errors for of_s, _, errors in compared if of_s == length_s],
            limits.get(length_s, {}),
        )
        for length_s in lengths_s
    ]
    return lines + [
        _outage_line(f"{length_s:g} s from {start_s:.1f} s", [errors], {}) for length_s, start_s, errors in compared
    ]


def outage(samples: Sequence[Sample], imu: str, *, from_s: float, to_s: float, airspeed: bool) -> list[Sample]:
    """The flight until the outage ends."""
    flight = between(samples, imu, from_s=0.0, to_s=to_s + 0.5)
    return without_velocity(flight, imu, from_s=from_s, to_s=to_s, airspeed=airspeed)


def _outage_line(label: str, outages: Sequence[Errors], limits: Mapping[str, Bound]) -> Line:
    """Of some outages, by the errors during each."""
    ends = np.array([errors.tilt[-1] for errors in outages])
    honest = np.array([share_within(errors.tilt, errors.tilt_sigma, 3.0) for errors in outages])
    figures = {
        "starts": float(len(outages)),
        "tilt at end, mean": float(np.mean(ends)) if len(ends) else nan,
        "at end, worst": largest(ends),
        "during, worst": largest(np.array([largest(errors.tilt) for errors in outages])),
        "heading, worst": largest(np.array([largest(errors.heading) for errors in outages])),
        "tilt in 3s %": float(np.mean(honest)) if len(honest) else nan,
        "outages all in 3s %": 100.0 * float(np.mean(honest == 100.0)) if len(honest) else nan,
    }
    return Line(label, figures, limits)

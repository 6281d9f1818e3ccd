"""Flights with something amiss: worse sensors, fewer samples, iron beside the magnetometer."""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Final

import numpy as np

from attest_mav.evaluation.flight_study.edits import decimated, with_iron
from attest_mav.evaluation.flight_study.figures import (
    Figures,
    Line,
    accuracy,
    at_most,
    honesty,
    largest,
    p95,
    rms,
    share_within,
)
from attest_mav.evaluation.flight_study.flights import LEARNT_S, flying_interval, is_fast, rate_hz
from attest_mav.evaluation.flight_study.flying import Chosen, Errors, Trial, flown, recorded
from attest_mav.evaluation.flight_study.sensor_errors import SETS, with_sensor_errors
from attest_mav.evaluation.harness import Bound, TrialMap

SENSOR_LIMITS: Final = {"typical": {"tilt rms": at_most(0.45), "heading rms": at_most(1.5)}}
RATES_HZ: Final = (25.0, 10.0, 5.0, 4.0, 2.0)
IRON_MILLIGAUSS: Final = (30, 60, 100, 200)
IRON_S: Final = 60.0
AFTERMATH_S: Final = 30.0
"""s. The errors are recorded for so long after an offset has ended."""


def measure_sensors(
    log: bytes, one: Chosen, seeds: int, trial_map: TrialMap, names: Sequence[str] = tuple(SETS)
) -> list[Line]:
    """A line for each set of sensors: figures over all seeds, and the worst seed's."""
    cases = [(name, seed) for name in names for seed in range(1, seeds + 1)]
    trials = [Trial(log, one, partial(with_sensor_errors, errors=SETS[name], seed=seed)) for name, seed in cases]
    results = list(zip(cases, trial_map(flown, trials), strict=True))
    limits = SENSOR_LIMITS if is_fast(recorded(log)) else {}
    return [
        _sensor_line(
            name, [result.ours.that_count() for (of, _), result in results if of == name], limits.get(name, {})
        )
        for name in names
    ]


def _sensor_line(name: str, flights: Sequence[Errors], limits: Mapping[str, Bound]) -> Line:
    """Of one set of sensors, by the errors of each seed."""
    tilt = np.concatenate([errors.tilt for errors in flights])
    heading = np.concatenate([errors.heading for errors in flights])
    tilt_sigma = np.concatenate([errors.tilt_sigma for errors in flights])
    heading_sigma = np.concatenate([errors.heading_sigma for errors in flights])
    figures = {
        "tilt rms": rms(tilt),
        "tilt p95": p95(tilt),
        "tilt max": largest(tilt),
        "heading rms": rms(heading),
        "worst tilt rms": max(rms(errors.tilt) for errors in flights),
        "worst heading rms": max(rms(errors.heading) for errors in flights),
        "tilt in 3s %": share_within(tilt, tilt_sigma, 3.0),
        "heading in 3s %": share_within(heading, heading_sigma, 3.0),
    }
    return Line(f"{name} sensors, {len(flights)} seeds", figures, limits)


def measure_rates(log: bytes, one: Chosen, trial_map: TrialMap) -> list[Line]:
    """A line for each rate below the log's own."""
    rates = [rate for rate in RATES_HZ if rate < 0.9 * rate_hz(recorded(log))]
    trials = [Trial(log, one, partial(decimated, rate_hz=rate)) for rate in rates]
    lines = []
    for rate, result in zip(rates, trial_map(flown, trials), strict=True):
        errors = result.ours.that_count()
        lines.append(Line(f"{rate:g} Hz", accuracy(errors) | honesty(errors)))
    return lines


def measure_iron(log: bytes, one: Chosen, trial_map: TrialMap) -> list[Line]:
    """A line for each offset: the worst of three 60 s of the flight, with what follows them."""
    first_s, last_s = flying_interval(recorded(log))
    room_s = max(0.0, last_s - IRON_S - max(first_s, LEARNT_S))
    starts = [max(first_s, LEARNT_S) + share * room_s for share in (0.0, 0.5, 1.0)]
    cases = [(strength, start_s) for strength in IRON_MILLIGAUSS for start_s in starts]
    trials = [
        Trial(log, one, partial(with_iron, from_s=start_s, to_s=start_s + IRON_S, gauss=1e-3 * strength))
        for strength, start_s in cases
    ]
    results = list(zip(cases, trial_map(flown, trials), strict=True))
    return [
        Line(
            f"{strength} mG on x for {IRON_S:g} s",
            _iron_figures(
                [
                    result.ours.between(start_s, start_s + IRON_S + AFTERMATH_S)
                    for (of, start_s), result in results
                    if of == strength
                ]
            ),
        )
        for strength in IRON_MILLIGAUSS
    ]


def _iron_figures(flights: Sequence[Errors]) -> Figures:
    honest = [share_within(errors.tilt, errors.tilt_sigma, 3.0) for errors in flights]
    honest_heading = [share_within(errors.heading, errors.heading_sigma, 3.0) for errors in flights]
    return {
        "heading, worst": max(largest(errors.heading) for errors in flights),
        "tilt, worst": max(largest(errors.tilt) for errors in flights),
        "tilt in 3s %": float(np.nanmean(honest)),
        "heading in 3s %": float(np.nanmean(honest_heading)),
    }

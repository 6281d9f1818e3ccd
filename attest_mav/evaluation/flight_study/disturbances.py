"""Flights with something amiss: velocity withheld, worse sensors, fewer samples, iron beside the magnetometer."""

from collections.abc import Sequence
from functools import partial
from typing import Final

import numpy as np

from attest_mav.evaluation.flight_study.edits import between, decimated, with_iron, without_velocity
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
from attest_mav.evaluation.flight_study.flights import FAST_HZ, flying_interval, rate_hz
from attest_mav.evaluation.flight_study.flying import Chosen, Errors, Trial, flown, recorded
from attest_mav.evaluation.flight_study.sensor_errors import SETS, with_sensor_errors
from attest_mav.evaluation.harness import TrialMap
from attest_mav.types import Sample

OUTAGES_S: Final = (10.0, 30.0, 60.0)
OUTAGE_SPACING_S: Final = 15.0
LEARNT_S: Final = 60.0
"""The first outage begins no sooner: the biases are learnt by then."""
OUTAGE_LIMITS: Final = {30.0: at_most(1.2)}
"""Of the tilt error at the end of the worst outage of that length."""
SENSOR_LIMITS: Final = {"typical": {"tilt rms": at_most(0.45), "heading rms": at_most(1.5)}}
RATES_HZ: Final = (25.0, 10.0, 5.0, 4.0, 2.0)
IRON_MILLIGAUSS: Final = (30, 60, 100, 200)
IRON_S: Final = 60.0
AFTERMATH_S: Final = 30.0
"""What an offset has done is followed for so long after it is gone."""


def measure_outages(
    log: bytes, one: Chosen, trial_map: TrialMap, *, airspeed: bool = True, lengths_s: Sequence[float] = OUTAGES_S
) -> list[Line]:
    """A line for each length: outages that begin every 15 s of flight."""
    recording = recorded(log)
    first_s, last_s = flying_interval(recording)
    first_s = max(first_s, LEARNT_S)
    cases = [
        (length_s, float(start_s))
        for length_s in lengths_s
        for start_s in np.arange(first_s, last_s - length_s, OUTAGE_SPACING_S)
    ]
    trials = [
        Trial(log, one, partial(outage, from_s=start_s, to_s=start_s + length_s, airspeed=airspeed), skip_s=0.0)
        for length_s, start_s in cases
    ]
    results = list(zip(cases, trial_map(flown, trials), strict=True))
    return [
        _outage_line(
            length_s,
            [result.ours.between(start_s, start_s + length_s) for (length, start_s), result in results if length == length_s],
        )
        for length_s in lengths_s
    ]


def outage(samples: Sequence[Sample], imu: str, *, from_s: float, to_s: float, airspeed: bool) -> list[Sample]:
    """The flight until the outage ends."""
    flight = between(samples, imu, from_s=0.0, to_s=to_s + 0.5)
    return without_velocity(flight, imu, from_s=from_s, to_s=to_s, airspeed=airspeed)


def _outage_line(length_s: float, outages: Sequence[Errors]) -> Line:
    """Of outages of one length, by the errors during each."""
    ends = np.array([errors.tilt[-1] for errors in outages if len(errors.tilt)])
    worst = np.array([largest(errors.tilt) for errors in outages])
    headings = np.array([largest(errors.heading) for errors in outages])
    honest = np.array([share_within(errors.tilt, errors.tilt_sigma, 3.0) for errors in outages])
    figures = {
        "starts": float(len(outages)),
        "tilt at end, mean": float(np.mean(ends)) if len(ends) else np.nan,
        "at end, worst": largest(ends),
        "during, worst": largest(worst),
        "heading, worst": largest(headings),
        "tilt in 3s %": float(np.nanmean(honest)) if len(honest) else np.nan,
    }
    limits = {"at end, worst": OUTAGE_LIMITS[length_s]} if length_s in OUTAGE_LIMITS else {}
    return Line(f"no velocity for {length_s:g} s", figures, limits)


def measure_sensors(
    log: bytes, one: Chosen, seeds: int, trial_map: TrialMap, names: Sequence[str] = tuple(SETS)
) -> list[Line]:
    """A line for each set of sensors: figures over all seeds, and the worst seed's."""
    cases = [(name, seed) for name in names for seed in range(1, seeds + 1)]
    trials = [Trial(log, one, partial(with_sensor_errors, errors=SETS[name], seed=seed)) for name, seed in cases]
    results = list(zip(cases, trial_map(flown, trials), strict=True))
    is_fast = rate_hz(recorded(log)) >= FAST_HZ
    return [
        _sensor_line(name, [result.ours.that_count() for (of, _), result in results if of == name], is_fast)
        for name in names
    ]


def _sensor_line(name: str, flights: Sequence[Errors], is_fast: bool) -> Line:
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
    return Line(f"{name} sensors, {len(flights)} seeds", figures, SENSOR_LIMITS.get(name, {}) if is_fast else {})


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
        Line(f"{strength} mG on x for {IRON_S:g} s", _iron_figures([
            result.ours.between(start_s, start_s + IRON_S + AFTERMATH_S)
            for (of, start_s), result in results
            if of == strength
        ]))
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

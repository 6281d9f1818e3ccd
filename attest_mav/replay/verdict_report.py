"""The verdict over a log, and its inertial streams with their faults, as parts of the JSON object of the contract."""

from math import degrees, isfinite
from typing import Any, Final

from attest_mav.estimation.events import Agreement
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.replay.flight import FilterRun, Flight
from attest_mav.replay.log_time import Regularity
from attest_mav.replay.verdict_log import LoggedInterval

DIGITS: Final = 6
"""Decimals of a degree, a second or a hertz: more than any of them is good for."""

MILLISECOND: Final = 3
"""Decimals of a UTC in seconds."""


def judge_of(flight: Flight) -> FilterRun:
    """The filter whose verdict counts: the flight filter, whose sigma covers its errors, else the first one."""
    return next((run for run in flight.runs if isinstance(run.one, VelocityAided)), flight.runs[0])


def verdict_of(flight: Flight) -> dict[str, Any]:
    """The verdict on the autopilot's attitude beside one filter, in log time."""
    judge = judge_of(flight)
    settings = judge.settings.verdict
    intervals = judge.verdicts.intervals
    return {
        "filter": judge.comparison.name,
        "thresholds": {
            "tilt_deg": round(degrees(settings.tilt), DIGITS),
            "proven_tilt_deg": round(degrees(settings.proven_tilt), DIGITS),
            "hold_s": settings.hold_s,
        },
        **{
            f"{agreement.name.lower()}_s": round(
                sum([one.end_s - one.begin_s for one in intervals if one.interval.agreement == agreement], 0.0),
                DIGITS,
            )
            for agreement in (Agreement.AGREE, Agreement.DISAGREE, Agreement.UNDECIDED)
        },
        "intervals": [_interval(one, flight) for one in intervals],
    }


def lanes_of(flight: Flight) -> list[dict[str, Any]]:
    """The inertial streams that the judging filter has used, and their faults."""
    faults = judge_of(flight).faults.faults
    return [
        {
            **stream(message, regularity),
            "faults": [
                {
                    "kind": fault.kind,
                    "text": fault.text,
                    "start_s": round(fault.begin_s, DIGITS),
                    "end_s": None if fault.end_s is None else round(fault.end_s, DIGITS),
                }
                for fault in faults
                if fault.lane == message
            ],
        }
        for message, regularity in flight.sensors.items()
    ]


def stream(message: str, regularity: Regularity) -> dict[str, Any]:
    """Samples, rate and gaps of one inertial stream."""
    rate_hz, gaps = regularity.rate_and_gaps()
    return {
        "message": message,
        "samples": regularity.samples,
        "rate_hz": None if rate_hz is None else round(rate_hz, DIGITS),
        "gaps": gaps,
    }


def unix_time(flight: Flight, elapsed_s: float) -> float | None:
    """UTC at a log time, s since 1970; None where the log does not tell it."""
    unix_s = flight.clock.unix_s(elapsed_s)
    return None if unix_s is None else round(unix_s, MILLISECOND)


def _interval(one: LoggedInterval, flight: Flight) -> dict[str, Any]:
    return {
        "state": one.interval.agreement.name.lower(),
        "reason": one.interval.reason,
        "start_s": round(one.begin_s, DIGITS),
        "end_s": round(one.end_s, DIGITS),
        "start_unix_s": unix_time(flight, one.begin_s),
        "end_unix_s": unix_time(flight, one.end_s),
        "peak_tilt_deg": _angle(one.interval.peak_tilt),
        "peak_heading_deg": _angle(one.interval.peak_heading),
        "sensors": list(one.interval.lanes),
        "autopilot_reports": list(one.reports),
    }


def _angle(angle: float) -> float | None:
    """Degrees; None where nothing was compared."""
    return round(degrees(angle), DIGITS) if isfinite(angle) else None

"""The result of a replay as the JSON object of the contract."""

from math import inf
from typing import Any

from attest_mav.replay.comparison import Comparison
from attest_mav.replay.consistency import Consistency, NisMean, SigmaCount
from attest_mav.replay.engine import Replay
from attest_mav.replay.flight import Flight
from attest_mav.replay.metrics import ErrorColumns, Spread
from attest_mav.replay.peaks import Peak
from attest_mav.replay.plan import replayable
from attest_mav.replay.verdict_report import DIGITS, lanes_of, stream, unix_time, verdict_of


def as_json(name: str, replay: Replay) -> dict[str, Any]:
    """The object that ``replay --json`` prints for the log called ``name``."""
    summary, plan, flight, window = replay.summary, replay.plan, replay.flight, replay.flight.window
    return {
        "log": name,
        "format": summary.log_format,
        "frames": summary.messages,
        "bad_bytes": summary.bad_bytes,
        "duration_s": round(summary.duration_s, DIGITS),
        "vehicle": {"system": plan.vehicle[0], "component": plan.vehicle[1]},
        "vehicles": [
            {"system": one.vehicle[0], "component": one.vehicle[1], "samples": one.count(plan.imu)}
            for one in replayable(summary)
        ],
        "imu": stream(plan.imu, flight.imu),
        "lanes": lanes_of(flight),
        "north": _north(replay),
        "window": {
            "start_s": window.start_s,
            "end_s": None if window.end_s == inf else window.end_s,
            "skip_s": window.skip_s,
        },
        "reference": None
        if plan.reference is None
        else {"message": plan.reference, "samples": flight.reference_samples, "sigma": _reference_sigma(flight)},
        "filters": [_filter(run.comparison, flight) for run in flight.runs],
        "smoothed": _smoothed(flight),
        "autopilot": None
        if flight.autopilot is None
        else {"message": plan.autopilot, **_errors(flight.autopilot, flight)},
        "verdict": verdict_of(flight),
        "notes": list(replay.notes),
    }


def _reference_sigma(flight: Flight) -> dict[str, Any] | None:
    """The reference's own 1-sigma over the samples that count; None for one that is a message."""
    run = flight.smoothed
    if run is None or not run.is_reference:
        return None
    sigmas = run.sigmas
    return {"tilt_deg": _spread(sigmas.tilt()), "heading_deg": _spread(sigmas.heading()), "unsure": run.unsure}


def _smoothed(flight: Flight) -> dict[str, Any] | None:
    """The smoothed attitude: its class of noise, and its figures where it is compared with another reference."""
    run = flight.smoothed
    if run is None:
        return None
    return {"noise": run.noise, **_filter(run.comparison, flight)}


def _north(replay: Replay) -> dict[str, Any]:
    """The north that headings refer to, and the source of the declination."""
    field = replay.earth_field
    if field is None:
        return {"reference": "magnetic", "declination_deg": None, "source": None}
    return {
        "reference": "true",
        "declination_deg": round(field.declination_deg, DIGITS),
        "source": field.source,
    }


def _filter(comparison: Comparison, flight: Flight) -> dict[str, Any]:
    """One filter's figures, and the consistency of its sigmas; null for a filter without sigmas."""
    has_sigma = comparison.consistency.has_sigma
    return {
        "name": comparison.name,
        **_errors(comparison, flight),
        "not_compared": {"no_reference": comparison.outside, "uneven_reference": comparison.uneven},
        "valid": _valid(comparison.errors) if has_sigma and comparison.errors.samples else None,
        "consistency": _consistency(comparison.consistency) if has_sigma else None,
    }


def _valid(errors: ErrorColumns) -> dict[str, Any]:
    """Share of the samples with a tilt sigma below ``metrics.SURE``, and the tilt error of these."""
    return {"share": round(errors.sure_samples / errors.samples, DIGITS), "tilt_deg": _spread(errors.sure_tilt())}


def _consistency(consistency: Consistency) -> dict[str, Any]:
    return {
        "tilt": _sigma_shares(consistency.tilt),
        "heading": _sigma_shares(consistency.heading),
        "nis": {"velocity": _nis(consistency.velocity), "magnetometer": _nis(consistency.magnetometer)},
    }


def _sigma_shares(count: SigmaCount) -> dict[str, float] | None:
    """Shares of errors within 1, 2 and 3 sigma, and the rms of error / sigma; None without errors."""
    if not count.samples:
        return None
    one, two, three = count.within
    return {
        "within_1": round(one, DIGITS),
        "within_2": round(two, DIGITS),
        "within_3": round(three, DIGITS),
        "rms": round(count.rms, DIGITS),
    }


def _nis(nis: NisMean) -> dict[str, Any] | None:
    """Mean normalised innovation squared, and their number; None without innovations."""
    return {"mean": round(nis.mean, DIGITS), "n": nis.count} if nis.count else None


def _errors(comparison: Comparison, flight: Flight) -> dict[str, Any]:
    errors = comparison.errors
    return {
        "samples": errors.samples,
        "tilt_deg": _with_peak(errors.tilt(), comparison.tilt_peak, flight),
        "heading_deg": _with_peak(errors.heading(), comparison.heading_peak, flight),
    }


def _with_peak(spread: Spread | None, peak: Peak, flight: Flight) -> dict[str, Any] | None:
    """Figures, with the log time, the UTC and the phase of the largest error."""
    figures = _spread(spread)
    if figures is None:
        return None
    return {
        **figures,
        "max_at_s": round(peak.at_s, DIGITS),
        "max_at_unix_s": unix_time(flight, peak.at_s),
        "max_phase": flight.phases.at(peak.at_s).words,
    }


def _spread(spread: Spread | None) -> dict[str, float] | None:
    """Figures; None if nothing could be compared."""
    if spread is None:
        return None
    return {"rms": round(spread.rms, DIGITS), "p95": round(spread.p95, DIGITS), "max": round(spread.max, DIGITS)}

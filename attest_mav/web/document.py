"""A snapshot as JSON: the names of its fields, angles in degrees, times in seconds, enums as words.

Times that end in ``_s`` and are no spans refer to the host's monotonic clock, as ``now_s`` does. Values that are not
known are null.
"""

from collections.abc import Callable
from dataclasses import fields, is_dataclass
from enum import IntEnum
from math import degrees, isfinite
from typing import Any, Final

import msgspec

from attest_mav.algebra import q_to_euler
from attest_mav.estimate import Estimate
from attest_mav.estimation.events import Verdict
from attest_mav.innovation import Innovation
from attest_mav.service.snapshot import Snapshot
from attest_mav.service.status import STATE_NAMES, obstacles
from attest_mav.service.vehicle_records import AidSnapshot
from attest_mav.service.verdict_records import AutopilotAttitude, VerdictSpan, VerdictStanding
from attest_mav.types import EarthField, Quat
from attest_mav.vehicle_settings import Setting, VehicleSettings
from attest_mav.web.health import ailments


def document_of(snapshot: Snapshot) -> dict[str, Any]:
    """The whole snapshot in values that JSON knows."""
    plain = {one.name: getattr(snapshot, one.name) for one in fields(snapshot)}
    plain["now_s"] = plain.pop("now_ns") * 1e-9
    plain["state"] = STATE_NAMES.get(snapshot.state, "unknown").lower()
    plain["tilt_threshold_deg"] = _angle(plain.pop("tilt_threshold"))
    plain["ailments"] = ailments(snapshot)
    plain["obstacles"] = [] if snapshot.published_lane else obstacles(snapshot)
    return {name: _plain(value) for name, value in plain.items()}


def encoded(snapshot: Snapshot) -> bytes:
    """The document in UTF-8, on one line."""
    return msgspec.json.encode(document_of(snapshot))


def _plain(value: object) -> Any:
    """A value in the types of JSON."""
    known = _RECORDS.get(type(value))
    if known is not None:
        return _plain(known(value))
    if isinstance(value, IntEnum):
        return value.name.lower()
    if isinstance(value, float):
        return float(f"{value:.9g}") if isfinite(value) else None
    if is_dataclass(value) and not isinstance(value, type):
        value = {one.name: getattr(value, one.name) for one in fields(value)}
    if isinstance(value, dict):
        return {name: _plain(one) for name, one in value.items()}
    if isinstance(value, frozenset):
        value = sorted(value)
    return [_plain(one) for one in value] if isinstance(value, tuple | list) else value


def _angle(rad: float | None) -> float | None:
    return None if rad is None else degrees(rad)


def _attitude(q_nb: Quat) -> dict[str, object]:
    roll, pitch, yaw = (degrees(angle) for angle in q_to_euler(q_nb))
    return {"q_nb": q_nb, "roll_deg": roll, "pitch_deg": pitch, "yaw_deg": yaw % 360.0}


def _estimate(estimate: Estimate) -> dict[str, object]:
    return _attitude(estimate.q_nb) | {
        "filter": estimate.filter_name,
        "received_s": estimate.rx_ns * 1e-9,
        "north": estimate.north,
        "rates_degps": tuple(degrees(one) for one in estimate.rates),
        "tilt_sigma_deg": degrees(estimate.tilt_sigma),
        "heading_sigma_deg": degrees(estimate.heading_sigma),
        "delay_s": estimate.delay_s,
        "innovations": estimate.innovations,
    }


def _innovation(one: Innovation) -> dict[str, object]:
    return {"aid": one.aid, "fusion": one.fusion, "residual": one.residual, "variance": one.variance, "nis": one.nis}


def _aid(one: AidSnapshot) -> dict[str, object]:
    return _innovation(one.innovation) | {"received_s": one.rx_ns * 1e-9}


def _verdict(verdict: Verdict) -> dict[str, object]:
    return {
        "agreement": verdict.agreement,
        "reason": verdict.reason,
        "tilt_deg": degrees(verdict.tilt),
        "heading_deg": degrees(verdict.heading),
        "source": verdict.source,
        "received_s": verdict.rx_ns * 1e-9,
    }


def _standing(standing: VerdictStanding) -> dict[str, object]:
    return _verdict(standing.verdict) | {"since_s": standing.since_ns * 1e-9}


def _span(span: VerdictSpan) -> dict[str, object]:
    return {
        "agreement": span.agreement,
        "reason": span.reason,
        "begin_s": span.begin_ns * 1e-9,
        "end_s": span.end_ns * 1e-9,
        "tilt_deg": _angle(span.peak_tilt),
        "heading_deg": _angle(span.peak_heading),
    }


def _autopilot(attitude: AutopilotAttitude) -> dict[str, object]:
    return _attitude(attitude.q_nb) | {"source": attitude.source, "received_s": attitude.rx_ns * 1e-9}


def _settings(settings: VehicleSettings) -> dict[str, object]:
    return {one.name.lower(): settings.get(one) for one in Setting if isfinite(settings.get(one))}


def _field(field: EarthField) -> dict[str, object]:
    return {"declination_deg": degrees(field.declination), "inclination_deg": degrees(field.inclination)}


_RECORDS: Final[dict[type, Callable[[Any], dict[str, object]]]] = {
    Estimate: _estimate,
    Innovation: _innovation,
    AidSnapshot: _aid,
    VerdictStanding: _standing,
    VerdictSpan: _span,
    AutopilotAttitude: _autopilot,
    VehicleSettings: _settings,
    EarthField: _field,
}
"""Records whose fields are not shown as they are: the form of each."""

"""A snapshot as metrics, in the text format of Prometheus (version 0.0.4)."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from math import degrees, isnan
from typing import Final

from attest_mav.estimation.events import Agreement
from attest_mav.service.link_records import LinkSnapshot
from attest_mav.service.snapshot import Snapshot
from attest_mav.service.vehicle_records import LaneSnapshot
from attest_mav.web.health import ailments

CONTENT_TYPE: Final = "text/plain; version=0.0.4; charset=utf-8"
PREFIX: Final = "attest_mav"

Label = tuple[str, str]
Row = tuple[tuple[Label, ...], float]


@dataclass(frozen=True)
class Metric:
    """One metric: its name, the sentence that explains it, and its values by labels. Counters end in ``_total``."""

    name: str
    text: str
    rows: Iterable[Row]

    def lines(self) -> list[str]:
        """Its lines; none without values."""
        name = f"{PREFIX}_{self.name}"
        values = [f"{name}{_labels(labels)} {_number(value)}" for labels, value in self.rows]
        kind = "counter" if name.endswith("_total") else "gauge"
        return [f"# HELP {name} {self.text}", f"# TYPE {name} {kind}", *values] if values else []


def metrics_text(snapshot: Snapshot) -> str:
    """All metrics of a snapshot."""
    metrics = [*_service(snapshot), *_verdict(snapshot), *_estimate(snapshot)]
    for name, text, field in _LINK_COUNTERS:
        rows = [((("link", link.name),), _counter(link, field)) for link in snapshot.links]
        metrics.append(Metric(f"link_{name}_total", text, rows))
    for field, text in _LANE_COUNTERS.items():
        rows = [((("lane", lane.source),), getattr(lane, field)) for lane in snapshot.lanes]
        metrics.append(Metric(f"lane_{field}_total", text, rows))
    metrics += [
        Metric("lane_set_aside", "Whether the sensor is at fault.", _by_lane(snapshot, lambda lane: lane.fault != "")),
        Metric("lane_delay_seconds", "Delay of the newest sample.", _by_lane(snapshot, lambda lane: lane.delay_s)),
    ]
    return "".join(f"{line}\n" for metric in metrics for line in metric.lines())


_LINK_COUNTERS: Final = (
    ("frames", "Intact frames received.", "frames"),
    ("bad_bytes", "Bytes received that belong to no frame.", "bad_bytes"),
    ("bad_checksums", "Frames received whose checksum does not fit.", "bad_crc"),
    ("lost_frames", "Frames missing in the sequence numbers of their senders.", "lost_frames"),
    ("attitudes", "Attitudes sent.", "attitudes_sent"),
    ("received_bytes", "Bytes received.", "received_bytes"),
    ("sent_bytes", "Bytes sent.", "sent_bytes"),
    ("dropped_messages", "Messages not sent: the link was down or its buffer full.", "dropped_messages"),
    ("streams", "Byte streams begun: one more with every connection made again.", "streams"),
)
_LANE_COUNTERS: Final = {
    "samples": "Inertial samples taken.",
    "repeats": "Samples dropped: same time stamp as the one before.",
    "late": "Samples dropped: older than the one before.",
    "strays": "Samples dropped: a time stamp that the next ones did not confirm.",
    "rejected": "Samples dropped: not finite.",
    "frozen": "Samples dropped: the sensor repeats one reading.",
    "gaps": "Gaps between samples.",
    "restarts": "Alignments begun again.",
}


def _service(now: Snapshot) -> list[Metric]:
    vehicle, notes = now.vehicle, now.notes
    notes_by_level = [((("level", "warning"),), notes.warnings), ((("level", "error"),), notes.errors)]
    recordings = [] if now.recording is None else [now.recording]
    up = [((("link", link.name),), link.traffic.is_open) for link in now.links]
    return [
        Metric(
            "healthy", "Whether links are open and a present vehicle has a fresh attitude.", _one(not ailments(now))
        ),
        Metric("vehicle_present", "Whether a vehicle is heard.", _one(vehicle is not None and vehicle.is_present)),
        Metric("withheld", "Whether the attitude is not certain enough to be sent.", _one(now.withheld != "")),
        Metric("samples_total", "Samples of the inertial message in use.", _one(now.samples)),
        Metric("notes_total", "Lines of the log.", notes_by_level),
        Metric("record_bytes_total", "Bytes recorded.", [((), one.written_bytes) for one in recordings]),
        Metric("record_lost_frames_total", "Frames not recorded.", [((), one.lost_frames) for one in recordings]),
        Metric("link_open", "Whether the device or socket is open.", up),
    ]


def _verdict(now: Snapshot) -> list[Metric]:
    if now.verdict is None:
        return []
    verdict = now.verdict.verdict
    states = [((("agreement", one.name.lower()),), verdict.agreement == one) for one in Agreement]
    stood_s = (now.now_ns - now.verdict.since_ns) * 1e-9
    return [
        Metric("verdict", "The verdict on the autopilot's attitude: 1 for the one that holds.", states),
        Metric("verdict_since_seconds", "Time for which the verdict has stood.", _one(stood_s)),
        Metric("tilt_difference_degrees", "Difference in tilt.", _one(degrees(verdict.tilt))),
        Metric("heading_difference_degrees", "Difference in heading.", _one(degrees(verdict.heading))),
    ]


def _estimate(now: Snapshot) -> list[Metric]:
    lane = now.published_lane
    if lane is None or lane.estimate is None:
        return []
    one = lane.estimate
    return [
        Metric("estimate_age_seconds", "Age of the newest attitude.", _one((now.now_ns - one.rx_ns) * 1e-9)),
        Metric("tilt_sigma_degrees", "Standard deviation of our tilt.", _one(degrees(one.tilt_sigma))),
        Metric("heading_sigma_degrees", "Standard deviation of our heading.", _one(degrees(one.heading_sigma))),
    ]


def _one(value: float) -> list[Row]:
    return [((), value)]


def _by_lane(now: Snapshot, value: Callable[[LaneSnapshot], float]) -> list[Row]:
    return [((("lane", lane.source),), value(lane)) for lane in now.lanes]


def _counter(link: LinkSnapshot, field: str) -> float:
    return float(getattr(link if hasattr(link, field) else link.traffic, field))


def _labels(labels: tuple[Label, ...]) -> str:
    pairs = [f'{name}="{_escaped(value)}"' for name, value in labels]
    return f"{{{','.join(pairs)}}}" if pairs else ""


def _escaped(text: str) -> str:
    return text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")


def _number(value: float) -> str:
    """The value; NaN is a number of the format."""
    return "NaN" if isnan(value) else f"{float(value):.15g}"

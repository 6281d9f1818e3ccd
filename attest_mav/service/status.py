"""What a person reads about a running daemon: one line, in degrees and hertz."""

from math import degrees, isfinite
from typing import TYPE_CHECKING

from attest_mav.algebra import q_to_euler
from attest_mav.estimation.events import Agreement, Verdict
from attest_mav.mavlink.component.companion import ACTIVE, BOOT, CALIBRATING, CRITICAL
from attest_mav.types import Estimate, North

if TYPE_CHECKING:
    from attest_mav.service.service import Service

STATE_NAMES = {BOOT: "waiting", CALIBRATING: "aligning", ACTIVE: "active", CRITICAL: "CRITICAL"}
NORTH_NAMES = {North.RELATIVE: "from the start", North.MAGNETIC: "magnetic", North.TRUE: "true"}

_VERDICTS = {
    Agreement.AGREE: "agrees",
    Agreement.DISAGREE: "DISAGREES",
    Agreement.UNDECIDED: "undecided",
}


def attitude_text(estimate: Estimate) -> str:
    """Roll, pitch and yaw in degrees, and what the yaw is measured from."""
    roll, pitch, yaw = (degrees(angle) for angle in q_to_euler(estimate.q_nb))
    return f"roll {roll:+.1f} pitch {pitch:+.1f} yaw {yaw % 360.0:.1f} ({NORTH_NAMES[estimate.north]})"


def filter_text(estimate: Estimate, rests_on: str) -> str:
    """Which filter runs, what it rests on now ("" where it always does the same), and its own 1-sigma in degrees."""
    parts = [estimate.filter_name]
    if rests_on:
        parts.append(rests_on)
    if isfinite(estimate.tilt_sigma):
        tilt, heading = degrees(estimate.tilt_sigma), degrees(estimate.heading_sigma)
        parts.append(f"sigma tilt {tilt:.2f} heading {heading:.2f} deg")
    return ", ".join(parts)


def verdict_text(verdict: Verdict) -> str:
    """Whether the autopilot agrees, and by how much it does not."""
    parts = [f"{verdict.source or 'autopilot'} {_VERDICTS[verdict.agreement]}"]
    if verdict.agreement == Agreement.UNDECIDED or verdict.reason != "agrees":
        parts.append(f"({verdict.reason})")
    if isfinite(verdict.tilt):
        parts.append(f"tilt {degrees(verdict.tilt):.2f}")
    if isfinite(verdict.heading):
        parts.append(f"heading {degrees(verdict.heading):+.2f} deg")
    return " ".join(parts)


class StatusLine:
    """Writes the line; keeps the counts of the last one, so that rates are those in between."""

    def __init__(self, now_ns: int) -> None:
        self._since_ns = now_ns
        self._samples = 0
        self._sent = 0

    def write(self, service: "Service", now_ns: int) -> str:
        """The line for now."""
        span_s = max((now_ns - self._since_ns) / 1e9, 1e-9)
        sent = max((port.attitudes_sent for port in service.companion.ports), default=0)
        imu_hz, sent_hz = (service.samples - self._samples) / span_s, (sent - self._sent) / span_s
        self._since_ns, self._samples, self._sent = now_ns, service.samples, sent
        parts = [STATE_NAMES.get(service.companion.state, "?"), _imu_text(service, imu_hz)]
        estimate = service.estimate
        if estimate is None:
            parts += _obstacles(service)
        else:
            parts.append(attitude_text(estimate))
            parts += _pipeline_texts(service, estimate)
        held = [port.name for port in service.companion.ports if port.held]
        parts.append(f"sent {sent_hz:.1f} Hz" + (f", held back on {', '.join(held)}" if held else ""))
        return " | ".join(parts)


def _obstacles(service: "Service") -> list[str]:
    """Why there is no attitude."""
    stream = service.companion.data.imu
    if stream is None:
        return []
    refusal = service.decoder.refusals.get(stream.name)
    if refusal is not None:
        return [f"nothing is sent: {refusal}"]
    if service.companion.state == CALIBRATING:
        return ["nothing is sent: aligning"]
    return ["nothing is sent: no sample has come" if service.pipeline is None else "nothing is sent: samples stopped"]


def _nobody_text(service: "Service") -> str:
    """What is heard instead of a vehicle."""
    if any(framer.frames for framer in service.framers):
        return "no vehicle yet: MAVLink comes, but no HEARTBEAT of an autopilot"
    if any(framer.bad_bytes for framer in service.framers):
        return "no vehicle yet: bytes come, but no MAVLink; is the baud rate right?"
    return "no vehicle yet"


def _imu_text(service: "Service", hz: float) -> str:
    """The inertial message: asked for, answered, arriving."""
    stream = service.companion.data.imu
    if stream is None:
        return service.companion.lock_on.ambiguity or _nobody_text(service)
    asked = f"{stream.name} {hz:.1f} of {stream.hz:g} Hz"
    if not service.decoder.independent.get(stream.name, True):
        asked += ", not independent of the autopilot's filter"
    if stream.ceiling_hz > 0.0:
        return f"{asked} (the autopilot's limit)"
    return asked if stream.answer in {"", "accepted"} else f"{asked} ({stream.answer})"


def _pipeline_texts(service: "Service", estimate: Estimate) -> list[str]:
    """What stands behind the attitude: the filter and its aids, and the verdict."""
    pipeline = service.pipeline
    if pipeline is None or estimate.lane not in pipeline.lanes:
        return []
    lane = pipeline.lanes[estimate.lane]
    texts = [filter_text(estimate, lane.rests_on)]
    if estimate.filter_name == "leveling":
        texts.append(f"speed from {pipeline.vehicle.speed_source}")
    if pipeline.verdict is not None:
        texts.append(verdict_text(pipeline.verdict))
    return texts

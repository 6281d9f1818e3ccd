"""The status line: a snapshot as one line for people, in degrees and hertz."""

from math import degrees, isfinite
from typing import Final

from attest_mav.algebra import q_to_euler
from attest_mav.estimate import Estimate
from attest_mav.estimation.events import Agreement, Verdict
from attest_mav.mavlink.constants import MAV_STATE_ACTIVE, MAV_STATE_BOOT, MAV_STATE_CALIBRATING, MAV_STATE_CRITICAL
from attest_mav.service.signing_status import signing_text
from attest_mav.service.snapshot import Rates, Snapshot, rates_between
from attest_mav.service.vehicle_records import LaneSnapshot
from attest_mav.types import North

STATE_NAMES: Final = {
    MAV_STATE_BOOT: "waiting",
    MAV_STATE_CALIBRATING: "aligning",
    MAV_STATE_ACTIVE: "active",
    MAV_STATE_CRITICAL: "CRITICAL",
}
NORTH_NAMES: Final = {North.RELATIVE: "from the start", North.MAGNETIC: "magnetic", North.TRUE: "true"}

TOLD_FIELD_S: Final = 2.0
"""A magnetometer that is missing for less is not worth a word, s."""
TOLD_DELAY_S: Final = 0.1
"""A smaller delay of the samples is not worth a word, s."""

VERDICT_WORDS: Final = {
    Agreement.AGREE: "agrees",
    Agreement.DISAGREE: "DISAGREES",
    Agreement.UNDECIDED: "undecided",
}


def attitude_text(estimate: Estimate) -> str:
    """Roll, pitch and yaw in degrees, and the north of the yaw."""
    roll, pitch, yaw = (round(degrees(angle), 1) or 0.0 for angle in q_to_euler(estimate.q_nb))  # no "-0.0"
    return f"roll {roll:+.1f} pitch {pitch:+.1f} yaw {yaw % 360.0:.1f} ({NORTH_NAMES[estimate.north]})"


def filter_text(estimate: Estimate, rests_on: str) -> str:
    """The filter, the aiding it rests on ("" for a filter that always has the same), and its 1-sigma in degrees."""
    parts = [estimate.filter_name]
    if rests_on:
        parts.append(rests_on)
    if isfinite(estimate.tilt_sigma):
        tilt, heading = degrees(estimate.tilt_sigma), degrees(estimate.heading_sigma)
        parts.append(f"sigma tilt {tilt:.2f} heading {heading:.2f} deg")
    return ", ".join(parts)


def verdict_text(verdict: Verdict) -> str:
    """Whether the autopilot's attitude agrees, and the differences in degrees."""
    parts = [f"{verdict.source or 'autopilot'} {VERDICT_WORDS[verdict.agreement]}"]
    if verdict.agreement == Agreement.UNDECIDED or verdict.reason != "agrees":
        parts.append(f"({verdict.reason})")
    if isfinite(verdict.tilt):
        parts.append(f"tilt {degrees(verdict.tilt):.2f}")
    if isfinite(verdict.heading):
        parts.append(f"heading {degrees(verdict.heading):+.2f} deg")
    return " ".join(parts)


def status_line(now: Snapshot, before: Snapshot) -> str:
    """The state of ``now``, with the rates since ``before``."""
    rates = rates_between(before, now)
    parts = [STATE_NAMES.get(now.state, "?"), _inertial_text(now, rates)]
    lane = now.published_lane
    if lane is None or lane.estimate is None:
        parts += obstacles(now)
    else:
        parts.append(attitude_text(lane.estimate))
        parts += _filter_texts(now, lane, lane.estimate)
        parts += [f"samples come {lane.delay_s:.2f} s late"] if lane.delay_s >= TOLD_DELAY_S else []
        parts += [f"attitude withheld: {now.withheld}"] if now.withheld else []
    parts += [f"the autopilot itself {', '.join(now.self_report)}"] if now.self_report else []
    parts += now.link_remarks
    parts += [signing_text(link.name, link.signing) for link in now.links if link.signing is not None]
    parts += [f"nothing is recorded: {now.recording.complaint}"] if now.recording and now.recording.complaint else []
    parts.append(", ".join([f"sent {rates.published:.1f} Hz", *_changed_by_others(now)]))
    return " | ".join(parts)


def _changed_by_others(now: Snapshot) -> list[str]:
    """Changes of our outputs and parameters by other stations."""
    held = [f"held back on {link.name} for component {link.held_for}" for link in now.links if link.held_back]
    held += [f"{name} {change.value:g} set by {change.by}" for name, change in now.own_parameters]
    return held + [f"{change} on {link.name}" for link in now.links for change in link.changes]


def obstacles(now: Snapshot) -> list[str]:
    """Why there is no attitude; nothing before there is a vehicle."""
    if now.inertial_stream is None:
        return []
    if now.inertial_refusal:
        return [f"nothing is sent: {now.inertial_refusal}"]
    if now.late_by_s > 0.0:
        return [f"nothing is sent: samples come {now.late_by_s:.2f} s late"]
    if now.state == MAV_STATE_CALIBRATING:
        return ["nothing is sent: aligning"]
    return ["nothing is sent: samples stopped" if now.lanes else "nothing is sent: no sample has come"]


def nobody_text(frames: int, bad_bytes: int) -> str:
    """The traffic that is heard instead of a vehicle."""
    if frames:
        return "no vehicle yet: MAVLink comes, but no HEARTBEAT of an autopilot"
    if bad_bytes:
        return "no vehicle yet: bytes come, but no MAVLink; is the baud rate right?"
    return "no vehicle yet"


def _inertial_text(now: Snapshot, rates: Rates) -> str:
    """The inertial message with its rate, and the autopilot's answer to the request."""
    stream = now.inertial_stream
    if stream is None:
        return now.ambiguity or nobody_text(
            sum(link.frames for link in now.links), sum(link.bad_bytes for link in now.links)
        )
    asked = f"{stream.name} {rates.samples:.1f} of {stream.hz:g} Hz"
    if stream.name in now.not_independent:
        asked += ", not independent of the autopilot's filter"
    if stream.hindrance:
        return f"{asked} ({stream.hindrance})"
    if stream.ceiling_hz > 0.0:
        return f"{asked} (the autopilot's limit)"
    return asked if stream.answer in {"", "accepted"} else f"{asked} ({stream.answer})"


def _filter_texts(now: Snapshot, lane: LaneSnapshot, estimate: Estimate) -> list[str]:
    """The filter of the lane with its aiding, the verdict, and the trims it rests on."""
    texts = [filter_text(estimate, lane.rests_on)]
    if estimate.filter_name == "leveling" and now.vehicle is not None:
        texts.append(f"speed from {now.vehicle.speed_source}")
    if now.verdict is not None:
        texts.append(verdict_text(now.verdict.verdict))
    return [*texts, *_sensor_texts(now), *now.frame_notes]


def _sensor_texts(now: Snapshot) -> list[str]:
    """The sensors with their faults, or why there is one alone."""
    if len(now.lanes) > 1:
        return [f"sensors {', '.join(_sensor_text(lane) for lane in now.lanes)}"]
    lost = [f"{lane.source} without magnetometer" for lane in now.lanes if lane.field_lost_s > TOLD_FIELD_S]
    return lost + ([f"one sensor: {now.single_imu}"] if now.single_imu else [])


def _sensor_text(lane: LaneSnapshot) -> str:
    """One of several sensors, with what is wrong with it."""
    if lane.fault:
        return f"{lane.source} set aside ({lane.fault})"
    return f"{lane.source} without magnetometer" if lane.field_lost_s > TOLD_FIELD_S else lane.source

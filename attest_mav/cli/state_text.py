"""The document of a daemon's state in words, for ``status`` and ``watch``."""

from typing import Any, Final, NamedTuple

from attest_mav.cli.reason_text import REASON_WORDS
from attest_mav.service.status import VERDICT_WORDS, nobody_text

WORDS: Final = {agreement.name.lower(): word for agreement, word in VERDICT_WORDS.items()}
SHOWN_SPANS: Final = 8
OLD_S: Final = 1.5
"""An attitude of this age is told to be old, s."""


class Line(NamedTuple):
    """One line of a section."""

    text: str
    is_bad: bool = False
    """Whether something is as it should not be."""


class Section(NamedTuple):
    """Lines with a title."""

    title: str
    lines: list[Line]


def number(value: float | None, digits: int, sign: str = "") -> str:
    """A number that may be unknown; one that rounds to zero has no sign. sign: "+" shows it always."""
    return "-" if value is None else f"{round(value, digits) or 0.0:{sign}.{digits}f}"


def duration(seconds: float) -> str:
    """A length of time in seconds, minutes or hours."""
    if seconds < 100.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 6000.0 else f"{seconds / 3600.0:.1f} h"


def judgement(of: dict[str, Any], digits: int, tilt: str = "tilt") -> str:
    """A verdict or an interval of it: agreement, reason, and those of the differences that are known."""
    text = WORDS[of["agreement"]] if of["reason"] == "agrees" else f"{WORDS[of['agreement']]} ({of['reason']})"
    known = [f"{tilt} {number(of['tilt_deg'], digits)}"] if of["tilt_deg"] is not None else []
    known += [f"heading {number(of['heading_deg'], digits, '+')}"] if of["heading_deg"] is not None else []
    return f"{text}, {', '.join(known)} deg" if known else text


def verdict_line(state: dict[str, Any]) -> str:
    """The verdict with its reason, differences and age."""
    verdict = state["verdict"]
    if verdict is None:
        return "no verdict yet"
    lasted = duration(state["now_s"] - verdict["since_s"])
    return f"{verdict['source'] or 'autopilot'} {judgement(verdict, 2)}, for {lasted}"


def reason_lines(state: dict[str, Any]) -> list[Line]:
    """The reason of the verdict in words, and the limits of the differences."""
    verdict, limit_deg = state["verdict"], state["tilt_threshold_deg"]
    words = "" if verdict is None else REASON_WORDS.get((verdict["agreement"], verdict["reason"]), "")
    limits = "" if limit_deg is None else f"limits: tilt {limit_deg:g}, heading {2.0 * limit_deg:g} deg"
    text = "; ".join(one for one in (words, limits) if one)
    return [Line(text)] if text else []


def headline(state: dict[str, Any]) -> str:
    """The vehicle, and the state of our work."""
    vehicle = state["vehicle"]
    if vehicle is None:
        frames, bad_bytes = (sum(link[key] for link in state["links"]) for key in ("frames", "bad_bytes"))
        return f"{state['state']}: {state['ambiguity'] or nobody_text(frames, bad_bytes)}"
    armed = "armed" if vehicle["armed"] else "disarmed"
    return f"{state['state']}: system {vehicle['system']}, {armed}{'' if vehicle['is_present'] else ', not heard'}"


def attitude_line(state: dict[str, Any], name: str, attitude: dict[str, Any] | None) -> Line:
    """Roll, pitch, heading and, where it is old, the age of an attitude."""
    if attitude is None:
        return Line(f"{name:<9}  none", is_bad=True)
    roll, pitch = (number(attitude[key], 1, "+") for key in ("roll_deg", "pitch_deg"))
    angles = (
        f"{name:<9}  roll {roll:>6}  pitch {pitch:>6}  heading {number(round(attitude['yaw_deg'], 1) % 360.0, 1):>5}"
    )
    age_s = state["now_s"] - attitude["received_s"]
    return Line(f"{angles}  {duration(age_s)} old", is_bad=True) if age_s > OLD_S else Line(angles)


def attitude_lines(state: dict[str, Any]) -> list[Line]:
    """Both attitudes, and the sigma of ours."""
    ours = published(state)
    lines = [attitude_line(state, "ours", ours), attitude_line(state, "autopilot", state["autopilot"])]
    if ours is not None:
        tilt, heading = number(ours["tilt_sigma_deg"], 2), number(ours["heading_sigma_deg"], 2)
        lines.append(Line(f"our sigma  tilt {tilt}, heading {heading} (heading {ours['north']}); {ours['filter']}"))
    return lines


def published(state: dict[str, Any]) -> dict[str, Any] | None:
    """Our estimate, None while there is none."""
    return next((lane["estimate"] for lane in state["lanes"] if lane["estimate"] is not None), None)


def remarks(state: dict[str, Any]) -> list[str]:
    """Everything that is not as it should be, a line each."""
    lines = [*state["ailments"], *(one for one in state["obstacles"] if one not in state["ailments"])]
    lines += [f"attitude withheld: {state['withheld']}"] if state["withheld"] else []
    lines += [f"the autopilot itself {', '.join(state['self_report'])}"] if state["self_report"] else []
    recording = state["recording"]
    lines += [f"nothing is recorded: {recording['complaint']}"] if recording and recording["complaint"] else []
    return [*lines, *state["frame_notes"], *state["link_remarks"]]


def lane_line(state: dict[str, Any], lane: dict[str, Any]) -> Line:
    """One inertial sensor."""
    if lane["fault"]:
        return Line(f"{lane['source']}: set aside: {lane['fault']}", is_bad=True)
    stream = next((one for one in state["streams"] if one["name"] == lane["source"]), None)
    if stream is not None and stream["achieved_hz"] == 0.0 and published(state) is None:
        return Line(f"{lane['source']}: no samples", is_bad=True)
    rate = "" if stream is None else f", {number(stream['achieved_hz'], 1)} of {stream['hz']:g} Hz"
    use = "published" if lane["estimate"] is not None else "used, not published"
    return Line(f"{lane['source']}: {use}{rate}{', ' if lane['rests_on'] else ''}{lane['rests_on']}")


def span_lines(state: dict[str, Any]) -> list[Line]:
    """The last intervals of the verdict, the newest first."""
    lines = []
    for place, span in enumerate(state["spans"][::-1][:SHOWN_SPANS]):
        ago_s = state["now_s"] - span["begin_s"]
        lasted_s = span["end_s"] - span["begin_s"] if place else ago_s
        lines.append(Line(f"{duration(ago_s):>6} ago for {duration(lasted_s):>6}  {judgement(span, 1, 'tilt up to')}"))
    return lines


def link_line(link: dict[str, Any]) -> Line:
    """One link."""
    is_open = link["traffic"]["is_open"]
    damage = link["bad_crc"] + link["bad_bytes"]
    held = f", ATTITUDE_QUATERNION held back for component {link['held_for']}" if link["held_back"] else ""
    return Line(
        f"{link['name']}: {'open' if is_open else 'NOT OPEN'}, {link['frames']} frames, {link['lost_frames']} lost, "
        f"{damage} damaged, {link['attitudes_sent']} attitudes sent{held}",
        is_bad=not is_open,
    )


def sections(state: dict[str, Any]) -> list[Section]:
    """The whole state; the verdict comes second, the intervals of the verdict, of which there may be many, last."""
    all_sections = [
        Section(headline(state), [Line(one) for one in remarks(state)]),
        Section(verdict_line(state), reason_lines(state)),
        Section("newest attitudes, degrees (the verdict compares at one instant)", attitude_lines(state)),
        Section("inertial sensors", [lane_line(state, lane) for lane in state["lanes"]]),
        Section("links", [link_line(link) for link in state["links"]]),
        Section("verdicts, the newest first (DISAGREES at once, others after 10 s)", span_lines(state)),
    ]
    return [one for place, one in enumerate(all_sections) if one.lines or place < 2]


def plain_text(state: dict[str, Any]) -> str:
    """The whole state as lines."""
    return "\n".join(line for one in sections(state) for line in (one.title, *(f"  {line.text}" for line in one.lines)))

"""The document of a daemon's state in words, for ``status`` and ``watch``."""

from typing import Any, Final

from attest_mav.service.status import VERDICT_WORDS

WORDS: Final = {agreement.name.lower(): word for agreement, word in VERDICT_WORDS.items()}
SHOWN_SPANS: Final = 8


def number(value: float | None, digits: int, sign: str = "") -> str:
    """A number that may be unknown. sign: "+" shows it always."""
    return "-" if value is None else f"{value:{sign}.{digits}f}"


def differences(of: dict[str, Any], digits: int, tilt: str = "tilt") -> str:
    """Those of the differences in tilt and heading that are known, each behind a comma; "" for none."""
    known = [
        f", {name} {number(of[key], digits, sign)} deg"
        for name, key, sign in ((tilt, "tilt_deg", ""), ("heading", "heading_deg", "+"))
        if of[key] is not None
    ]
    return "".join(known)


def verdict_line(state: dict[str, Any]) -> str:
    """The verdict with its reason, differences and age."""
    verdict = state["verdict"]
    if verdict is None:
        return "no verdict yet"
    text = f"{verdict['source'] or 'autopilot'} {WORDS[verdict['agreement']]}"
    if verdict["reason"] != "agrees":
        text += f" ({verdict['reason']})"
    return f"{text}{differences(verdict, 2)}, for {state['now_s'] - verdict['since_s']:.0f} s"


def headline(state: dict[str, Any]) -> str:
    """The vehicle, and the state of our work."""
    vehicle = state["vehicle"]
    if vehicle is None:
        return f"{state['state']}: {state['ambiguity'] or 'no vehicle yet'}"
    armed = "armed" if vehicle["armed"] else "disarmed"
    return f"{state['state']}: system {vehicle['system']}, {armed}{'' if vehicle['is_present'] else ', not heard'}"


def attitude_line(state: dict[str, Any], attitude: dict[str, Any] | None) -> str:
    """Roll, pitch, heading and age of an attitude."""
    if attitude is None:
        return "none"
    angles = (
        f"roll {attitude['roll_deg']:+6.1f}  pitch {attitude['pitch_deg']:+6.1f}  heading {attitude['yaw_deg']:5.1f}"
    )
    age_s = state["now_s"] - attitude["received_s"]
    return f"{angles}  old: {age_s:.1f} s" if age_s > 1.5 else angles


def published(state: dict[str, Any]) -> dict[str, Any] | None:
    """Our estimate, None while there is none."""
    return next((lane["estimate"] for lane in state["lanes"] if lane["estimate"] is not None), None)


def remarks(state: dict[str, Any]) -> list[str]:
    """Everything that is not as it should be, a line each."""
    lines = [*state["ailments"], *(one for one in state["obstacles"] if one not in state["ailments"])]
    lines += [f"attitude withheld: {state['withheld']}"] if state["withheld"] else []
    lines += [f"the autopilot itself {', '.join(state['self_report'])}"] if state["self_report"] else []
    return [*lines, *state["frame_notes"], *state["link_remarks"]]


def lane_line(state: dict[str, Any], lane: dict[str, Any]) -> str:
    """One inertial sensor."""
    if lane["fault"]:
        return f"{lane['source']}: set aside ({lane['fault']})"
    rates = [stream["achieved_hz"] for stream in state["streams"] if stream["name"] == lane["source"]]
    if rates == [0.0] and published(state) is None:
        return f"{lane['source']}: no samples"
    use = "published" if lane["estimate"] is not None else "used beside it"
    rests_on = f", {lane['rests_on']}" if lane["rests_on"] else ""
    return f"{lane['source']}: {use}{rests_on}"


def span_lines(state: dict[str, Any]) -> list[str]:
    """The last intervals of the verdict, the newest first."""
    spans = state["spans"][::-1][:SHOWN_SPANS]
    lines = []
    for place, span in enumerate(spans):
        end_s = span["end_s"] if place else state["now_s"]
        lines.append(
            f"{state['now_s'] - span['begin_s']:7.0f} s ago for {end_s - span['begin_s']:6.0f} s  "
            f"{WORDS[span['agreement']]} ({span['reason']}){differences(span, 1, 'tilt up to')}"
        )
    return lines


def link_line(link: dict[str, Any]) -> str:
    """One link."""
    state = "open" if link["traffic"]["is_open"] else "NOT OPEN"
    damage = link["bad_crc"] + link["bad_bytes"]
    return (
        f"{link['name']}: {state}, {link['frames']} frames, {link['lost_frames']} lost, {damage} bad bytes, "
        f"{link['attitudes_sent']} attitudes sent"
    )


def sections(state: dict[str, Any]) -> list[tuple[str, list[str]]]:
    """The whole state: a title and its lines."""
    ours = published(state)
    attitudes = [f"ours       {attitude_line(state, ours)}", f"autopilot  {attitude_line(state, state['autopilot'])}"]
    if ours is not None:
        sigmas = f"tilt {number(ours['tilt_sigma_deg'], 2)}, heading {number(ours['heading_sigma_deg'], 2)} deg"
        attitudes.append(f"sigma      {sigmas}, {ours['filter']}, heading {ours['north']}")
    all_sections = [
        (headline(state), remarks(state)),
        (verdict_line(state), span_lines(state)),
        ("attitudes, degrees", attitudes),
        ("inertial sensors", [lane_line(state, lane) for lane in state["lanes"]]),
        ("links", [link_line(link) for link in state["links"]]),
    ]
    return [(title, lines) for title, lines in all_sections if lines or title != "inertial sensors"]


def plain_text(state: dict[str, Any]) -> str:
    """The whole state as lines."""
    return "\n".join(line for title, lines in sections(state) for line in (title, *(f"  {one}" for one in lines)))

"""The page of a replayed flight: one HTML file that needs nothing else.

A content security policy allows the page's own style and script by their hashes, and forbids everything else. Data go
into the page as JSON in which no ``<`` remains, so no text of a log can end the element that holds them.
"""

import json
from base64 import b64encode
from dataclasses import dataclass
from hashlib import sha256
from html import escape
from typing import Any, Final

from attest_mav.report.charts import charts_of
from attest_mav.report.marks import AUTOPILOT, Mark
from attest_mav.report.recorder import FlightRecorder
from attest_mav.report.tables import (
    consistency_table,
    error_table,
    facts_of,
    lane_table,
    notes_of,
    peak_table,
    table,
    verdict_table,
)

TEMPLATE: Final = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{title}</title>
<style>{style}</style>
</head>
<body>
<header>
<h1>{title}</h1>
<p class="summary {state}">{summary}</p>
{facts}{notes}
</header>
<div id="timeline"></div>
<main id="charts"></main>
<section id="figures"><h2>Figures</h2>{tables}</section>
<footer>Written by {version}.</footer>
<noscript><p>The charts are drawn by a script of this page.</p></noscript>
<script type="application/json" id="data">{data}</script>
<script>{script}</script>
</body>
</html>
"""


@dataclass(frozen=True)
class Assets:
    """The texts of the page's own style and script, and the version of the program."""

    style: str
    script: str
    version: str


def page_of(report: dict[str, Any], recorder: FlightRecorder, assets: Assets) -> str:
    """The page. report: the JSON object of the replay."""
    state, summary = summary_of(report)
    judge = report["verdict"]["filter"]
    marks = sorted((one for one in recorder.marks.marks if one.origin in (AUTOPILOT, judge)), key=lambda one: one.t_s)
    # The policy is made of hashes of exactly what stands between the tags.
    policy = f"default-src 'none'; style-src '{_hash(assets.style)}'; script-src '{_hash(assets.script)}'"
    return TEMPLATE.format(
        policy=policy,
        title=escape(f"{report['log']}: attitude report"),
        style=assets.style,
        state=state,
        summary=escape(summary),
        facts=facts_of(report),
        notes=notes_of(report),
        tables=_tables(report, marks, recorder.marks.left_out),
        version=escape(assets.version),
        data=as_script_json(data_of(report, recorder, marks)),
        script=assets.script,
    )


def summary_of(report: dict[str, Any]) -> tuple[str, str]:
    """The state of the whole flight, and a sentence that says for how long each lasted."""
    verdict = report["verdict"]
    if not verdict["intervals"]:
        return "undecided", "No verdict: the log has no attitude of the autopilot to judge."
    lasted = {state: verdict[f"{state}_s"] for state in ("agree", "undecided", "disagree")}
    state = "disagree" if lasted["disagree"] else "agree" if lasted["agree"] else "undecided"
    words = {"agree": "agree", "undecided": "undecided", "disagree": "DISAGREE"}
    parts = [f"{words[one]} for {seconds:.1f} s" for one, seconds in sorted(lasted.items(), key=_by(state)) if seconds]
    text = ", ".join(parts)
    return state, f"Verdict on the autopilot's attitude: {text}."


def _by(first: str) -> Any:
    """The order of states in the summary: the named one first."""
    order = ["disagree", "agree", "undecided"]
    return lambda item: (item[0] != first, order.index(item[0]))


def data_of(report: dict[str, Any], recorder: FlightRecorder, marks: list[Mark]) -> dict[str, Any]:
    """The object that the page's script draws."""
    return {
        "verdict": [
            {"begin": one["start_s"], "end": one["end_s"], "state": one["state"], "text": _interval_text(one)}
            for one in report["verdict"]["intervals"]
        ],
        "lanes": [
            {
                "name": lane["message"],
                "faults": [
                    {"begin": one["start_s"], "end": one["end_s"], "text": f"{one['kind']}: {one['text']}"}
                    for one in lane["faults"]
                ],
            }
            for lane in report["lanes"]
        ],
        "marks": [{"t": round(one.t_s, 3), "own": one.origin != AUTOPILOT, "text": one.text} for one in marks],
        "charts": charts_of(recorder, report),
    }


def as_script_json(data: dict[str, Any]) -> str:
    """JSON that can stand in a script element: without the character that begins a tag."""
    return json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def _interval_text(one: dict[str, Any]) -> str:
    state = "DISAGREE" if one["state"] == "disagree" else one["state"]
    remarks = [*one["sensors"], *one["autopilot_reports"]]
    parts = [f"{state}, {one['start_s']:.1f} to {one['end_s']:.1f} s: {one['reason']}"]
    if one["peak_tilt_deg"] is not None:
        parts.append(f"largest tilt difference {one['peak_tilt_deg']:.1f}°")
    if one["peak_heading_deg"] is not None:
        parts.append(f"heading {one['peak_heading_deg']:.1f}°")
    return "; ".join([*parts, *remarks])


def _tables(report: dict[str, Any], marks: list[Mark], left_out: int) -> str:
    rest = f", without {left_out} more" if left_out else ""
    events = table(
        f"Events{rest}", ("log time, s", "origin", "event"), [(f"{one.t_s:.1f}", one.origin, one.text) for one in marks]
    )
    compared = (error_table(report), peak_table(report), consistency_table(report))
    return "".join((*compared, verdict_table(report), lane_table(report), events))


def _hash(text: str) -> str:
    """The hash of an inline style or script in the form of the policy."""
    return f"sha256-{b64encode(sha256(text.encode()).digest()).decode()}"

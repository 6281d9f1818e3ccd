"""The recorded series of a flight as the charts of a page, in the form that its script draws."""

from math import isfinite
from typing import Any, Final

from attest_mav.logs.source import SMOOTHED
from attest_mav.report.envelope import Envelope
from attest_mav.report.kinds import Chart
from attest_mav.report.recorder import AXES, NED, REFERENCE, FlightRecorder, Key

AUTOPILOT: Final = "autopilot"
SIGMA: Final = "sigma"
DIGITS: Final = 5
"""Significant digits of a value."""
BRIEF_SHARE: Final = 0.05
"""Innovations over a shorter share of the flight are in the chart of all aids only."""
PART_COLOURS: Final = {
    **{name: place for axes in (AXES, NED) for place, name in enumerate(axes)},
    "velocity": 0,
    "position": 1,
    "height": 2,
    "compass": 3,
    "airspeed": 4,
    "magnetometer": 1,
    "zero rate": 2,
    "zero velocity": 3,
    "gravity": 3,
    "zero mean velocity": 4,
}
"""Number of the colour by axis, or by name of a measurement."""
COLOURS: Final = 5
"""Colours of axes, lanes and measurements."""
OTHER_COLOURS: Final = (2, 4, 3, 0, 1)
"""The colours of further filters and of the receiver, those first that neither ours nor the autopilot's is like."""
OF_LANES: Final = frozenset({Chart.INTERVAL, Chart.VIBRATION, Chart.CLIPPING, Chart.FIELD_STRENGTH})
ROLES: Final = (SIGMA, REFERENCE, "verdict", AUTOPILOT, *(f"part{place}" for place in range(COLOURS)), "ours")
"""The roles of series, each with a colour; those that come later are drawn over the others."""
OF_FILTER: Final = frozenset({Chart.NIS, Chart.INNOVATION, Chart.GYRO_BIAS, Chart.ACCEL_BIAS, Chart.INCLINATION})
"""Charts of one filter, of which the judging one is shown."""


def charts_of(recorder: FlightRecorder, report: dict[str, Any]) -> list[dict[str, Any]]:
    """The charts that have a series, in the order of the page. report: the JSON object of the replay."""
    judge = report["verdict"]["filter"]
    panels: dict[tuple[Chart, str], list[Key]] = {}
    for key in recorder.series:
        if _is_shown(key, judge) and not _is_reference_twice(key, report) and _says_something(key, recorder):
            panels.setdefault((key.chart, key.panel if key.chart == Chart.INNOVATION else ""), []).append(key)
    order = list(Chart)
    charts = []
    for (chart, panel), keys in sorted(panels.items(), key=lambda item: (order.index(item[0][0]), item[0][1])):
        names = _Names(report, [key.subject for key in keys])
        charts.append(_chart(chart, panel, [names.series(key, recorder.series[key]) for key in keys]))
        charts[-1]["lines"] = _lines(chart, recorder, report)
    return charts


def _is_shown(key: Key, judge: str) -> bool:
    """Whether a series is on the page: what belongs to one filter is shown of the judging one."""
    if key.part == SIGMA:
        return key.subject in (judge, SMOOTHED)
    if key.chart in OF_FILTER:
        return key.subject == judge
    is_verdict = key.chart in (Chart.TILT, Chart.HEADING) and key.part not in (REFERENCE, SIGMA)
    return key.part == judge if is_verdict else True


def _is_reference_twice(key: Key, report: dict[str, Any]) -> bool:
    """Whether an attitude is the smoothed one, which the reference's series shows already."""
    reference = report["reference"]
    is_reference = reference is not None and reference["message"] == SMOOTHED
    return is_reference and key.subject == SMOOTHED and key.part != SIGMA


def _says_something(key: Key, recorder: FlightRecorder) -> bool:
    """Whether a series has points; an aid that served the alignment alone has no chart of its own."""
    points = recorder.series[key].points
    if key.chart != Chart.INNOVATION or not points:
        return bool(points)
    return points[-1][0] - points[0][0] >= BRIEF_SHARE * recorder.duration_s


def _chart(chart: Chart, panel: str, series: list[dict[str, Any]]) -> dict[str, Any]:
    kind = chart.value
    return {
        "section": kind.section,
        "title": f"{kind.title}: {panel}" if panel else kind.title,
        "unit": kind.unit,
        "log": kind.is_log,
        "wraps": kind.wraps,
        "series": sorted(series, key=lambda one: ROLES.index(one["role"])),
    }


class _Names:
    """Labels and colours of the series of one chart."""

    def __init__(self, report: dict[str, Any], subjects: list[str]) -> None:
        self._judge: Final[str] = report["verdict"]["filter"]
        self._labels: Final = {
            REFERENCE: f"reference ({report['reference']['message']})" if report["reference"] else REFERENCE,
        }
        known = (self._judge, AUTOPILOT, REFERENCE)
        self._others: Final = [one for one in dict.fromkeys(subjects) if one not in known]

    def series(self, key: Key, envelope: Envelope) -> dict[str, Any]:
        """One series with its points: times as differences in ms, so that they are short."""
        points = envelope.points
        stamps = [round(1e3 * t_s) for t_s, _ in points]
        role = self._role(key)
        return {
            "label": self._label(key),
            "role": role,
            "t": [after - before for before, after in zip([0, *stamps], stamps, strict=False)],
            "v": [_short(value) for _, value in points],
        }

    def _label(self, key: Key) -> str:
        subject = self._labels.get(key.subject, key.subject)
        if key.chart in (Chart.TILT, Chart.HEADING):
            return f"sigma of {subject}" if key.part == SIGMA else f"{subject} against {key.part}"
        return key.part or subject

    def _role(self, key: Key) -> str:
        """The name of the colour: one for each subject over all charts, or one for each axis."""
        if key.part == SIGMA:
            return REFERENCE if key.subject == SMOOTHED else SIGMA
        if key.chart in (Chart.TILT, Chart.HEADING) and key.part != REFERENCE:
            return "verdict"
        if key.chart not in (Chart.TILT, Chart.HEADING) and key.part:
            return f"part{PART_COLOURS.get(key.part, 2)}"
        if key.subject == self._judge:
            return "ours"
        if key.subject in (AUTOPILOT, REFERENCE):
            return key.subject
        place = self._others.index(key.subject) % COLOURS
        return f"part{place if key.chart in OF_LANES else OTHER_COLOURS[place]}"


def _lines(chart: Chart, recorder: FlightRecorder, report: dict[str, Any]) -> list[dict[str, Any]]:
    """Values to compare with, as horizontal lines."""
    limits = report["verdict"]["thresholds"]
    is_proven = report["verdict"]["filter"] in recorder.proven
    threshold = limits["proven_tilt_deg"] if is_proven else limits["tilt_deg"]
    lines = {
        Chart.TILT: [(threshold, f"threshold {threshold:g}°")],
        Chart.HEADING: [(2.0 * threshold, f"threshold {2.0 * threshold:g}°")],
        Chart.NIS: [(1.0, "consistent: 1")],
        Chart.INNOVATION: [(3.0, "3 sigma"), (-3.0, "-3 sigma")],
        Chart.TEST_RATIO: [(1.0, "limit")],
        Chart.INCLINATION: [(recorder.inclination_deg, "of the Earth's field here")],
    }
    return [{"value": _short(value), "label": text} for value, text in lines.get(chart, []) if isfinite(value)]


def _short(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")

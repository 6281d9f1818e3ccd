"""Figures of one fault: how wrong the autopilot and we were, what the verdict said meanwhile, and who was named."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite, nan
from typing import Final

import numpy as np
from numpy.typing import NDArray

from attest_mav.estimation.events import Agreement
from attest_mav.evaluation.fault_study.card import Fault, FaultGroup
from attest_mav.evaluation.fault_study.flown import Column, FlownFaults, Track

WRONG_TILT: Final = 5.0
WRONG_HEADING: Final = 10.0
"""Degrees: an autopilot beyond either is wrong, and AGREE is blind."""
RIGHT_TILT: Final = 2.0
RIGHT_HEADING: Final = 4.0
"""Degrees: an autopilot within both is right."""
BACK_S: Final = 1.0
"""A DISAGREE counts as false from this long after the autopilot came back, s."""
PASSED_TILT: Final = 3.0
"""Degrees: DISAGREE is due from here on."""
NAMING: Final = "FAULTY"
"""Name of the kind of event that names a faulty source."""

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class FaultFigures:
    """Figures of one fault; degrees and seconds, NaN where a figure has no samples."""

    fault: Fault
    figures: dict[str, float]
    named: str
    """The source that was named first, "" for none."""


def figures_of(
    fault: Fault, flown: FlownFaults, window: tuple[float, float], leave_out: Sequence[tuple[float, float]]
) -> FaultFigures:
    """The figures of the window (s) of one fault."""
    theirs, ours = flown.autopilot, flown.ours
    duration = theirs.durations()
    inside = _inside(theirs, window, leave_out)
    our_inside = _inside(ours, window, leave_out)
    wrong = (theirs.tilt > WRONG_TILT) | (theirs.heading > WRONG_HEADING)
    right = (theirs.tilt <= RIGHT_TILT) & (theirs.heading <= RIGHT_HEADING)
    settled = right & (_time_since_false(right, theirs.t_s) > BACK_S)
    disagrees = flown.agreement == Agreement.DISAGREE
    text, named_s, is_right = _naming(fault, flown, window)
    our_tilt, our_heading = ours.tilt[our_inside], ours.heading[our_inside]
    return FaultFigures(
        fault,
        {
            "autopilot tilt": _largest(theirs.tilt[inside]),
            "autopilot heading": _largest(theirs.heading[inside]),
            "ours": _largest(our_tilt),
            "ours heading": _largest(our_heading),
            "ours 99%": float(np.nanpercentile(our_tilt, 99.0)) if np.isfinite(our_tilt).any() else nan,
            "above 3": float(np.sum(ours.durations()[our_inside & (ours.tilt > PASSED_TILT)])),
            "disagree": _delay(theirs, inside, disagrees),
            "blind": float(np.sum(duration[inside & wrong & (flown.agreement == Agreement.AGREE)])),
            "false": float(np.sum(duration[inside & settled & disagrees])),
            "mute": float(np.sum(duration[inside & right & (flown.agreement == Agreement.UNDECIDED)])),
            "named": named_s,
            "named right": is_right,
            "tilt rms": _rms(our_tilt),
            "heading rms": _rms(our_heading),
            "undecided %": 100.0 * _share(flown.agreement[inside] == Agreement.UNDECIDED),
        },
        text,
    )


def _inside(track: Track, window: tuple[float, float], leave_out: Sequence[tuple[float, float]]) -> Mask:
    inside: Mask = (track.t_s >= window[0]) & (track.t_s < window[1])
    for first_s, last_s in leave_out:
        inside &= (track.t_s < first_s) | (track.t_s > last_s)
    return inside


def _time_since_false(mask: Mask, t_s: Column) -> Column:
    """For each sample the time since the mask was last false, s."""
    last_false = np.maximum.accumulate(np.where(mask, -np.inf, t_s)) if len(t_s) else t_s
    since: Column = t_s - last_false
    return since


def _delay(theirs: Track, inside: Mask, disagrees: Mask) -> float:
    """Time from the autopilot passing 3 degrees to DISAGREE, s; NaN if it never passed, or it was never said."""
    passed = np.flatnonzero(inside & (theirs.tilt > PASSED_TILT))
    if not len(passed):
        return nan
    said = np.flatnonzero(inside & disagrees & (theirs.t_s >= theirs.t_s[passed[0]]))
    return float(theirs.t_s[said[0]] - theirs.t_s[passed[0]]) if len(said) else nan


def _naming(fault: Fault, flown: FlownFaults, window: tuple[float, float]) -> tuple[str, float, float]:
    """The source first named, after how long (s), and 1 if the text has the words it should; 0 if one is missing."""
    for t_s, kind, text in flown.events:
        if kind == NAMING and window[0] <= t_s < window[1]:
            is_right = float(all(word in text for word in fault.accused)) if fault.accused else nan
            return text.split(":")[0], t_s - fault.start_s, is_right
    expected = bool(fault.accused) and fault.group == FaultGroup.SINGLE
    return "", nan, 0.0 if expected else nan


def _largest(values: Column) -> float:
    return float(np.nanmax(values)) if np.isfinite(values).any() else nan


def _rms(values: Column) -> float:
    finite = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(finite * finite))) if len(finite) else nan


def _share(mask: Mask) -> float:
    return float(np.mean(mask)) if len(mask) else nan


def is_within(value: float, low: float, high: float) -> bool:
    """True of a figure that keeps its bounds; there is nothing to keep where there is no figure."""
    return not isfinite(value) or low - 1e-9 <= value <= high + 1e-9

"""Remarks on the sampling of a log: rates too low to judge by, and attitudes that could not be compared."""

from math import inf
from typing import Final

from attest_mav.logs.source import Plan
from attest_mav.replay.comparison import Comparison
from attest_mav.replay.flight import Flight

ALIASING_HZ: Final = 45.0
"""Below about 50 Hz fast motion (vibration, a copter's corners) aliases; streams do not keep their rate exactly."""
NO_RATE_HZ: Final = 0.1
"""A lower rate is that of a clock that jumps, and not of a stream."""
LOST_HZ: Final = 3.0
"""Up to this rate a moving vehicle turns between two samples by more than their rates can show."""
MISSED_SHARE: Final = 0.01
"""Fewer attitudes without a reference than this are not worth a remark."""
FEW_RESTARTS: Final = 3
"""Fewer fresh alignments than this are not worth a remark."""


def rate_notes(plan: Plan, flight: Flight) -> list[str]:
    """The remark on an inertial stream that is too slow for what the vehicle did."""
    rate_hz, _ = flight.imu.rate_and_gaps()
    if rate_hz is None or not NO_RATE_HZ < rate_hz < ALIASING_HZ:
        return []
    comes = f"{plan.imu} comes at {rate_hz:.1f} Hz"
    if flight.motion.stands:
        return [f"{comes}: below about 50 Hz fast motion aliases; this vehicle stands"]
    if rate_hz <= LOST_HZ or flight.motion.is_undersampled:
        return [f"{comes}: motion is lost between samples, and the figures are no verdict on the autopilot"]
    return [f"{comes}: below about 50 Hz fast motion aliases, which the figures count as errors"]


def coverage_notes(plan: Plan, flight: Flight) -> list[str]:
    """The number of estimates that were compared and the reasons for the rest; and how often a filter began anew."""
    notes = [] if plan.reference is None else [_coverage(plan, run.comparison, run.aligned_s) for run in flight.runs]
    for run in flight.runs:
        restarts = sum([lane.restarts for lane in run.pipeline.lanes.values()])
        if restarts >= FEW_RESTARTS:
            notes.append(
                f"{run.comparison.name} began anew {restarts} times, where the clock of {plan.imu} pauses or jumps"
            )
    return list(dict.fromkeys(note for note in notes if note))


def _coverage(plan: Plan, comparison: Comparison, aligned_s: float) -> str:
    """The remark on one filter, "" if nearly all of its estimates were compared."""
    compared, outside, uneven = comparison.errors.samples, comparison.outside, comparison.uneven
    total = compared + outside + uneven
    if not total:
        lack = "found no attitude" if aligned_s == inf else "found no attitude that counts"
        return f"nothing was compared: {comparison.name} {lack}"
    if total - compared <= MISSED_SHARE * total:
        return ""
    reasons = []
    if outside:
        reasons.append(f"at {outside} there is no {plan.reference}")
    if uneven:
        reasons.append(f"at {uneven} {plan.reference} turns too unevenly between its samples")
    some = f"{compared} of {total} estimates of {comparison.name} were compared"
    return f"{some if compared else 'nothing was compared'}: {', '.join(reasons)}"

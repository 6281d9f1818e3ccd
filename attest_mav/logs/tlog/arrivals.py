"""Judges the times of arrival in a log against the vehicle's own clock: steps, another pace, or no times at all."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

from attest_mav.algebra import median
from attest_mav.logs.tlog.stamp_columns import StampColumn
from attest_mav.record import Record

STEP_S: Final = 5.0
"""A recorder's clock that moves by so much more or less than the vehicle's has been set. Radios hold frames back for
less."""
STEP_SHARE: Final = 0.2
"""The same as a share of the time between two ties: the pace need not be exact."""
PACE_TOLERANCE: Final = 0.1
"""Times of arrival whose pace differs from the vehicle's clock by more do not measure time."""
LONGEST_S: Final = 600.0
"""A longer pause between two ties shows nothing: the vehicle's clock may have begun again."""
SHOWN: Final = 3
"""So many steps are named."""


class Arrivals(Record):
    """The judgement on the times of arrival."""

    def __init__(self, fit: bool, notes: tuple[str, ...] = ()) -> None:
        self.fit: Final = fit
        """True if they run with the vehicle's clock."""
        self.notes: Final = notes
        """Remarks for people."""


class _Interval:
    """The time from one tie to the next, s: on the vehicle's clock, 0 where that begins again, and by arrival."""

    def __init__(self, at_s: float, passed_s: float, arrived_s: float) -> None:
        self.at_s: Final = at_s
        self.passed_s: Final = passed_s
        self.arrived_s: Final = arrived_s
        self.step_s: Final = arrived_s - passed_s
        """The recorder's time without the vehicle's."""

    @property
    def is_step(self) -> bool:
        """True if the recorder's clock was set; that it goes back shows where the vehicle's begins again, too."""
        if self.passed_s <= 0.0:
            return self.arrived_s < -STEP_S
        return abs(self.step_s) > STEP_S + STEP_SHARE * self.passed_s


def judge_arrivals(column: StampColumn | None, bad_stamps: int) -> Arrivals:
    """The judgement by the ties of a column. bad_stamps: frames whose time of arrival could not be believed."""
    intervals = [] if column is None else _intervals(column)
    if not intervals:
        return Arrivals(fit=True)
    if all(one.arrived_s == 0.0 for one in intervals):
        return Arrivals(False, ("the times of arrival stand still or are no times: the sensor's clock is used",))
    pace = median([one.arrived_s / one.passed_s for one in intervals if one.passed_s > 0.0] or [1.0])
    if abs(pace - 1.0) > PACE_TOLERANCE:
        return Arrivals(False, (_pace_note(intervals), *_bad_stamp_notes(bad_stamps)))
    steps = [one for one in intervals if one.is_step]
    return Arrivals(not steps, (*_step_notes(steps), *_bad_stamp_notes(bad_stamps)))


def _intervals(column: StampColumn) -> list[_Interval]:
    """The intervals between the ties on the attitudes' clock, or on the sensor's where there are no attitudes."""
    tied = [tie for tie in column.ties if tie.boot_ms >= 0]
    ties = tied or column.ties
    unit_s = 1e-6 if column.in_us else 1e-3
    found = []
    at_s = 0.0
    for before, after in pairwise(ties):
        if tied:
            passed_s = (after.boot_ms - before.boot_ms) * 1e-3
            arrived_s = (after.boot_rx_ns - before.boot_rx_ns) * 1e-9
        else:
            passed_s = (column.stamps[after.index] - column.stamps[before.index]) * unit_s
            arrived_s = (after.rx_ns - before.rx_ns) * 1e-9
        if passed_s < LONGEST_S:
            at_s += max(passed_s, 0.0)
            found.append(_Interval(at_s, max(passed_s, 0.0), arrived_s))
    return found


def _pace_note(intervals: Sequence[_Interval]) -> str:
    passed_s = sum([one.passed_s for one in intervals])
    arrived_s = sum([one.arrived_s for one in intervals])
    return (
        f"the times of arrival do not run with the vehicle's clock ({arrived_s:.0f} s for its {passed_s:.0f} s), which "
        "tells the duration"
    )


def _step_notes(steps: Sequence[_Interval]) -> Sequence[str]:
    """The first steps, with their places on the vehicle's clock."""
    if not steps:
        return ()
    named = [f"{one.step_s:+.0f} s near {one.at_s:.0f} s" for one in steps[:SHOWN]]
    rest = f" and {len(steps) - SHOWN} more" if len(steps) > SHOWN else ""
    return [f"the times of arrival step: the recorder's clock was set ({', '.join(named)}{rest})"]


def _bad_stamp_notes(bad_stamps: int) -> Sequence[str]:
    if not bad_stamps:
        return ()
    return (f"at least {bad_stamps} times of arrival are no times; those before them stand in their place",)

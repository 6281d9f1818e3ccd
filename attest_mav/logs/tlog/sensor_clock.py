"""Judges the clock of an inertial message from all its times: which rule makes them time since boot, and what to say.

The message set leaves it open whether ``time_usec`` is time since boot or UNIX time, and firmware adds counters of 32
bits, milliseconds in the place of microseconds, and fields that are never filled. The time since boot that everything
else is compared by is that of the attitudes; ``StampColumn.ties`` relate the two.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

from attest_mav.algebra import median
from attest_mav.logs.tlog.stamp_columns import StampColumn, Tie
from attest_mav.logs.tlog.stamp_repair import PLAIN, WRAP, StampRule, is_wrap
from attest_mav.mavlink.decode.boot_clock import FOLD_US, UNIX_US, BootClock
from attest_mav.record import Record

FEWEST: Final = 5
"""A column with fewer times is not judged."""
SAME_US: Final = 1_000_000
"""Two clocks that differ by less are one: an attitude may be that much older or newer than the inertial message."""
JUMP_US: Final = 3_000_000
"""A longer step forward may be a change to another clock."""
STILL_SHARE: Final = 0.02
"""A clock that moves at fewer of the messages than this stands still."""
BACK_SHARE: Final = 0.01
"""A clock that goes back at more of the messages than this is not one clock."""
DISORDER_SHARE: Final = 0.2
"""The same for steps back of less than ``SAME_US``: fewer are messages out of order."""
FACTORS: Final = (1000.0, 1e-3)
"""Units that are mistaken for each other differ by this much."""
FACTOR_TOLERANCE: Final = 5.0
"""Two clocks of one unit do not differ by more: a recorder may have squeezed the times of arrival."""


class SensorClock(Record):
    """The judgement on one column."""

    def __init__(
        self,
        rule: StampRule = PLAIN,
        note: str = "",
        obstacle: str = "",
        is_unix: bool = False,
        duration_s: float | None = None,
    ) -> None:
        self.rule: Final = rule
        self.note: Final = note
        """A remark for people, "" if all is well."""
        self.obstacle: Final = obstacle
        """The reason why no filter can use the times; "" if they can be used."""
        self.is_unix: Final = is_unix
        """True for UNIX time in microseconds that the rule makes time since boot."""
        self.duration_s: Final = duration_s
        """Time that passed on this clock, s; None where it cannot be told."""


class _Steps(Record):
    """The steps from one time to the next, in the number's own unit."""

    def __init__(self, moves: int, forward: int, jumps: int, backs: Sequence[int], wraps: Sequence[int]) -> None:
        self.moves: Final = moves
        """Number of steps other than zero."""
        self.forward: Final = forward
        """Sum of the steps forward, those over a wrap included."""
        self.jumps: Final = jumps
        """Number of steps forward of more than ``JUMP_US``."""
        self.backs: Final = backs
        """Sizes of the steps back that are no wraps."""
        self.wraps: Final = wraps
        """Places in the column behind a wrap."""


def judge_clock(column: StampColumn, boot_clock: BootClock, arrivals_fit: bool) -> SensorClock:
    """The judgement on a column. arrivals_fit: the times of arrival run with the vehicle's clock."""
    if len(column.stamps) < FEWEST:
        return SensorClock()
    unit_us = 1 if column.in_us else 1000
    factor = _factor(column, unit_us)
    us = unit_us * factor
    steps = _steps(column, us)
    if steps.moves < STILL_SHARE * len(column.stamps):
        return _standing_still(column, unit_us)
    obstacle = _two_clocks(column, steps, us)
    if obstacle:
        return SensorClock(obstacle=obstacle)
    duration_s = steps.forward * us * 1e-6
    shift_us, shift_note = _shift(column, steps, us, boot_clock, arrivals_fit)
    rule = StampRule(bool(steps.wraps), factor, shift_us // unit_us)
    parts = [_factor_note(column.in_us, factor), _wrap_note(steps), shift_note]
    note = "; ".join(part for part in parts if part)
    is_unix = shift_us <= -UNIX_US
    return SensorClock(rule, f"the time of {column.name} {note}" if note else "", "", is_unix, duration_s)


def _factor(column: StampColumn, unit_us: int) -> float:
    """The message's units in one of the number: 1, or one of ``FACTORS``, by the clock of the attitudes or arrivals."""
    for true_us in (_boot_us, _arrival_us):
        ratios = []
        for before, after in pairwise(column.ties):
            sent = (column.stamps[after.index] - column.stamps[before.index]) * unit_us
            passed_us = true_us(after) - true_us(before)
            if sent > 0 and passed_us > 0 and true_us(before) >= 0:
                ratios.append(passed_us / sent)
        if ratios:
            ratio = median(ratios)
            near = [one for one in FACTORS if one / FACTOR_TOLERANCE < ratio < one * FACTOR_TOLERANCE]
            return near[0] if near else 1.0
    return 1.0


def _boot_us(tie: Tie) -> int:
    return 1000 * tie.boot_ms if tie.boot_ms >= 0 else -1


def _arrival_us(tie: Tie) -> int:
    return tie.rx_ns // 1000


def _steps(column: StampColumn, us: float) -> _Steps:
    """The steps of a column; us: microseconds of one unit of the number."""
    moves = forward = jumps = 0
    backs: list[int] = []
    wraps: list[int] = []
    can_wrap = column.in_us or us < 1000.0
    before = column.stamps[0]
    for place, after in enumerate(column.stamps):
        step = after - before
        if step < 0 and can_wrap and is_wrap(before, after):
            wraps.append(place)
            step += WRAP
        if step < 0:
            backs.append(-step)
        elif step > 0:
            forward += step
            if step * us > JUMP_US:
                jumps += 1
        if step != 0:
            moves += 1
        before = after
    return _Steps(moves, forward, jumps, backs, wraps)


def _standing_still(column: StampColumn, unit_us: int) -> SensorClock:
    """The times of arrival in place of the times sent, from the boot that the attitudes tell."""
    ties = column.ties
    says = f"the time of {column.name} stands still at {column.stamps[-1]} {'us' if column.in_us else 'ms'}"
    if len({tie.rx_ns for tie in ties}) < len(ties) // 2:
        return SensorClock(obstacle=f"{says}, and the log has no times of arrival to take instead")
    boots = [_boot_us(tie) - tie.boot_rx_ns // 1000 for tie in ties if tie.boot_ms >= 0]
    shift_us = round(median(boots)) if boots else -ties[0].rx_ns // 1000
    passed_s = sum([max(0, after.rx_ns - before.rx_ns) for before, after in pairwise(ties)]) * 1e-9
    rule = StampRule(shift=shift_us // unit_us, by_arrival=True)
    return SensorClock(rule, f"{says}: the times of arrival are taken instead", duration_s=passed_s)


def _two_clocks(column: StampColumn, steps: _Steps, us: float) -> str:
    """The reason why the column is not one clock; "" if it is."""
    count, backs = len(column.stamps), len(steps.backs)
    if backs < max(3.0, BACK_SHARE * count):
        return ""
    sender = f"{column.system}/{column.component}"
    typical_us = median(steps.backs) * us
    if typical_us > SAME_US and steps.jumps >= backs // 2:
        return (
            f"the clock of {column.name} jumps {backs} times between two values {typical_us * 1e-6:.1f} s apart: "
            f"the log holds two vehicles with the id {sender}, and a filter can follow neither"
        )
    if backs < DISORDER_SHARE * count:
        return ""
    return (
        f"the clock of {column.name} goes back at {backs} of {count} messages, by {typical_us * 1e-6:.3f} s: the log "
        f"holds two vehicles with the id {sender}, or messages out of order"
    )


def _shift(column: StampColumn, steps: _Steps, us: float, boot_clock: BootClock, arrivals_fit: bool) -> tuple[int, str]:
    """Microseconds to be added to make the column time since boot, and the remark on them."""
    unix = column.stamps[-1] * us >= UNIX_US
    known = not unix or boot_clock.since_boot_ns(column.system, round(column.stamps[-1] * us)) >= 0
    folded_us = 0 if known else round(column.stamps[-1] * us) // FOLD_US * FOLD_US
    apart = sorted(_apart_us(column, steps, us, boot_clock, arrivals_fit))
    if not apart:
        first_us = round(column.stamps[0] * us)
        return (0, "") if known else (-first_us, "is UNIX time; it is counted from the first message")
    offset_us = round(median(apart))
    if abs(offset_us) <= SAME_US:
        return (0, "") if known else (-folded_us, "is UNIX time, of which the attitudes carry the last 32 bits")
    if apart[len(apart) * 9 // 10] - apart[len(apart) // 10] > SAME_US:
        return (0, "does not run with that of the attitudes")
    turns = round(offset_us / WRAP)
    if abs(offset_us - turns * WRAP) <= SAME_US:
        count = f"{abs(turns)} turn{'s' if abs(turns) > 1 else ''} of a counter of 32 bits"
        return (-turns * WRAP, f"differs from the attitudes' by {count}: it is brought to theirs")
    told = "is UNIX time; no SYSTEM_TIME tells when the vehicle booted, so" if unix else "does not count from boot:"
    return (-offset_us - folded_us, f"{told} it is set by the attitudes' times")


def _apart_us(column: StampColumn, steps: _Steps, us: float, boot_clock: BootClock, arrivals_fit: bool) -> list[int]:
    """Time of the message less time since boot at each tie, modulo a counter of 32 bits in milliseconds."""
    found = []
    for tie in [one for one in column.ties if one.boot_ms >= 0]:
        wrapped = WRAP * sum([place <= tie.index for place in steps.wraps])
        time_us = round((column.stamps[tie.index] + wrapped) * us)
        since_boot_ns = boot_clock.since_boot_ns(column.system, time_us)
        if since_boot_ns >= 0:
            time_us = since_boot_ns // 1000
        between_us = (tie.rx_ns - tie.boot_rx_ns) // 1000 if arrivals_fit else 0
        apart_us = time_us - 1000 * tie.boot_ms - between_us
        found.append((apart_us + FOLD_US // 2) % FOLD_US - FOLD_US // 2)
    return found


def _factor_note(in_us: bool, factor: float) -> str:
    if factor == 1.0:
        return ""
    named = {(True, 1000.0): "milliseconds", (True, 1e-3): "nanoseconds", (False, 1e-3): "microseconds"}
    unit = named.get((in_us, factor), "seconds")
    return f"is in {unit} in the place of {'microseconds' if in_us else 'milliseconds'}"


def _wrap_note(steps: _Steps) -> str:
    """The remark on wraps."""
    times = len(steps.wraps)
    if not times:
        return ""
    return f"begins again at 2^32 ({times} time{'s' if times > 1 else ''} in this log): it is continued"

"""Faults as users write them: ``NAME[=SIZE]@START[+DURATION]``.

::

    gyro1-bias-x=5@20+15    5 deg/s on the first gyro's x axis, from 20 s on for 15 s
    gyro-bias-z=-3@20       -3 deg/s on the z axis of both gyros, from 20 s on for ever
    accel2-stuck=5@10+12    all axes of the second accelerometer
    receiver-off@30+60      no size

NAME is a name of ``faults.KINDS``. A number behind its first word chooses one of the two inertial sensors, a last word
one axis; without them all sensors and axes have the fault.
"""

import re
from collections.abc import Iterable
from difflib import get_close_matches
from math import inf, isfinite
from typing import Final

from attest_mav.errors import UsageError
from attest_mav.sim.faults import KINDS, SENSORS, Fault, FaultKind

FORM: Final = "NAME[=SIZE]@START[+DURATION]"
EXAMPLE: Final = "gyro1-bias-x=5@20+15"

LONGEST_S: Final = 1e6
"""The latest start and the longest duration."""

_FORM: Final = re.compile(r"(?P<name>[^=@]+)(=(?P<size>[^@]*))?@(?P<start>[^+]*)(\+(?P<duration>.*))?")
_NAME: Final = re.compile(r"(?P<word>[a-z]+)(?P<number>\d*)(?P<rest>(-[a-z]+)*)")


def parse_faults(texts: Iterable[str]) -> tuple[Fault, ...]:
    """The faults of several texts; UsageError says what is wrong with one."""
    return tuple(parse_fault(text) for text in texts)


def parse_fault(text: str) -> Fault:
    """One fault; UsageError says what is wrong with it."""
    found = _FORM.fullmatch(text)
    if found is None:
        raise _wrong(text, f"expected {FORM}, for example {EXAMPLE}")
    kind, number, axis = _named(text, found["name"])
    start_s = _number(text, found["start"], "START", 0.0, LONGEST_S)
    duration_s = inf
    if found["duration"] is not None:
        if not kind.lasts:
            raise _wrong(text, f"{kind.name} has no duration")
        duration_s = _number(text, found["duration"], "DURATION", 0.0, LONGEST_S)
        if duration_s == 0.0:
            raise _wrong(text, "DURATION 0: expected more than 0 s, or none for ever")
    return Fault(
        kind,
        start_s,
        start_s + duration_s,
        _size(text, kind, found["size"]),
        SENSORS if number is None else (number - 1,),
        tuple(range(len(kind.axes))) if axis is None else (kind.axes.index(axis),),
    )


def _named(text: str, name: str) -> tuple[FaultKind, int | None, str | None]:
    """The kind, the number of the sensor (from 1) and the axis that a name holds; None for all of them."""
    parts = _NAME.fullmatch(name)
    kinds = {kind.name: kind for kind in KINDS}
    plain = name if parts is None else parts["word"] + parts["rest"]
    head, _, last = plain.rpartition("-")
    axis = last if plain not in kinds and head in kinds and last in kinds[head].axes else None
    kind = kinds.get(plain if axis is None else head)
    if kind is None:
        raise _wrong(text, _suggestion(plain, kinds))
    digits = "" if parts is None else parts["number"]
    if not digits:
        return kind, None, axis
    if not kind.numbered:
        raise _wrong(text, f"{kind.name} takes no number")
    if digits not in {str(sensor + 1) for sensor in SENSORS}:
        raise _wrong(text, f"there is no sensor {digits[:9]}: expected 1 or 2, or no number for both")
    return kind, int(digits), axis


def _suggestion(plain: str, kinds: dict[str, FaultKind]) -> str:
    """A hint at the nearest valid name."""
    head, _, last = plain.rpartition("-")
    if head in kinds:
        axes = kinds[head].axes
        return f"{head} has no axis {last[:20]}" + (f": expected {', '.join(axes)}, or none for all" if axes else "")
    near = get_close_matches(plain, kinds, n=1)
    hint = f"did you mean {near[0]}?" if near else f"expected one of {', '.join(kinds)}"
    return f"unknown fault {plain[:40]!r}; {hint}"


def _size(text: str, kind: FaultKind, size: str | None) -> float:
    """The size in SI units; 0 for a fault without one."""
    if kind.size is None:
        if size is not None:
            raise _wrong(text, f"{kind.name} takes no size")
        return 0.0
    if size is None:
        raise _wrong(text, f"{kind.name} needs a size in {kind.size.unit}: {kind.name}=SIZE@START")
    return _number(text, size, f"{kind.name} in {kind.size.unit}", kind.size.low, kind.size.high) * kind.size.si


def _number(text: str, word: str, what: str, low: float, high: float) -> float:
    """A number within limits."""
    try:
        value = float(word)
    except ValueError:
        raise _wrong(text, f"{what} {word[:20]!r}: expected a number") from None
    if not (isfinite(value) and low <= value <= high):
        raise _wrong(text, f"{what} {value:g} is out of range: expected {low:g} to {high:g}")
    return value


def _wrong(text: str, why: str) -> UsageError:
    return UsageError(f"fault {text[:60]!r}: {why}")


def spelling(kind: FaultKind) -> str:
    """How a fault is written: N where a number, A where an axis may stand."""
    word, dash, rest = kind.name.partition("-")
    size = "" if kind.size is None else f"={kind.size.unit.upper()}"
    return f"{word}{'[N]' * kind.numbered}{dash}{rest}{'[-A]' * bool(kind.axes)}{size}"

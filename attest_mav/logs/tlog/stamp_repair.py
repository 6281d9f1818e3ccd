"""Writes the time since boot into messages whose own time is something else, so that the decoder needs to know nothing.

The rule is the judgement of the first pass (``sensor_clock``); the repair applies it frame by frame.
"""

from typing import Final

from attest_mav.logs.tlog.stamps import TimeField
from attest_mav.mavlink.decode.boot_clock import UNIX_US
from attest_mav.mavlink.wire.frame import Frame
from attest_mav.record import Record

WRAP: Final = 1 << 32
"""A counter of 32 bits begins again after so many units."""
WRAP_WINDOW: Final = 1 << 26
"""A step back is a wrap if the counter, continued past it, would have moved on by at most this; 67 s at 1 us."""


class StampRule(Record):
    """The relation of a message's time to the time since boot, both in the message's own unit."""

    def __init__(self, wraps: bool = False, factor: float = 1.0, shift: int = 0, by_arrival: bool = False) -> None:
        self.wraps: Final = wraps
        """True for a counter that begins again after ``WRAP`` units."""
        self.factor: Final = factor
        """Message's units in one unit of the number that is sent."""
        self.shift: Final = shift
        """Is added after the factor."""
        self.by_arrival: Final = by_arrival
        """True to take the time of arrival in place of the time sent."""

    @property
    def is_plain(self) -> bool:
        """True if nothing has to be repaired."""
        return not self.wraps and not self.by_arrival and self.factor == 1.0 and self.shift == 0


PLAIN: Final = StampRule()
"""The time sent is the time since boot."""


def is_wrap(before: int, after: int) -> bool:
    """True if a counter of 32 bits has begun again between two values."""
    return after < before < WRAP and after + WRAP - before <= WRAP_WINDOW


class StampRepair:
    """Applies a rule to the frames of one kind of message, in order."""

    def __init__(self, rule: StampRule, field: TimeField) -> None:
        self._rule: Final = rule
        self._field: Final = field
        self._last = -1
        self._wrapped = 0

    def repaired(self, frame: Frame) -> Frame:
        """The frame with its time replaced."""
        rule, field = self._rule, self._field
        if rule.by_arrival:
            unit_ns = 1000 if field.length > 4 else 1_000_000
            return with_time(frame, field, frame.rx_ns // unit_ns + rule.shift)
        sent = self._unwrapped(_sent(frame, field))
        # A product with 1.0 would round UNIX microseconds to the digits of a float.
        return with_time(frame, field, (sent if rule.factor == 1.0 else round(sent * rule.factor)) + rule.shift)

    def _unwrapped(self, sent: int) -> int:
        """The number sent, continued over the wraps; a reboot begins anew."""
        if not self._rule.wraps:
            return sent
        if is_wrap(self._last, sent):
            self._wrapped += WRAP
        elif sent + WRAP_WINDOW < self._last:
            self._wrapped = 0
        self._last = sent
        return sent + self._wrapped


class FixRepair:
    """Shifts the UNIX time of a receiver's messages, as that of the inertial ones of the same system is shifted."""

    def __init__(self, shift_us: int, field: TimeField) -> None:
        self._shift_us: Final = shift_us
        self._field: Final = field

    def repaired(self, frame: Frame) -> Frame:
        """The frame with its time replaced, if that is UNIX time."""
        sent = _sent(frame, self._field)
        return with_time(frame, self._field, sent + self._shift_us) if sent >= UNIX_US else frame


def _sent(frame: Frame, field: TimeField) -> int:
    """The time of the frame. MAVLink 2 may have cut off the zeros at its end."""
    return int.from_bytes(frame.payload[field.at : field.at + field.length], "little")


def with_time(frame: Frame, field: TimeField, time: int) -> Frame:
    """The frame with this time, modulo the size of its field."""
    begin, length = int(field.at), int(field.length)
    payload = frame.payload.ljust(begin + length, b"\0")
    stamp = (time % (1 << (8 * length))).to_bytes(length, "little")
    return Frame(
        frame.message_id,
        frame.system,
        frame.component,
        frame.sequence,
        frame.version,
        frame.signed,
        payload[:begin] + stamp + payload[begin + length :],
        frame.rx_ns,
        frame.offset,
        frame.size,
    )

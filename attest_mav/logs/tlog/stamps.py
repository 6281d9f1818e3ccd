"""The times that messages carry, read from the bytes of a frame without decoding it."""

from typing import Final

from mypy_extensions import i64

from attest_mav.mavlink.constants import INERTIAL_MESSAGES
from attest_mav.mavlink.decode.boot_clock import UNIX_US
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import MAGIC_V2, header_at, message_id_at

BOOT_TIMED: Final = (
    "ATTITUDE",
    "ATTITUDE_QUATERNION",
    "SYSTEM_TIME",
    "GLOBAL_POSITION_INT",
    "LOCAL_POSITION_NED",
    "SCALED_PRESSURE",
    "RC_CHANNELS",
)
"""Messages with the time since boot in milliseconds (``time_boot_ms``), whichever clock the inertial ones carry."""
IN_MICROSECONDS: Final = "time_usec"
IN_MILLISECONDS: Final = "time_boot_ms"
SYSTEMS: Final = 256
SAME_CLOCK_US: Final = 5_000_000
"""Times of one clock, read from neighbouring messages, differ by less."""
_TIME_BYTES: Final = {IN_MICROSECONDS: 8, IN_MILLISECONDS: 4}


class TimeField:
    """The place of the time in the payload of one kind of message."""

    def __init__(self, at: int, length: int) -> None:
        self.at: Final[i64] = at
        """Offset in the payload, bytes."""
        self.length: Final[i64] = length
        """4 for milliseconds, 8 for microseconds."""


def time_field(dialect: Dialect, name: str) -> TimeField:
    """The time of the message called ``name``; KeyError if it has none."""
    layout = dialect.layout(name)
    for field, length in _TIME_BYTES.items():
        if field in layout.fields:
            return TimeField(layout.offset(field), length)
    raise KeyError(name)


def time_at(data: bytes, at: i64, field: TimeField) -> i64:
    """The time in the frame at ``at``, in the message's own unit. MAVLink 2 may have cut off the zeros at its end."""
    payload = at + header_at(data, at)
    size: i64 = data[at + 1]
    value: i64 = 0
    shift: i64 = 0
    byte = field.at
    end = field.at + field.length
    while byte < end and byte < size:
        part: i64 = data[payload + byte]
        value |= part << shift
        shift += 8
        byte += 1
    return value


class NewestBootTime:
    """The newest time since boot that each system has sent."""

    def __init__(self, dialect: Dialect) -> None:
        names = (*BOOT_TIMED, *INERTIAL_MESSAGES)
        self._fields: Final = {dialect.id_of(name): time_field(dialect, name) for name in names}
        self._inertial: Final = frozenset([dialect.id_of(name) for name in INERTIAL_MESSAGES])
        self._newest_us: Final = [-1] * SYSTEMS

    def at(self, data: bytes, at: i64) -> i64:
        """The newest time of the sender of the frame at ``at``, with its own, ns.

        The clock of an inertial message may be another one: its time counts only near the one known, or as the first.
        """
        message_id = message_id_at(data, at)
        system = data[at + 5] if data[at] == MAGIC_V2 else data[at + 3]
        newest_us: i64 = self._newest_us[system]
        field = self._fields.get(message_id)
        if field is not None:
            time = time_at(data, at, field)
            time_us: i64 = time if field.length > 4 else 1000 * time
            is_near = newest_us < 0 or -SAME_CLOCK_US < time_us - newest_us < SAME_CLOCK_US
            if (is_near or message_id not in self._inertial) and 0 <= time_us < UNIX_US:
                self._newest_us[system] = newest_us = time_us
        return newest_us * 1000 if newest_us > 0 else 0

"""The times of all inertial messages of a log, collected in the first pass for a judgement on each sensor's clock.

A column holds the time of each message, in the message's own unit; 8 bytes a message. Some messages are tied to the
other two clocks: the host's, by the time of arrival, and the autopilot's, by the next attitude.
"""

from array import array
from typing import Final

from mypy_extensions import i64

from attest_mav.logs.tlog.stamps import TimeField, time_at, time_field
from attest_mav.mavlink.constants import INERTIAL_MESSAGES
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import header_at

SENSOR_NUMBER: Final = "id"
"""The field with the sensor's number in messages that several sensors send."""
TYING: Final = ("ATTITUDE", "ATTITUDE_QUATERNION")
"""The messages whose time since boot is tied to the sensor's."""
NO_SENSOR_NUMBER: Final = -1


class Tie:
    """One inertial message and its neighbours on the other clocks."""

    def __init__(self, index: int, rx_ns: int) -> None:
        self.index: Final = index
        """Place in the column."""
        self.rx_ns: Final = rx_ns
        """Arrival, ns."""
        self.boot_ms = -1
        """Time since boot of the next attitude, ms; -1 if none followed."""
        self.boot_rx_ns = 0
        """Arrival of that attitude, ns."""


class StampColumn:
    """The times of one inertial message from one sender, those of its first sensor."""

    def __init__(self, system: int, component: int, name: str, field: TimeField, number_at: int) -> None:
        self.system: Final = system
        self.component: Final = component
        self.name: Final = name
        self.in_us: Final = field.length > 4
        """True for times in microseconds, False for milliseconds."""
        self.field: Final = field
        self.number_at: Final[i64] = number_at
        """Offset of the sensor's number in the payload, or ``NO_SENSOR_NUMBER``."""
        self.stamps: Final = array("q")
        self.ties: Final[list[Tie]] = []


class StampColumns:
    """The columns of all senders."""

    def __init__(self, dialect: Dialect) -> None:
        self.columns: Final[dict[int, StampColumn]] = {}
        """By the key of ``MessageCounter.counts``."""
        self._dialect: Final = dialect
        self._tying: Final = {dialect.id_of(name): time_field(dialect, name) for name in TYING}
        self._open: Final[list[tuple[int, Tie]]] = []

    def wanted_ids(self) -> tuple[frozenset[int], frozenset[int]]:
        """The ids of the inertial messages, and of those that tie them to the time since boot."""
        return frozenset([self._dialect.id_of(name) for name in INERTIAL_MESSAGES]), frozenset(self._tying)

    def add(self, key: int, data: bytes, at: i64) -> bool:
        """Take the inertial message at ``at``; False for that of a further sensor, which is left out."""
        column = self.columns.get(key)
        if column is None:
            column = self.columns[key] = self._new_column(key)
        number_at: i64 = column.number_at
        if 0 <= number_at < data[at + 1] and data[at + header_at(data, at) + number_at] > 0:
            return False
        column.stamps.append(time_at(data, at, column.field))
        return True

    def tie(self, key: int, rx_ns: int) -> None:
        """Tie the newest message of a column to its arrival, and to the next attitude of its system."""
        column = self.columns[key]
        tie = Tie(len(column.stamps) - 1, rx_ns)
        column.ties.append(tie)
        self._open.append((column.system, tie))

    def waits(self, system: int) -> bool:
        """True if a tie waits for an attitude of the system."""
        return any(waiting == system for waiting, _ in self._open)

    def close(self, system: int, message_id: int, data: bytes, at: i64, rx_ns: int) -> None:
        """Take the attitude at ``at``, for which ties wait."""
        boot_ms = time_at(data, at, self._tying[message_id])
        for waiting, tie in self._open:
            if waiting == system:
                tie.boot_ms = boot_ms
                tie.boot_rx_ns = rx_ns
        still = [one for one in self._open if one[0] != system]
        self._open.clear()
        self._open.extend(still)

    def _new_column(self, key: int) -> StampColumn:
        name = self._dialect.name_of(key >> 16)
        layout = self._dialect.layout(name)
        number_at = layout.offset(SENSOR_NUMBER) if SENSOR_NUMBER in layout.fields else NO_SENSOR_NUMBER
        return StampColumn((key >> 8) & 0xFF, key & 0xFF, name, time_field(self._dialect, name), number_at)

"""Counts the messages of a tlog, at the walker's full speed: a frame object is made for few of the frames."""

from typing import Final

from mypy_extensions import i64

from attest_mav.logs.source import VehicleId
from attest_mav.logs.tlog.stamp_columns import StampColumns
from attest_mav.logs.tlog.walker import TlogWalker
from attest_mav.mavlink.decode.autopilot_parameters import parameter_bytes
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import MAGIC_V2, header_at, message_id_at

FIRST: Final = 16
EVERY: Final = 16
"""Of each kind of message from each sender, the first ``FIRST`` frames and then one in ``EVERY`` are returned.

PARAM_VALUE is one exception: a ground station records a thousand parameters, each of them once: the frames of
all parameters that tell a setting are returned, and no others. STATUSTEXT is the other one: all are returned, as the
firmware names itself in one of them.
"""
MOST_KINDS: Final = 8192
"""So many kinds of messages are told apart, a kind being one message of one sender; of others only the frames count."""
NAME_BYTES: Final = 16


class KindCount:
    """Number of frames of one kind."""

    def __init__(self) -> None:
        self.frames: i64 = 0


class MessageCounter(TlogWalker):
    """Counts all frames of a tlog and returns a sample of the wanted ones."""

    def __init__(self, dialect: Dialect, wanted: frozenset[int] | None, bare: bool = False) -> None:
        super().__init__(dialect, wanted, bare)
        self._kinds: Final[dict[int, KindCount]] = {}
        """By ``counter_key``."""
        parameter = dialect.layout("PARAM_VALUE")
        self._parameter_id: i64 = parameter.message_id
        self._text_id: i64 = dialect.id_of("STATUSTEXT")
        self._name_at: i64 = parameter.offset("param_id")
        self._names: Final = parameter_bytes()
        self.first_rx_ns = 0
        """Arrival of the first frame, ns."""
        self.last_rx_ns = 0
        """Arrival of the last frame, ns."""
        self.stamps: Final = StampColumns(dialect)
        """The times of all inertial messages."""
        inertial, tying = self.stamps.wanted_ids()
        self._is_inertial: Final = dialect.flags(inertial)
        self._is_tying: Final = dialect.flags(tying)

    @property
    def counts(self) -> dict[int, int]:
        """Frames by ``counter_key``."""
        return {key: kind.frames for key, kind in self._kinds.items()}

    def count_of(self, sender: VehicleId, message_id: int) -> int:
        """Number of frames of one kind from one sender."""
        kind = self._kinds.get(counter_key(sender[0], sender[1], message_id))
        return 0 if kind is None else kind.frames

    def _take(self, size: i64) -> None:
        """Count the frame at the present place, and return it if it is its turn."""
        data = self._data
        at = self._place
        sender = at + (5 if data[at] == MAGIC_V2 else 3)
        message_id = message_id_at(data, at)
        key = counter_key(data[sender], data[sender + 1], message_id)
        kind = self._kinds.get(key)
        if kind is None:
            if len(self._kinds) >= MOST_KINDS:
                self._pass_over(size, sender)
                return
            kind = self._kinds[key] = KindCount()
        count = kind.frames
        kind.frames = count + 1
        if self.frames == 0:
            self.first_rx_ns = self._arrival(size)
        if message_id == self._parameter_id:
            is_sampled = self._tells_setting(at)
        else:
            is_sampled = count < FIRST or count % EVERY == 0 or message_id == self._text_id
        if is_sampled or self._final:
            self.last_rx_ns = self._arrival(size)
        if self._is_inertial[message_id]:
            if self.stamps.add(key, data, at) and is_sampled:
                self.stamps.tie(key, self.last_rx_ns)
        elif self._is_tying[message_id] and self.stamps.waits(data[sender]):
            self.stamps.close(data[sender], message_id, data, at, self._arrival(size))
        if is_sampled:
            super()._take(size)
        else:
            self._pass_over(size, sender)

    def _pass_over(self, size: i64, sender: i64) -> None:
        """Count the frame at the present place as intact, and go behind it. sender: place of the sender's ids."""
        self.frames += 1
        self._sequences.follow(self._data[sender], self._data[sender + 1], self._data[sender - 1])
        self._pass(size)

    def _tells_setting(self, at: i64) -> bool:
        """True if the PARAM_VALUE at ``at`` is that of a parameter that tells a setting, by the bytes of its name."""
        data = self._data
        payload = at + header_at(data, at)
        begin = payload + self._name_at
        end = min(begin + NAME_BYTES, payload + data[at + 1])
        # Compiled, a slice that ends before it begins is an error: MAVLink 2 cuts off a name of zeros.
        return end > begin and data[begin:end].split(b"\0", 1)[0] in self._names


def counter_key(system: i64, component: i64, message_id: i64) -> int:
    """One number for a kind of message from one sender."""
    return (message_id << 16) | (system << 8) | component


def key_parts(key: int) -> tuple[int, int, int]:
    """System, component and message id of a ``counter_key``."""
    return ((key >> 8) & 0xFF, key & 0xFF, key >> 16)

"""MAVLink 2 frames to send, each with the next sequence number of its sender.

The layouts come from the dialect; a message that is sent often is packed through one ready structure.
"""

from collections.abc import Callable, Mapping
from struct import Struct
from typing import Any, Final

from attest_mav.mavlink.constants import (
    MAV_CMD_REQUEST_MESSAGE,
    MAV_CMD_SET_MESSAGE_INTERVAL,
    MAV_PARAM_TYPE_REAL32,
    MAVLINK_VERSION,
)
from attest_mav.mavlink.dialect import Dialect, Layout
from attest_mav.mavlink.wire.checksum import with_checksum
from attest_mav.mavlink.wire.frame import MAGIC_V2, SIGNED
from attest_mav.types import Quat, Vec3

STATUSTEXT_BYTES: Final = 50
NAME_BYTES: Final = 10

_HEADER: Final = Struct("<BBBBBBBHB")
"""Magic, payload length, incompatibility and compatibility flags, sequence, sender, and the id in three bytes."""

Signer = Callable[[bytes], bytes]
"""The 13 bytes of signature behind a frame, which is given from its magic to its checksum."""

COVARIANCE_UNKNOWN: Final[tuple[float, ...]] = (float("nan"),) * 9


class Encoder:
    """Frames of one sender. Values that do not fit their field raise struct.error: a bug of the caller.

    signer: signs every frame; None leaves them unsigned.
    """

    def __init__(self, dialect: Dialect, system: int, component: int, signer: Signer | None = None) -> None:
        self.dialect: Final = dialect
        self.system: Final = system
        self.component: Final = component
        self.signer: Final = signer
        self._sequence = 0
        self._heartbeat: Final = dialect.layout("HEARTBEAT").pick(
            "custom_mode", "type", "autopilot", "base_mode", "system_status", "mavlink_version"
        )
        self._quaternion: Final = dialect.layout("ATTITUDE_QUATERNION").pick(
            "time_boot_ms", "q1", "q2", "q3", "q4", "rollspeed", "pitchspeed", "yawspeed"
        )
        self._quaternion_cov: Final = dialect.layout("ATTITUDE_QUATERNION_COV").pick(
            "time_usec", "q", "rollspeed", "pitchspeed", "yawspeed", "covariance"
        )
        self._command: Final = dialect.layout("COMMAND_LONG").pick(
            "param1", "param2", "command", "target_system", "target_component", "confirmation"
        )
        self._stream: Final = dialect.layout("REQUEST_DATA_STREAM").pick(
            "req_message_rate", "target_system", "target_component", "req_stream_id", "start_stop"
        )
        self._parameter: Final = dialect.layout("PARAM_REQUEST_READ").pick(
            "param_index", "target_system", "target_component", "param_id"
        )
        self._own_parameter: Final = dialect.layout("PARAM_VALUE").pick(
            "param_value", "param_count", "param_index", "param_id", "param_type"
        )
        self._ack: Final = dialect.layout("COMMAND_ACK").pick("command", "result", "target_system", "target_component")
        self._named: Final = dialect.layout("NAMED_VALUE_FLOAT").pick("time_boot_ms", "value", "name")
        self._text: Final = dialect.layout("STATUSTEXT").pick("severity", "text", "id", "chunk_seq")
        self._timesync: Final = dialect.layout("TIMESYNC").pick("tc1", "ts1")

    def heartbeat(
        self, vehicle_type: int, autopilot: int, base_mode: int, system_status: int, custom_mode: int = 0
    ) -> bytes:
        """HEARTBEAT: MAV_TYPE, MAV_AUTOPILOT, MAV_MODE_FLAG, MAV_STATE."""
        payload = self._heartbeat.pack(custom_mode, vehicle_type, autopilot, base_mode, system_status, MAVLINK_VERSION)
        return self.frame(self._heartbeat.layout, payload)

    def attitude_quaternion(self, time_boot_ms: int, q_nb: Quat, rates: Vec3) -> bytes:
        """ATTITUDE_QUATERNION with repr_offset_q zero. q_nb: body to NED; rates: rad/s."""
        payload = self._quaternion.pack(time_boot_ms, q_nb[0], q_nb[1], q_nb[2], q_nb[3], rates[0], rates[1], rates[2])
        return self.frame(self._quaternion.layout, payload)

    def attitude_quaternion_cov(
        self, time_usec: int, q_nb: Quat, rates: Vec3, covariance: tuple[float, ...] = COVARIANCE_UNKNOWN
    ) -> bytes:
        """ATTITUDE_QUATERNION_COV. covariance: of the attitude, rad^2, nine values row by row; all NaN for unknown."""
        payload = self._quaternion_cov.pack(time_usec, *q_nb, *rates, *covariance)
        return self.frame(self._quaternion_cov.layout, payload)

    def set_message_interval(
        self, target_system: int, target_component: int, message_id: int, interval_us: int, confirmation: int = 0
    ) -> bytes:
        """COMMAND_LONG with MAV_CMD_SET_MESSAGE_INTERVAL; interval_us 0 is the default rate, -1 stops."""
        payload = self._command.pack(
            float(message_id),
            float(interval_us),
            MAV_CMD_SET_MESSAGE_INTERVAL,
            target_system,
            target_component,
            confirmation,
        )
        return self.frame(self._command.layout, payload)

    def request_message(self, target_system: int, target_component: int, message_id: int) -> bytes:
        """COMMAND_LONG with MAV_CMD_REQUEST_MESSAGE: the message once."""
        payload = self._command.pack(
            float(message_id), 0.0, MAV_CMD_REQUEST_MESSAGE, target_system, target_component, 0
        )
        return self.frame(self._command.layout, payload)

    def request_data_stream(
        self, target_system: int, target_component: int, stream_id: int, rate_hz: int, start: bool = True
    ) -> bytes:
        """REQUEST_DATA_STREAM, the older way to ask for a group of messages (MAV_DATA_STREAM)."""
        payload = self._stream.pack(rate_hz, target_system, target_component, stream_id, 1 if start else 0)
        return self.frame(self._stream.layout, payload)

    def param_request_read(self, target_system: int, target_component: int, name: str) -> bytes:
        """PARAM_REQUEST_READ of the parameter of that name, at most 16 characters."""
        payload = self._parameter.pack(-1, target_system, target_component, name.encode("ascii"))
        return self.frame(self._parameter.layout, payload)

    def param_value(self, name: str, value: float, count: int, index: int) -> bytes:
        """PARAM_VALUE of type REAL32: a parameter of at most 16 characters, the index of one of ``count``."""
        payload = self._own_parameter.pack(value, count, index, name.encode("ascii"), MAV_PARAM_TYPE_REAL32)
        return self.frame(self._own_parameter.layout, payload)

    def command_ack(self, command: int, result: int, target_system: int, target_component: int) -> bytes:
        """COMMAND_ACK: MAV_CMD, MAV_RESULT, and who had asked."""
        return self.frame(self._ack.layout, self._ack.pack(command, result, target_system, target_component))

    def named_value_float(self, time_boot_ms: int, name: str, value: float) -> bytes:
        """NAMED_VALUE_FLOAT; the name is cut at ten bytes."""
        payload = self._named.pack(time_boot_ms, value, name.encode("ascii", "replace")[:NAME_BYTES])
        return self.frame(self._named.layout, payload)

    def statustext(self, severity: int, text: str) -> bytes:
        """STATUSTEXT in one chunk: MAV_SEVERITY, and text that is cut at fifty bytes."""
        payload = self._text.pack(severity, text.encode("ascii", "replace")[:STATUSTEXT_BYTES], 0, 0)
        return self.frame(self._text.layout, payload)

    def statustexts(self, severity: int, text: str, text_id: int) -> list[bytes]:
        """STATUSTEXT in as many chunks as the text needs. text_id: joins the chunks of one text, not 0."""
        raw = text.encode("ascii", "replace")
        if len(raw) <= STATUSTEXT_BYTES:
            return [self.statustext(severity, text)]
        # A chunk with a zero byte is the last one: a text of whole chunks is followed by an empty one.
        count = len(raw) // STATUSTEXT_BYTES + 1
        chunks = [raw[STATUSTEXT_BYTES * part : STATUSTEXT_BYTES * (part + 1)] for part in range(count)]
        return [
            self.frame(self._text.layout, self._text.pack(severity, chunk, text_id, part))
            for part, chunk in enumerate(chunks)
        ]

    def timesync(self, tc1_ns: int, ts1_ns: int, target_system: int = 0, target_component: int = 0) -> bytes:
        """TIMESYNC: tc1 zero asks, anything else answers. The target is an extension behind the dialect's fields."""
        payload = self._timesync.pack(tc1_ns, ts1_ns) + bytes((target_system, target_component))
        return self.frame(self._timesync.layout, payload)

    def message(self, name: str, values: Mapping[str, Any]) -> bytes:
        """Any message by field names; fields that are not named are zero. Raises KeyError for unknown names."""
        layout = self.dialect.layout(name)
        return self.frame(layout, layout.from_dict(values))

    def frame(self, layout: Layout, payload: bytes) -> bytes:
        """A frame around a payload in wire order; its trailing zeros are cut off, but for the first byte."""
        payload = payload.rstrip(b"\0") or payload[:1]
        sequence = self._sequence
        self._sequence = (sequence + 1) & 0xFF
        mid = layout.message_id
        signer = self.signer
        flags = 0 if signer is None else SIGNED
        header = _HEADER.pack(
            MAGIC_V2, len(payload), flags, 0, sequence, self.system, self.component, mid & 0xFFFF, mid >> 16
        )
        frame = with_checksum(header + payload, layout.crc_extra)
        return frame if signer is None else frame + signer(frame)

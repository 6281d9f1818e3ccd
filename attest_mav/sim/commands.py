"""How the autopilot answers: commands, stream requests and time synchronisation.

SET_MESSAGE_INTERVAL and REQUEST_MESSAGE are acknowledged, every other command is UNSUPPORTED; REQUEST_DATA_STREAM is
a message without acknowledgement (PX4 ignores it). TIMESYNC requests are answered with the time of arrival, to all, as
ArduPilot does. PARAM_REQUEST_READ is answered for the parameters that there are, and for others not at all, as both
firmwares do; PARAM_SET takes effect at once and is announced by PARAM_VALUE. A message that is addressed to somebody
else, or that claims to come from the autopilot itself, is dropped.
"""

from math import isfinite
from typing import Final

from attest_mav.mavlink.constants import (
    MAV_CMD_REQUEST_MESSAGE,
    MAV_CMD_SET_MESSAGE_INTERVAL,
    MAV_RESULT_ACCEPTED,
    MAV_RESULT_DENIED,
    MAV_RESULT_FAILED,
    MAV_RESULT_UNSUPPORTED,
    UINT16_MAX,
)
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.framer import Frame
from attest_mav.sim.parameters import ParameterTable
from attest_mav.sim.personality import Personality
from attest_mav.sim.streams import Streams

COMMAND_LONG: Final = "COMMAND_LONG"
REQUEST_DATA_STREAM: Final = "REQUEST_DATA_STREAM"
TIMESYNC: Final = "TIMESYNC"
PARAM_REQUEST_READ: Final = "PARAM_REQUEST_READ"
PARAM_SET: Final = "PARAM_SET"
UNDERSTOOD: Final = (COMMAND_LONG, REQUEST_DATA_STREAM, TIMESYNC, PARAM_REQUEST_READ, PARAM_SET)

Reply = tuple[str, bytes | None]
"""A message's name and payload; None where the payload is the vehicle's to fill."""


class Commands:
    """Turns frames from the link into replies, and changes the streams accordingly."""

    def __init__(
        self, system: int, component: int, personality: Personality, dialect: Dialect, parameters: ParameterTable
    ) -> None:
        self.system = system
        self.component = component
        self.personality = personality
        self.dialect = dialect
        self.parameters = parameters
        self.command = dialect.layout(COMMAND_LONG).pick(
            "param1", "param2", "command", "target_system", "target_component"
        )
        self.stream_request = dialect.layout(REQUEST_DATA_STREAM).pick(
            "req_message_rate", "target_system", "target_component", "req_stream_id", "start_stop"
        )
        self.timesync = dialect.layout(TIMESYNC).pick("tc1", "ts1")
        self.parameter_request = dialect.layout(PARAM_REQUEST_READ).pick(
            "param_index", "target_system", "target_component", "param_id"
        )
        self.parameter_set = dialect.layout(PARAM_SET).pick(
            "param_value", "target_system", "target_component", "param_id"
        )
        self.parameter = dialect.layout("PARAM_VALUE").pick(
            "param_value", "param_count", "param_index", "param_id", "param_type"
        )
        self.ack = dialect.layout("COMMAND_ACK").pick("command", "result", "target_system", "target_component")

    def answer(self, frame: Frame, streams: Streams, now_ns: int, boot_ns: int) -> list[Reply]:
        """The replies to one frame, handled at ``now_ns``; both times are the simulation's."""
        if (frame.system, frame.component) == (self.system, self.component):
            return []
        name = self.dialect.name_of(frame.message_id)
        if name == COMMAND_LONG:
            return self._command(frame, streams, now_ns - boot_ns)
        if name == REQUEST_DATA_STREAM:
            self._request_group(frame, streams, now_ns - boot_ns)
        elif name == TIMESYNC:
            return self._synchronize(frame, boot_ns)
        elif name == PARAM_REQUEST_READ:
            return self._parameter(frame)
        elif name == PARAM_SET:
            return self._set_parameter(frame)
        return []

    def _request_group(self, frame: Frame, streams: Streams, now_ns: int) -> None:
        rate_hz, system, component, group, start = self.stream_request.unpack(frame.payload)
        if self._is_ours(system, component) and self.personality.takes_groups:
            streams.set_group_rate(group, rate_hz if start else 0, now_ns)

    def _synchronize(self, frame: Frame, boot_ns: int) -> list[Reply]:
        tc1, ts1 = self.timesync.unpack(frame.payload)
        return [(TIMESYNC, self.timesync.pack(int(frame.rx_ns) - boot_ns, ts1))] if tc1 == 0 else []

    def _parameter(self, frame: Frame) -> list[Reply]:
        """One parameter, by its index or, where that is negative, by its name."""
        number, system, component, name = self.parameter_request.unpack(frame.payload)
        if not self._is_ours(system, component):
            return []
        number = number if number >= 0 else self._number_of(name)
        return self._told(number, number)

    def _set_parameter(self, frame: Frame) -> list[Reply]:
        """One parameter by its name. One that does not exist, or a value that is no number, changes nothing."""
        value, system, component, name = self.parameter_set.unpack(frame.payload)
        number = self._number_of(name)
        if not self._is_ours(system, component) or number < 0 or not isfinite(value):
            return []
        self.parameters.set(number, value)
        return self._told(number, UINT16_MAX)

    def _number_of(self, name: bytes) -> int:
        return self.parameters.index_of(name.split(b"\0", 1)[0].decode("ascii", "replace"))

    def _told(self, number: int, index: int) -> list[Reply]:
        """PARAM_VALUE of one parameter with this index, nothing where there is none of this number."""
        known = self.parameters.parameters
        if not 0 <= number < len(known):
            return []
        one = known[number]
        return [
            (
                "PARAM_VALUE",
                self.parameter.pack(self.parameters.told(number), len(known), index, one.name.encode(), one.kind),
            )
        ]

    def _is_ours(self, system: int, component: int) -> bool:
        return system in {0, self.system} and component in {0, self.component}

    def _command(self, frame: Frame, streams: Streams, now_ns: int) -> list[Reply]:
        param1, param2, command, system, component = self.command.unpack(frame.payload)
        if not self._is_ours(system, component):
            return []
        name = self.dialect.name_of(int(param1)) if isfinite(param1) and param1 >= 0.0 else ""
        reply: list[Reply] = []
        if command == MAV_CMD_SET_MESSAGE_INTERVAL:
            result = self._set_interval(name, param2, streams, now_ns)
        elif command == MAV_CMD_REQUEST_MESSAGE:
            known = streams.has(name)
            result = MAV_RESULT_ACCEPTED if known else self.personality.unknown_message
            reply = [(name, None)] if known else []
        else:
            result = MAV_RESULT_UNSUPPORTED
        ack = self.ack.pack(command, result, int(frame.system), int(frame.component))
        return [("COMMAND_ACK", ack), *reply]

    def _set_interval(self, name: str, interval_us: float, streams: Streams, now_ns: int) -> int:
        if not streams.has(name):
            return self.personality.unknown_stream
        if not isfinite(interval_us):
            return MAV_RESULT_DENIED
        return MAV_RESULT_ACCEPTED if streams.set_interval_us(name, int(interval_us), now_ns) else MAV_RESULT_FAILED

"""Answers to commands of other components: our outputs can be requested and retimed; other commands are refused."""

from math import isfinite
from typing import Final

from attest_mav.mavlink.component.outputs import Publication
from attest_mav.mavlink.component.ports import Port
from attest_mav.mavlink.constants import (
    MAV_CMD_REQUEST_MESSAGE,
    MAV_CMD_SET_MESSAGE_INTERVAL,
    MAV_RESULT_ACCEPTED,
    MAV_RESULT_DENIED,
    MAV_RESULT_TEMPORARILY_REJECTED,
    MAV_RESULT_UNSUPPORTED,
    MAVLINK_MSG_ID_HEARTBEAT,
)
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.framer import Frame

NO_MESSAGE: Final = -1


class Command:
    """A COMMAND_LONG or COMMAND_INT: its sender, its target, and the two parameters that are used."""

    def __init__(
        self, system: int, component: int, target_system: int, target_component: int, number: int, p1: float, p2: float
    ) -> None:
        self.system: Final = system
        self.component: Final = component
        self.target_system: Final = target_system
        self.target_component: Final = target_component
        self.number: Final = number
        self.param1: Final = p1
        self.param2: Final = p2


class CommandReader:
    """Reads commands from frames."""

    def __init__(self, dialect: Dialect) -> None:
        names = ("param1", "param2", "command", "target_system", "target_component")
        self._long: Final = dialect.layout("COMMAND_LONG").pick(*names)
        self._int: Final = dialect.layout("COMMAND_INT").pick(*names)
        self._long_id: Final = dialect.id_of("COMMAND_LONG")

    def read(self, frame: Frame) -> Command:
        """The command in a COMMAND_LONG or COMMAND_INT frame."""
        fields = self._long if frame.message_id == self._long_id else self._int
        param1, param2, number, target_system, target_component = fields.unpack(frame.payload)
        return Command(frame.system, frame.component, target_system, target_component, number, param1, param2)


def answer(command: Command, port: Port, publication: Publication | None, state: int) -> None:
    """Carry out a command that is addressed to us and acknowledge it on the link it came from.

    An unknown command is refused only when it is addressed to this component alone: the sender of a command to all
    components would take our refusal for the autopilot's.
    """
    if command.number == MAV_CMD_REQUEST_MESSAGE:
        result = _request_message(command.param1, port, publication, state)
    elif command.number == MAV_CMD_SET_MESSAGE_INTERVAL:
        result = _set_interval(command.param1, command.param2, port)
    else:
        result = MAV_RESULT_UNSUPPORTED
    if result == MAV_RESULT_UNSUPPORTED and command.target_component == 0:
        return
    port.put(port.encoder.command_ack(command.number, result, command.system, command.component))


def _request_message(message: float, port: Port, publication: Publication | None, state: int) -> int:
    """Send one message now."""
    message_id = _message_id(message)
    if message_id == MAVLINK_MSG_ID_HEARTBEAT:
        port.heartbeat(state)
        return MAV_RESULT_ACCEPTED
    if port.schedule_of(message_id) is None:
        return MAV_RESULT_UNSUPPORTED
    if publication is None or not port.put_output(message_id, publication):
        return MAV_RESULT_TEMPORARILY_REJECTED
    return MAV_RESULT_ACCEPTED


def _set_interval(message: float, interval_us: float, port: Port) -> int:
    """Set the interval of an output on this link, us: -1 stops it, 0 is the default."""
    schedule = port.schedule_of(_message_id(message))
    if schedule is None:
        return MAV_RESULT_UNSUPPORTED
    if not isfinite(interval_us) or abs(interval_us) > 1e9:
        return MAV_RESULT_DENIED
    if interval_us < 0.0:
        schedule.period_ns = -1
    elif interval_us == 0.0:
        schedule.period_ns = schedule.default_ns
    else:
        schedule.period_ns = int(1000.0 * interval_us)
    return MAV_RESULT_ACCEPTED


def _message_id(parameter: float) -> int:
    """The message id that a command carries as a float; NO_MESSAGE for a number that is none."""
    return int(parameter) if parameter.is_integer() else NO_MESSAGE

"""Answers to commands of other components: our outputs can be requested and retimed; other commands are refused.

At most ``COMMANDS_PER_S`` commands are answered in a second on a link; more are dropped without an answer, since each
answer may be larger than its command.
"""

from math import isfinite
from typing import Final

from attest_mav.mavlink.component.line_limit import LineLimit
from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.component.outputs import Publication
from attest_mav.mavlink.component.ports import Port
from attest_mav.mavlink.component.schedule import LONGEST_NS, SHORTEST_NS, STOPPED, Station
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
COMMANDS_PER_S: Final = 20
"""Commands answered in a second on a link: a ground station sends a dozen when it connects."""
SECOND_NS: Final = 1_000_000_000


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


class CommandDesk:
    """Answers the commands that arrive on one link. ``port``: its sending side."""

    def __init__(self, port: Port, notebook: Notebook) -> None:
        self.dropped = 0
        """Commands left without an answer so far, because there were too many."""
        self._port: Final = port
        self._notebook: Final = notebook
        self._lines: Final = LineLimit()
        self._second_ns = 0
        self._answered = 0

    def answer(self, command: Command, publication: Publication | None, state: int, now_ns: int) -> None:
        """Carry out a command that is addressed to us and acknowledge it.

        An unknown command is refused only when it is addressed to this component alone: the sender of a command to all
        components would take our refusal for the autopilot's.
        """
        station = Station(command.system, command.component)
        if not self._may_answer(station, now_ns):
            return
        if command.number == MAV_CMD_REQUEST_MESSAGE:
            result = _request_message(command.param1, self._port, publication, state)
        elif command.number == MAV_CMD_SET_MESSAGE_INTERVAL:
            result = _set_interval(command, self._port, station, now_ns)
        else:
            result = MAV_RESULT_UNSUPPORTED
        if result == MAV_RESULT_UNSUPPORTED and command.target_component == 0:
            return
        port = self._port
        port.put(port.encoder.command_ack(command.number, result, command.system, command.component))

    def _may_answer(self, station: Station, now_ns: int) -> bool:
        """Whether one more command is answered in this second."""
        if not 0 <= now_ns - self._second_ns < SECOND_NS:
            self._second_ns, self._answered = now_ns, 0
        self._answered += 1
        if self._answered <= COMMANDS_PER_S:
            return True
        self.dropped += 1
        suffix = self._lines.suffix("flood", now_ns)
        if suffix is not None:
            self._notebook.warning(
                f"{self._port.name}: more than {COMMANDS_PER_S} commands a second, the last from {station.name}; "
                f"the others are not answered{suffix}"
            )
        return False


def _request_message(message: float, port: Port, publication: Publication | None, state: int) -> int:
    """Send one message now."""
    message_id = _message_id(message)
    if message_id == MAVLINK_MSG_ID_HEARTBEAT:
        port.heartbeat(state)
        return MAV_RESULT_ACCEPTED
    if not port.has_output(message_id):
        return MAV_RESULT_UNSUPPORTED
    if publication is None or not port.put_output(message_id, publication):
        return MAV_RESULT_TEMPORARILY_REJECTED
    return MAV_RESULT_ACCEPTED


def _set_interval(command: Command, port: Port, station: Station, now_ns: int) -> int:
    """Set the interval of an output on this link, us: -1 stops it, 0 is the default."""
    message_id, interval_us = _message_id(command.param1), command.param2
    if not port.has_output(message_id):
        return MAV_RESULT_UNSUPPORTED
    if not isfinite(interval_us) or 1000.0 * interval_us > LONGEST_NS:
        return MAV_RESULT_DENIED
    if interval_us < 0.0:
        period_ns: int | None = STOPPED
    elif interval_us == 0.0:
        period_ns = None
    else:
        period_ns = max(int(1000.0 * interval_us), SHORTEST_NS)
    port.set_interval(message_id, period_ns, station, now_ns)
    return MAV_RESULT_ACCEPTED


def _message_id(parameter: float) -> int:
    """The message id that a command carries as a float; NO_MESSAGE for a number that is none."""
    return int(parameter) if parameter.is_integer() else NO_MESSAGE

"""Answers to commands that others send us: what we send can be asked for and have its rate set, nothing else."""

from math import isfinite
from typing import Final

from attest_mav.mavlink.component.ports import ATTITUDE_QUATERNION, ATTITUDE_QUATERNION_COV, Port, Schedule
from attest_mav.mavlink.constants import (
    MAV_CMD_REQUEST_MESSAGE,
    MAV_CMD_SET_MESSAGE_INTERVAL,
    MAV_RESULT_ACCEPTED,
    MAV_RESULT_DENIED,
    MAV_RESULT_TEMPORARILY_REJECTED,
    MAV_RESULT_UNSUPPORTED,
)
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.framer import Frame
from attest_mav.types import Estimate

HEARTBEAT: Final = 0


class Command:
    """A COMMAND_LONG or COMMAND_INT: who sent it to whom, and the two parameters that we understand."""

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
    """Takes commands out of frames."""

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


def answer(command: Command, port: Port, estimate: Estimate | None, state: int) -> None:
    """Carry out a command that is addressed to us and acknowledge it on the link it came from.

    One that we do not know is refused only when it is meant for us alone: a command to all components is not for us
    to refuse, since whoever sent it would take our answer for the autopilot's.
    """
    if command.number == MAV_CMD_REQUEST_MESSAGE:
        result = _request_message(command.param1, port, estimate, state)
    elif command.number == MAV_CMD_SET_MESSAGE_INTERVAL:
        result = _set_interval(command.param1, command.param2, port)
    else:
        result = MAV_RESULT_UNSUPPORTED
    if result == MAV_RESULT_UNSUPPORTED and command.target_component == 0:
        return
    port.put(port.encoder.command_ack(command.number, result, command.system, command.component))


def _request_message(message: float, port: Port, estimate: Estimate | None, state: int) -> int:
    """Send one message now."""
    if message == HEARTBEAT:
        port.heartbeat(state)
        return MAV_RESULT_ACCEPTED
    if message not in {ATTITUDE_QUATERNION, ATTITUDE_QUATERNION_COV}:
        return MAV_RESULT_UNSUPPORTED
    if estimate is None:
        return MAV_RESULT_TEMPORARILY_REJECTED
    if message == ATTITUDE_QUATERNION:
        port.put_attitude(estimate)
    else:
        port.put_covariance(estimate)
    return MAV_RESULT_ACCEPTED


def _set_interval(message: float, interval_us: float, port: Port) -> int:
    """Set the rate of what this link carries: -1 stops it, 0 is the default, else the interval in microseconds."""
    schedule: Schedule | None = None
    if message == ATTITUDE_QUATERNION:
        schedule = port.attitude
    elif message == ATTITUDE_QUATERNION_COV:
        schedule = port.covariance
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

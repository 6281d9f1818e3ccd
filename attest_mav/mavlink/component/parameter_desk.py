"""Answers to the parameter protocol on the links that allow it: our list, one of our parameters, and a new value.

A list goes out at a pace. Other answers are limited in number; requests beyond it are dropped. PARAM_SET is answered
with the value in force, whether it was taken or not.
"""

from collections.abc import Callable
from typing import Final

from attest_mav.mavlink.component.own_parameters import OwnParameters
from attest_mav.mavlink.component.ports import Port
from attest_mav.mavlink.component.schedule import Station
from attest_mav.mavlink.component.timesync import AnswerLimit
from attest_mav.mavlink.constants import MAV_PARAM_TYPE_REAL32
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import Frame

SPACING_NS: Final = 50_000_000
"""Time between two values of a list."""


class _Counter:
    """The state of one link: the answers of this second, and the list that is being sent."""

    def __init__(self) -> None:
        self.limit: Final = AnswerLimit()
        self.next_index = -1
        """Index of the next value of the list, -1 while none is being sent."""
        self.due_ns = 0
        """When it is due."""


class ParameterDesk:
    """The parameter protocol of our component on all links. ``ports``: their sending sides."""

    def __init__(self, dialect: Dialect, ports: list[Port], parameters: OwnParameters) -> None:
        self._ports: Final = ports
        self._parameters: Final = parameters
        self._counters: Final = [_Counter() for _ in ports]
        self._list: Final = dialect.layout("PARAM_REQUEST_LIST").pick("target_system", "target_component")
        self._read: Final = dialect.layout("PARAM_REQUEST_READ").pick(
            "param_index", "target_system", "target_component", "param_id"
        )
        self._set: Final = dialect.layout("PARAM_SET").pick(
            "param_value", "target_system", "target_component", "param_id", "param_type"
        )
        is_open = bool(parameters.table) and any(port.settings.parameters for port in ports)
        handlers: dict[int, Callable[[int, Frame, int], bool]] = {
            dialect.id_of("PARAM_REQUEST_LIST"): self._hear_list,
            dialect.id_of("PARAM_REQUEST_READ"): self._hear_read,
            dialect.id_of("PARAM_SET"): self._hear_set,
        }
        self.handlers: Final = handlers if is_open else {}
        """By message id; empty where no link allows parameters."""

    @property
    def next_deadline_ns(self) -> int | None:
        """When ``poll`` is due, None for never."""
        return min([one.due_ns for one in self._counters if one.next_index >= 0], default=None)

    def poll(self, now_ns: int) -> None:
        """Send the values of lists that are due."""
        for link, counter in enumerate(self._counters):
            if counter.next_index >= 0 and now_ns >= counter.due_ns:
                self._send(link, counter.next_index)
                counter.due_ns = now_ns + SPACING_NS
                counter.next_index += 1
                if counter.next_index == len(self._parameters.table):
                    counter.next_index = -1

    def _hear_list(self, link: int, frame: Frame, now_ns: int) -> bool:
        """Ground stations ask all components at once. A list that is being sent goes on."""
        port, counter = self._ports[link], self._counters[link]
        system, component = self._list.unpack(frame.payload)
        is_ours = system in (0, port.encoder.system) and component in (0, port.encoder.component)
        if is_ours and port.settings.parameters and counter.next_index < 0:
            counter.next_index, counter.due_ns = 0, max(now_ns, counter.due_ns)
        return False

    def _hear_read(self, link: int, frame: Frame, now_ns: int) -> bool:
        index, system, component, name = self._read.unpack(frame.payload)
        if self._may_answer(link, system, component, now_ns):
            self._send(link, self._parameters.find(_text(name)) if index < 0 else index)
        return False

    def _hear_set(self, link: int, frame: Frame, now_ns: int) -> bool:
        value, system, component, name, kind = self._set.unpack(frame.payload)
        index = self._parameters.find(_text(name))
        if index < 0 or not self._may_answer(link, system, component, now_ns):
            return False
        port, station = self._ports[link], Station(frame.system, frame.component)
        reason = ""
        if port.encoder.signer is not None and not frame.signed:
            reason = "the command is not signed"
        elif kind != MAV_PARAM_TYPE_REAL32:
            reason = f"its type is {kind}, and REAL32 was expected"
        if reason:
            self._parameters.refuse(index, reason, station, port.name, now_ns)
        else:
            self._parameters.set(index, value, station, port.name, now_ns)
        self._send(link, index)
        return False

    def _may_answer(self, link: int, system: int, component: int, now_ns: int) -> bool:
        """Whether a command for these ids is for us alone, the link allows it, and there were not too many."""
        port = self._ports[link]
        is_ours = system == port.encoder.system and component == port.encoder.component
        return is_ours and port.settings.parameters and self._counters[link].limit.allows(now_ns)

    def _send(self, link: int, index: int) -> None:
        """PARAM_VALUE of the parameter with this index; nothing where there is none."""
        table = self._parameters.table
        if 0 <= index < len(table):
            name, port = table[index].name, self._ports[link]
            port.put(port.encoder.param_value(name, self._parameters.value(name), len(table), index))


def _text(name: bytes) -> str:
    """A name of PARAM_SET: up to the first zero, which one of 16 characters has not."""
    return name.split(b"\0", 1)[0].decode("ascii", "replace")

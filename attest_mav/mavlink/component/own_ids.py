"""Frames that carry our own system and component id: echoes of ours, or another component with the same ids."""

from typing import Final

from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.component.ports import Port
from attest_mav.mavlink.constants import MAVLINK_MSG_ID_HEARTBEAT
from attest_mav.mavlink.wire.frame import Frame

REMEMBERED_NS: Final = 10_000_000_000
"""A clash or an echo is told in the status for so long."""
CLASH_PAUSE_NS: Final = 60_000_000_000
"""Pause between two notes of a clash."""


class OwnIds:
    """Tells echoes from clashes by the sequence numbers of the heartbeats that the ports have sent."""

    def __init__(self, ports: list[Port], notebook: Notebook, now_ns: int) -> None:
        self.clashes = 0
        """Heartbeats with our ids that are none of ours."""
        self._ports: Final = ports
        self._notebook: Final = notebook
        self._noted_ns = now_ns - CLASH_PAUSE_NS
        self._echo_ns = [now_ns - REMEMBERED_NS] * len(ports)
        self._clash = ""
        self._clash_ns = now_ns - REMEMBERED_NS
        self._is_echo_noted = False

    def remarks(self, now_ns: int) -> list[str]:
        """Clashes and echoes of the last seconds, for the status."""
        remarks = [self._clash] if now_ns - self._clash_ns < REMEMBERED_NS else []
        for port, echo_ns in zip(self._ports, self._echo_ns, strict=True):
            if now_ns - echo_ns < REMEMBERED_NS:
                remarks.append(_echo_text(port))
        return remarks

    def heard(self, link: int, frame: Frame, now_ns: int) -> None:
        """Take a frame with our ids; a clash leaves a note, at most once a minute, and an echo the first time."""
        if frame.message_id != MAVLINK_MSG_ID_HEARTBEAT:
            return
        if any(port.sent_heartbeat(frame.sequence) for port in self._ports):
            self._echo_ns[link] = now_ns
            if not self._is_echo_noted:
                self._is_echo_noted = True
                self._notebook.info(_echo_text(self._ports[link]))
            return
        self.clashes += 1
        self._clash_ns = now_ns
        self._clash = f"another component speaks as {frame.system}/{frame.component}, which is us"
        if now_ns - self._noted_ns >= CLASH_PAUSE_NS:
            self._noted_ns = now_ns
            self._notebook.warning(f"{self._clash}: give one of the two another component_id")


def _echo_text(port: Port) -> str:
    return f"{port.name} brings our own frames back: a router sends them to where they came from"

"""Frames that carry our own system and component id: echoes of ours, or another component with the same ids."""

from typing import Final

from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.component.ports import Port
from attest_mav.mavlink.constants import MAVLINK_MSG_ID_HEARTBEAT
from attest_mav.mavlink.wire.frame import Frame

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

    def heard(self, frame: Frame, now_ns: int) -> None:
        """Take a frame with our ids; a clash leaves a note, at most once a minute."""
        if frame.message_id != MAVLINK_MSG_ID_HEARTBEAT:
            return
        if any(port.sent_heartbeat(frame.sequence) for port in self._ports):
            return
        self.clashes += 1
        if now_ns - self._noted_ns >= CLASH_PAUSE_NS:
            self._noted_ns = now_ns
            self._notebook.warning(
                f"another component speaks as {frame.system}/{frame.component}, which is us: "
                "give one of the two another component_id"
            )

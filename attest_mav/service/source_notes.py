"""Remarks on the vehicle's messages for the log: each trim once, when it is new; a reason once a minute at most.

A reason may hold a number that changes with each message.
"""

from typing import Final

from attest_mav.mavlink.component.line_limit import LineLimit
from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.component.stream import Stream
from attest_mav.mavlink.decode.decoder import Decoder, of_message


class SourceNotes:
    """Remembers what the log has been told."""

    def __init__(self, notebook: Notebook) -> None:
        self._notebook: Final = notebook
        self._reasons: Final[dict[str, str]] = {}
        self._frames: list[str] = []
        self._lines: Final = LineLimit()

    def frames(self, notes: list[str]) -> None:
        """Note each trim that is newly taken off an attitude, and each message that newly cannot be compared."""
        for text in notes:
            if text not in self._frames:
                self._notebook.info(text)
        self._frames = notes

    def refusals(self, decoder: Decoder, stream: Stream | None, now_ns: int) -> None:
        """Note why the inertial message gives no samples, or none with a magnetometer. stream: the one in use."""
        if stream is None:
            return
        for source, reason in decoder.refusals.items():
            if source not in of_message(stream.name) or self._reasons.get(source) == reason:
                continue
            if self._lines.suffix(source, now_ns) is not None:
                self._reasons[source] = reason
                self._notebook.warning(reason)

"""The bounded output buffer of byte streams: serial ports and TCP connections."""

from collections.abc import Callable

from attest_mav.runtime.links.base import BUFFER_BYTES


class OutBuffer:
    """Whole messages waiting for a stream that takes them only in part."""

    def __init__(self) -> None:
        self.data = bytearray()

    def push(self, message: bytes) -> bool:
        """Keep the message; False, and nothing kept, when it does not fit."""
        if len(self.data) + len(message) > BUFFER_BYTES:
            return False
        self.data += message
        return True

    def drain(self, write: Callable[[bytearray], int]) -> int:
        """Write as much as the stream takes; returns how much that was. OSError means that the stream is lost."""
        sent = 0
        while self.data:
            try:
                count = write(self.data)
            except BlockingIOError:
                break
            if count == 0:
                break
            del self.data[:count]
            sent += count
        return sent

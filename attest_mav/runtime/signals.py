"""SIGINT, SIGTERM and SIGHUP as something a selector can wait for."""

import signal
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

STOP: Final = (signal.SIGINT, signal.SIGTERM)
"""The signals that end a program."""


@contextmanager
def stop_signals(*others: signal.Signals) -> Iterator[socket.socket]:
    """A socket that brings a byte with the number of each SIGINT, SIGTERM or other signal that arrives.

    The former handlers come back at the end. Main thread only, as Python's signals demand.
    """
    reader, writer = socket.socketpair()
    reader.setblocking(False)
    writer.setblocking(False)
    former_fd = signal.set_wakeup_fd(writer.fileno(), warn_on_full_buffer=False)
    former = {number: signal.signal(number, _ignored) for number in (*STOP, *others)}
    try:
        yield reader
    finally:
        for number, handler in former.items():
            signal.signal(number, handler)
        signal.set_wakeup_fd(former_fd)
        reader.close()
        writer.close()


def _ignored(_number: int, _frame: object) -> None:
    """The wake-up descriptor tells the loop; nothing is to be done here."""

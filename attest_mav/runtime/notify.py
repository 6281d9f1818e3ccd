"""sd_notify(3): reports to systemd that the daemon is ready, alive or stopping, with one line of status."""

import logging
import os
import socket
from collections.abc import Mapping

log = logging.getLogger("attest_mav.notify")


class Notifier:
    """Sends to the socket named in NOTIFY_SOCKET; does nothing where there is none.

    watchdog_ns: period of WATCHDOG=1, ns, half of systemd's limit; None where systemd sets no limit.
    """

    def __init__(self, environment: Mapping[str, str]) -> None:
        self._address = environment.get("NOTIFY_SOCKET", "")
        if self._address.startswith("@"):  # an abstract name
            self._address = "\0" + self._address[1:]
        self._socket: socket.socket | None = None
        if self._address:
            self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC)
            self._socket.setblocking(False)
        self.watchdog_ns = _watchdog_ns(environment)

    def ready(self) -> None:
        """READY=1: the links are open and the loop runs, at the start or with a configuration read again."""
        self._send("READY=1")

    def alive(self) -> None:
        """WATCHDOG=1: the loop runs, and the samples that come are filtered."""
        self._send("WATCHDOG=1")

    def status(self, text: str) -> None:
        """One line for ``systemctl status``."""
        self._send("STATUS=" + text.replace("\n", " "))

    def reloading(self, now_ns: int) -> None:
        """RELOADING=1: the configuration is read again since ``now_ns`` of the monotonic clock."""
        self._send(f"RELOADING=1\nMONOTONIC_USEC={now_ns // 1000}")

    def stopping(self) -> None:
        """STOPPING=1: the daemon is about to end."""
        self._send("STOPPING=1")

    def close(self) -> None:
        """Close the socket; nothing is sent afterwards."""
        if self._socket is not None:
            self._socket.close()
        self._socket = None

    def _send(self, text: str) -> None:
        if self._socket is None:
            return
        try:
            self._socket.sendto(text.encode(), self._address)
        except OSError as error:  # systemd is busy or restarting: the next message will do
            log.debug("cannot notify systemd: %s", error)


def _watchdog_ns(environment: Mapping[str, str]) -> int | None:
    """Half of WATCHDOG_USEC, if that is meant for this process."""
    period = environment.get("WATCHDOG_USEC", "")
    meant_for = environment.get("WATCHDOG_PID", str(os.getpid()))
    if not period.isdecimal() or int(period) == 0 or meant_for != str(os.getpid()):
        return None
    return int(period) * 1000 // 2

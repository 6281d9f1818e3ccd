"""Serial ports: opened exclusively, waited for, and opened again for ever when they go away."""

import errno
import fcntl
import os
import termios

import serial

from attest_mav.config.link_url import LinkUrl
from attest_mav.errors import LinkError
from attest_mav.runtime.links.base import Backoff, Link, log
from attest_mav.runtime.links.out_buffer import OutBuffer

SERIAL_READ_BYTES = 4096
"""Largest read, bytes: the kernel buffers no more of a terminal."""


class SerialLink(Link):
    """One serial device with one owner: us."""

    def __init__(self, url: LinkUrl, now_ns: int, *, wait: bool) -> None:
        super().__init__(str(url))
        self.device = url.device
        self.baud = url.baud
        self.port: serial.Serial | None = None
        self.backoff = Backoff()
        self.deadline_ns: int | None = None
        self.out = OutBuffer()
        try:
            self._open()
        except OSError as error:
            if not wait or error.errno not in {errno.ENOENT, errno.ENXIO, errno.ENODEV}:
                raise LinkError(f"cannot open {self.device}: {_advice(error)}") from None
            self._retry(_advice(error), now_ns)

    @property
    def fd(self) -> int | None:
        """See ``Link``."""
        return None if self.port is None else self.port.fileno()

    @property
    def wants_write(self) -> bool:
        """See ``Link``."""
        return self.port is not None and bool(self.out.data)

    @property
    def next_deadline_ns(self) -> int | None:
        """See ``Link``."""
        return self.deadline_ns

    def receive(self, now_ns: int) -> bytes:
        """See ``Link``."""
        if self.deadline_ns is not None and now_ns >= self.deadline_ns:
            self._reopen(now_ns)
        if self.port is None:
            return b""
        try:
            data = os.read(self.port.fileno(), SERIAL_READ_BYTES)
        except BlockingIOError:
            return b""
        except OSError as error:
            self._lost(error.strerror or str(error), now_ns)
            return b""
        if not data:  # a terminal that has hung up reads as ended
            self._lost("unplugged", now_ns)
        self.received_bytes += len(data)
        return data

    def send(self, message: bytes, now_ns: int) -> None:
        """See ``Link``."""
        if self.port is None or not self.out.push(message):
            self.dropped_messages += 1
            return
        self.flush(now_ns)

    def flush(self, now_ns: int) -> None:
        """See ``Link``."""
        if self.port is None:
            return
        fd = self.port.fileno()
        try:
            self.sent_bytes += self.out.drain(lambda data: os.write(fd, data))
        except OSError as error:
            self._lost(error.strerror or str(error), now_ns)

    def close(self) -> None:
        """See ``Link``."""
        if self.port is not None:
            try:
                # The lock of a pseudo-terminal would outlast us, as its other end is still open.
                fcntl.ioctl(self.port.fileno(), termios.TIOCNXCL)
                self.port.close()
            except (OSError, termios.error):  # it is gone already
                log.debug("%s: closing failed", self.url)
        self.port = None

    def _open(self) -> None:
        """Open with pyserial, which knows every baud rate; OSError carries the errno.

        pyserial's lock holds off programs that ask for one, TIOCEXCL the rest (but not the superuser).
        """
        try:
            port = serial.Serial(self.device, self.baud, timeout=0, write_timeout=0, exclusive=True)
        except serial.SerialException as error:
            if isinstance(error.__context__, termios.error):  # pyserial leaves out the errno of this one alone
                raise OSError(*error.__context__.args) from None
            raise
        try:
            fcntl.ioctl(port.fileno(), termios.TIOCEXCL)
            _tell_silence_from_end(port.fileno())
            os.set_blocking(port.fileno(), False)
        except (OSError, termios.error) as error:
            port.close()
            raise OSError(*error.args) from None
        self.port = port
        self.deadline_ns = None
        self.epoch += 1
        self.out = OutBuffer()
        self.backoff.reset()
        log.info("opened %s", self.url)

    def _reopen(self, now_ns: int) -> None:
        try:
            self._open()
        except OSError as error:
            self._retry(_advice(error), now_ns)

    def _lost(self, reason: str, now_ns: int) -> None:
        self.close()
        self._retry(reason, now_ns)

    def _retry(self, reason: str, now_ns: int) -> None:
        self.deadline_ns = self.backoff.next(self.url, reason, now_ns)


def _tell_silence_from_end(fd: int) -> None:
    """Let an empty read mean that the device is gone: pyserial's setting (VMIN 0) makes silence look the same."""
    attributes = termios.tcgetattr(fd)
    attributes[6][termios.VMIN] = 1
    attributes[6][termios.VTIME] = 0
    termios.tcsetattr(fd, termios.TCSANOW, attributes)


def _advice(error: OSError) -> str:
    """The reason why a device cannot be opened, and the remedy."""
    advice = {
        errno.ENOENT: "it does not exist; plug it in, or look for its name in /dev/serial/by-id",
        errno.EACCES: "permission denied; add the user to the group of the device (usually dialout)",
        errno.EPERM: "permission denied; add the user to the group of the device (usually dialout)",
        errno.EBUSY: "another program has it; stop that one (ModemManager, MAVProxy or mavlink-router, for example)",
        errno.EAGAIN: "another program has it; stop that one (ModemManager, MAVProxy or mavlink-router, for example)",
        errno.ENOTTY: "it is not a serial port; look for its name in /dev/serial/by-id",
    }
    return advice.get(error.errno or 0, error.strerror or str(error))

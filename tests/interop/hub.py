"""A router for tests: every datagram goes to all others that have ever sent one."""

import select
import socket
import threading


class Hub:
    """``port`` on this computer; ends with ``close``."""

    def __init__(self):
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self.port = self._socket.getsockname()[1]
        self._stop_read, self._stop_write = socket.socketpair()
        self._thread = threading.Thread(target=self._relay, daemon=True)
        self._thread.start()

    def _relay(self):
        peers = set()
        while True:
            ready, _, _ = select.select([self._socket, self._stop_read], [], [])
            if self._stop_read in ready:
                return
            try:
                data, sender = self._socket.recvfrom(65536)
            except ConnectionRefusedError:  # one that has gone
                continue
            peers.add(sender)
            for peer in peers - {sender}:
                self._socket.sendto(data, peer)

    def close(self):
        self._stop_write.send(b".")
        self._thread.join()
        for one in (self._socket, self._stop_read, self._stop_write):
            one.close()

"""Inside the container of tools/systemd_trial: a serial port that can be unplugged, with a vehicle behind it.

    trial_port.py DEVICE PORT

A pseudo-terminal appears under DEVICE and carries what a TCP server on 127.0.0.1:PORT sends and takes. It is unplugged
by the end of this process.
"""

import os
import select
import socket
import sys
import time
import tty
from pathlib import Path


def connected(port: int) -> socket.socket:
    """The connection to the vehicle, which may need a moment to listen."""
    for _ in range(200):
        try:
            return socket.create_connection(("127.0.0.1", port))
        except OSError:
            time.sleep(0.05)
    sys.exit(f"nobody listens on {port}")


def main() -> None:
    """Carry bytes until one end goes."""
    device, port = Path(sys.argv[1]), int(sys.argv[2])
    vehicle = connected(port)
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    name = os.ttyname(theirs)
    os.chmod(name, 0o666)  # noqa: S103, PTH101  (the group of serial ports, as udev would set it)
    device.unlink(missing_ok=True)
    device.symlink_to(name)
    try:
        while True:
            ready, _, _ = select.select([ours, vehicle], [], [])
            if ours in ready:
                vehicle.sendall(os.read(ours, 4096))
            if vehicle in ready:
                data = vehicle.recv(4096)
                if not data:
                    return
                os.write(ours, data)
    finally:
        device.unlink(missing_ok=True)


if __name__ == "__main__":
    main()

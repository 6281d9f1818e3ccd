"""Inside the container of tools/systemd_trial: what comes on the daemon's UDP link, one line a message, with its time.

    trial_listener.py PORT SECONDS [NAME...]

Ends after SECONDS, or when each NAME has come once; prints NAME and seconds since the start of the machine.
"""

import socket
import sys
import time

from pymavlink.dialects.v20 import ardupilotmega as mavlink


def main() -> None:
    """Greet as a ground station, and listen."""
    port, end_s, wanted = int(sys.argv[1]), time.monotonic() + float(sys.argv[2]), set(sys.argv[3:])
    counts: dict[str, int] = {}
    station = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
    greeting = mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3).pack(station)
    parser = mavlink.MAVLink(None)
    parser.robust_parsing = True
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as link:
        link.connect(("127.0.0.1", port))
        link.settimeout(0.05)
        greeted_s = 0.0
        while time.monotonic() < end_s and not (wanted and wanted <= set(counts)):
            if time.monotonic() - greeted_s > 0.1:
                greeted_s = time.monotonic()
                try:
                    link.send(greeting)
                except OSError:
                    time.sleep(0.02)
                    continue
            try:
                data = link.recv(4096)
            except OSError:
                continue
            for message in parser.parse_buffer(data) or []:
                name = message.get_type()
                if name not in counts:
                    print(f"first {name} {time.monotonic():.3f}")
                counts[name] = counts.get(name, 0) + 1
                if name == "HEARTBEAT" and message.system_status == mavlink.MAV_STATE_POWEROFF:
                    print(f"goodbye {time.monotonic():.3f}")
    for name, count in counts.items():
        print(f"count {name} {count}")


if __name__ == "__main__":
    main()

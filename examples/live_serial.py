"""Attitudes from a sensor board that prints numbers: nine or six a line, on a serial port or in a pipe.

    .venv/bin/python examples/live_serial.py /dev/ttyUSB0 [BAUD]
    some_program | .venv/bin/python examples/live_serial.py -

A line holds gyro (rad/s), accelerometer (m/s^2) and, if there is one, magnetometer (gauss), separated by commas or
blanks; axes forward, left, up. A line that is torn or no numbers is passed over, and counted at the end.
"""

import io
import sys
import time
from collections.abc import Iterable, Iterator
from math import degrees

import serial

from attest_mav import BARE_SENSOR, LiveAttitude, VelocityAided
from attest_mav.algebra import q_to_euler


def lines_of(name: str, baud: int) -> Iterator[str]:
    """The lines of a port, or of standard input."""
    if name == "-":
        yield from sys.stdin
        return
    with serial.Serial(name, baud, timeout=1.0) as port:
        for line in io.BufferedReader(port):
            yield line.decode("ascii", errors="replace")


def numbers_in(line: str) -> list[float] | None:
    """The numbers of a line, None where they are not six or nine."""
    try:
        found = [float(word) for word in line.replace(",", " ").split()]
    except ValueError:
        return None
    return found if len(found) in {6, 9} else None


def follow(lines: Iterable[str]) -> int:
    """Print the attitude twice a second; the number of lines that were passed over."""
    live = LiveAttitude(VelocityAided(BARE_SENSOR), frames="FLU/ENU")
    last, printed, skipped = -1.0, 0.0, 0
    for line in lines:
        found = numbers_in(line)
        now = time.monotonic()
        if found is None or now <= last:
            skipped += 1
            continue
        last = now
        q = live.update(now, found[0:3], found[3:6], found[6:9] or None)
        if q is not None and now - printed >= 0.5:
            printed = now
            roll, pitch, yaw = (degrees(angle) for angle in q_to_euler(q))
            print(f"roll {roll:7.1f} pitch {pitch:7.1f} yaw {yaw:7.1f} +- {degrees(live.tilt_sigma):.1f}", flush=True)
    return skipped


def main(name: str, baud: int) -> None:
    """Follow the sensor until it ends, or until Ctrl-C."""
    try:
        skipped = follow(lines_of(name, baud))
    except serial.SerialException as error:
        sys.exit(f"{name}: {error}")
    except KeyboardInterrupt:
        return
    print(f"{skipped} lines passed over")


if __name__ == "__main__":
    if len(sys.argv) not in {2, 3}:
        sys.exit("usage: live_serial.py PORT|- [BAUD]")
    main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 115200)

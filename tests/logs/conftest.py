"""Logs to read, and an independent account of what is in them."""

from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def copter_start(cuts: Path) -> bytes:
    return (cuts / "copter_square_start.tlog").read_bytes()


@pytest.fixture(scope="session")
def plane_turn(cuts: Path) -> bytes:
    return (cuts / "plane_circles_turn.tlog").read_bytes()


def records(log):
    """(start of the time stamp, start of the frame, end) of every record of an undamaged version 2 tlog."""
    found = []
    start = 0
    while start + 8 < len(log):
        frame = start + 8
        assert log[frame] == 0xFD, "the test wants an undamaged log of version 2 frames without signatures"
        assert log[frame + 2] == 0
        end = frame + 12 + log[frame + 1]
        if end <= len(log):
            found.append((start, frame, end))
        start = end
    return found


@pytest.fixture(scope="session")
def copter_start_records(copter_start):
    return records(copter_start)


@pytest.fixture(scope="session")
def plane_turn_records(plane_turn):
    return records(plane_turn)

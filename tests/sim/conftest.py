"""Helpers: pymavlink is the oracle for everything on the wire."""

from collections.abc import Callable
from typing import Any

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

Messages = dict[str, list[Any]]


@pytest.fixture
def decode() -> Callable[[list[bytes]], Messages]:
    """Frames to pymavlink messages by type; a frame that pymavlink does not accept fails the test."""

    def decoded(frames: list[bytes]) -> Messages:
        parser = mavlink.MAVLink(None)
        messages: Messages = {}
        for frame in frames:
            found = parser.parse_buffer(frame)
            assert found is not None
            assert len(found) == 1, f"{frame.hex()} is not one message"
            messages.setdefault(found[0].get_type(), []).append(found[0])
        return messages

    return decoded


@pytest.fixture
def companion() -> mavlink.MAVLink:
    """Who sends commands: component 193 of the vehicle's system."""
    return mavlink.MAVLink(None, srcSystem=1, srcComponent=193)

"""Fixtures for all tests."""

import os
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parent.parent


@pytest.fixture(scope="session")
def command() -> list[str]:
    """How to start the installed attest-mav as a process: -P keeps a checkout from shadowing an installed wheel."""
    return [sys.executable, "-P", "-m", "attest_mav"]


@pytest.fixture(scope="session")
def data_folder() -> Path:
    """The folder of full flight logs, beside the checkout or named by ATTEST_MAV_DATA; tests skip without it."""
    folder = Path(os.environ.get("ATTEST_MAV_DATA", REPOSITORY.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"full flight logs not found at {folder}; set ATTEST_MAV_DATA")
    return folder


@pytest.fixture(scope="session")
def without() -> Callable[..., bytes]:
    """without(data, ids): a tlog of MAVLink 2 frames less the messages of those ids."""

    def drop(data: bytes, *message_ids: int) -> bytes:
        kept, offset = b"", 0
        while offset < len(data):
            # 8 bytes of time, 10 of header, payload, 2 of checksum.
            length = 8 + 12 + data[offset + 9]
            if int.from_bytes(data[offset + 15 : offset + 18], "little") not in message_ids:
                kept += data[offset : offset + length]
            offset += length
        return kept

    return drop

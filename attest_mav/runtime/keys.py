"""Reads the keys of signing links. A key goes to the signatures and nowhere else: no line and no error shows it."""

import os
import stat
from collections.abc import Iterable
from typing import Final

from attest_mav.config.records import LinkConfig
from attest_mav.errors import ConfigError
from attest_mav.mavlink.signing.signature import KEY_BYTES
from attest_mav.runtime.files import open_without_waiting, reason_of

OTHERS: Final = stat.S_IRWXG | stat.S_IRWXO
"""The permissions that a key file must not have."""
LONGEST: Final = 2 * KEY_BYTES + 2
"""64 hexadecimal digits and the end of their line, bytes."""


def read_keys(links: Iterable[LinkConfig]) -> dict[str, bytes]:
    """The key of every ``key_file`` that a signing link names; ConfigError says why one cannot be used."""
    return {link.key_file: read_key(link.key_file) for link in links if link.signing != "off"}


def read_key(path: str) -> bytes:
    """The 32 bytes of a key file, which nobody but its owner may read; ConfigError."""
    try:
        with open(path, "rb", opener=open_without_waiting) as file:
            status = os.fstat(file.fileno())
            if not stat.S_ISREG(status.st_mode):
                raise ConfigError(f"key_file {path}: not a regular file; expected a key")
            if status.st_mode & OTHERS:
                mode = stat.S_IMODE(status.st_mode)
                raise ConfigError(f"key_file {path}: others may read or change it (mode {mode:04o}): chmod 600 {path}")
            data = file.read(LONGEST + 1)
    except OSError as error:
        raise ConfigError(f"key_file {path}: cannot be read: {reason_of(error)}") from None
    key = _key_in(data)
    if key is None:
        raise ConfigError(f"key_file {path}: expected 32 bytes, or 64 hexadecimal digits and nothing else")
    if not any(key):
        raise ConfigError(f"key_file {path}: all bytes are zero, which is no key; make one: head -c 32 /dev/urandom")
    return key


def _key_in(data: bytes) -> bytes | None:
    """The key that a file's content is, None where it is none."""
    if len(data) == KEY_BYTES:
        return data
    digits = data.strip()
    if len(data) > LONGEST or len(digits) != 2 * KEY_BYTES:
        return None
    try:
        return bytes.fromhex(digits.decode("ascii"))
    except ValueError:
        return None

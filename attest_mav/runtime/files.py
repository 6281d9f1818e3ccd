"""Files: logs mapped into memory to read, results written so that a half-written one is never seen."""

import mmap
import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from attest_mav.errors import ConfigError, UnreadableDataError

MAX_CONFIG_BYTES = 1 << 20
"""A configuration of more than this is something else."""


@contextmanager
def open_log(path: str | Path) -> Iterator[mmap.mmap]:
    """The file's bytes, read-only and not copied; UnreadableDataError says why there are none."""
    try:
        with open(path, "rb", opener=_open_without_waiting) as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise UnreadableDataError(f"{path} is not a regular file; expected a log")
            if os.fstat(file.fileno()).st_size == 0:
                raise UnreadableDataError(f"{path} is empty; expected a log")
            mapped = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
    except OSError as error:
        raise UnreadableDataError(f"cannot read {path}: {_reason(error)}") from None
    with mapped:
        yield mapped


def _open_without_waiting(path: str, flags: int) -> int:
    """Open a file; a named pipe that nobody writes to would otherwise be waited for."""
    return os.open(path, flags | os.O_NONBLOCK)


def read_config(path: str | Path) -> str:
    """The text of a configuration file; ConfigError says why there is none."""
    try:
        with Path(path).open("rb") as file:
            data = file.read(MAX_CONFIG_BYTES + 1)
    except OSError as error:
        raise ConfigError(f"cannot read the configuration {path}: {_reason(error)}") from None
    if len(data) > MAX_CONFIG_BYTES:
        raise ConfigError(f"{path}: larger than {MAX_CONFIG_BYTES} bytes; expected a configuration in TOML")
    try:
        return data.decode()
    except UnicodeDecodeError as error:
        raise ConfigError(f"{path}: not UTF-8 text at byte {error.start}; expected TOML") from None


@contextmanager
def atomic_write(path: str | Path) -> Iterator[IO[bytes]]:
    """A file object whose contents appear under ``path`` when the block ends well, and not at all when it does not.

    The bytes go into a temporary file beside ``path``, which then takes its name. A target that is no regular file
    (a pipe, /dev/stdout) is written directly: there is nothing to replace.
    """
    target = Path(path)
    try:
        if target.exists() and not target.is_file() and not target.is_dir():
            with target.open("wb") as direct:
                yield direct
            return
        with tempfile.NamedTemporaryFile(dir=target.parent, prefix=f".{target.name[:100]}.", delete=False) as file:
            temporary = Path(file.name)
            try:
                yield file
                file.flush()
                os.fchmod(file.fileno(), _mode_of_new_files())
                temporary.replace(target)
            except BaseException:
                temporary.unlink(missing_ok=True)
                raise
    except OSError as error:
        raise UnreadableDataError(f"cannot write {path}: {_reason(error)}") from None


def _mode_of_new_files() -> int:
    """What the user's umask allows; a temporary file is private otherwise. Reading the mask means setting it."""
    mask = os.umask(0o077)
    os.umask(mask)
    return 0o666 & ~mask


def _reason(error: OSError) -> str:
    reasons: dict[type[OSError], str] = {
        FileNotFoundError: "no such file or directory",
        IsADirectoryError: "it is a directory; expected a file",
        PermissionError: "permission denied",
    }
    return reasons.get(type(error), error.strerror or str(error))

"""Files: logs to read in pieces, results written so that a half-written one is never seen."""

import errno
import os
import stat
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from io import BufferedWriter, FileIO
from pathlib import Path
from types import TracebackType
from typing import IO, TYPE_CHECKING, Self

from attest_mav.errors import ConfigError, UnreadableDataError, UnwritableError
from attest_mav.runtime.archives import unpacked

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer

MAX_CONFIG_BYTES = 1 << 20
"""A configuration of more than this is something else."""


DISK_FAULTS = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EIO})
"""Errors of a disk that is full, read-only or broken; other errors of a path are somebody's mistake."""


class OpenedLog:
    """The bytes of an open file, read in pieces. A mapped file that shrinks would end the process by a signal."""

    def __init__(self, descriptor: int, size: int, notes: Sequence[str] = ()) -> None:
        self.notes = tuple(notes)
        """Remarks on the archive that it comes from."""
        self._descriptor = descriptor
        self._size = size

    def __len__(self) -> int:
        return self._size

    def __getitem__(self, span: slice, /) -> bytes:
        """One piece; UnreadableDataError if the file has become shorter."""
        start, stop, _ = span.indices(self._size)
        pieces = []
        while start < stop:
            try:
                piece = os.pread(self._descriptor, stop - start, start)
            except OSError as error:
                raise UnreadableDataError(f"cannot read at byte {start}: {reason_of(error)}") from None
            if not piece:
                raise UnreadableDataError(f"it was cut while it was read: it ends at byte {start} of {self._size}")
            pieces.append(piece)
            start += len(piece)
        return pieces[0] if len(pieces) == 1 else b"".join(pieces)


@contextmanager
def open_log(path: str | Path, folder: str = "") -> Iterator[OpenedLog]:
    """The bytes of a log, or of the one in an archive, read when they are asked for.

    folder: where a relative path begins, for a process that works elsewhere. UnreadableDataError says why there are
    none.
    """
    try:
        file = open(Path(folder, path), "rb", opener=open_without_waiting)  # noqa: SIM115 (closed below)
    except OSError as error:
        raise UnreadableDataError(f"cannot read {path}: {reason_of(error)}") from None
    with file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode):
            raise UnreadableDataError(f"{path} is not a regular file; expected a log")
        if status.st_size == 0:
            raise UnreadableDataError(f"{path} is empty; expected a log")
        with unpacked(file, path) as found:
            size = os.fstat(found.log.fileno()).st_size
            if size == 0:
                raise UnreadableDataError(f"{path} holds an empty file; expected a log")
            yield OpenedLog(found.log.fileno(), size, found.notes)


def open_without_waiting(path: str, flags: int) -> int:
    """Open a file; a named pipe that nobody writes to would otherwise be waited for."""
    return os.open(path, flags | os.O_NONBLOCK)


def read_config(path: str | Path) -> str:
    """The text of a configuration file; ConfigError says why there is none."""
    try:
        with Path(path).open("rb") as file:
            data = file.read(MAX_CONFIG_BYTES + 1)
    except OSError as error:
        raise ConfigError(f"cannot read the configuration {path}: {reason_of(error)}") from None
    if len(data) > MAX_CONFIG_BYTES:
        raise ConfigError(f"{path}: larger than {MAX_CONFIG_BYTES} bytes; expected a configuration in TOML")
    try:
        return data.decode()
    except UnicodeDecodeError as error:
        raise ConfigError(f"{path}: not UTF-8 text at byte {error.start}; expected TOML") from None


def drop_ins(path: str | Path) -> list[Path]:
    """The files ``*.toml`` of the folder of drop-ins beside a configuration, NAME.conf.d, in the order of names."""
    folder = Path(path).with_suffix(".conf.d")
    try:
        return sorted(one for one in folder.iterdir() if one.suffix == ".toml")
    except (FileNotFoundError, NotADirectoryError):
        return []
    except OSError as error:
        raise ConfigError(f"cannot read the folder {folder}: {reason_of(error)}") from None


@contextmanager
def atomic_write(path: str | Path) -> Iterator[IO[bytes]]:
    """A file object whose contents appear under ``path`` when the block ends well, and not at all when it does not.

    The bytes go into a temporary file beside ``path``, which then takes its name. A target that is no regular file
    (a pipe, /dev/stdout) is written directly: there is nothing to replace. UnwritableError when the file itself cannot
    be written; other errors of the block pass through, and so does BrokenPipeError: a reader that left is no failure.
    """
    target = Path(path)
    with _blaming(target):
        descriptor, name = (os.open(target, os.O_WRONLY), "") if _is_special(target) else _temporary_beside(target)
    try:
        with _Blamed(FileIO(descriptor, "wb"), target) as file:
            yield file
        if name:
            with _blaming(target):
                Path(name).replace(target)
    except BaseException:
        if name:
            Path(name).unlink(missing_ok=True)
        raise


def check_writable(path: str | Path) -> None:
    """UnwritableError where ``atomic_write`` could not begin, before the work on what is written; leaves no trace."""
    target = Path(path)
    with _blaming(target):
        if not _is_special(target):
            descriptor, name = _temporary_beside(target)
            os.close(descriptor)
            Path(name).unlink()


def _is_special(target: Path) -> bool:
    """Whether there is something that is neither a file nor a folder: a pipe, a device."""
    return target.exists() and not target.is_file() and not target.is_dir()


def _temporary_beside(target: Path) -> tuple[int, str]:
    """Descriptor and name of a new file in the same folder, with the permissions of any new file."""
    if target.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
    from tempfile import mkstemp  # noqa: PLC0415 - costs 3 ms, which a replay without such a file does not need

    descriptor, name = mkstemp(dir=target.parent, prefix=f".{target.name[:100]}.")
    os.fchmod(descriptor, _mode_of_new_files())
    return descriptor, name


class _Blamed(BufferedWriter):
    """A file for writing whose errors name it. When its block fails, the bytes still buffered are dropped."""

    def __init__(self, raw: FileIO, target: Path) -> None:
        super().__init__(raw)
        self._target = target

    def write(self, data: "ReadableBuffer", /) -> int:
        with _blaming(self._target):
            return super().write(data)

    def flush(self) -> None:
        with _blaming(self._target):
            super().flush()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is not None:
            self.raw.close()
        self.close()


@contextmanager
def _blaming(target: Path) -> Iterator[None]:
    """An OSError of this block becomes one line about the file."""
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        raise UnwritableError(f"cannot write {target}: {reason_of(error)}") from error


def give_up_stdout() -> None:
    """Discard the bytes that standard output still holds: Python would write them at the end, and complain."""
    with suppress(OSError, ValueError, AttributeError):  # closed already, or no real file
        sink = os.open(os.devnull, os.O_WRONLY)
        os.dup2(sink, sys.stdout.fileno())
        os.close(sink)


def _mode_of_new_files() -> int:
    """The permissions that the user's umask allows. The mask can only be read by setting it."""
    mask = os.umask(0o077)
    os.umask(mask)
    return 0o666 & ~mask


def reason_of(error: OSError) -> str:
    """The error in a few words, for people."""
    reasons: dict[type[OSError], str] = {
        FileNotFoundError: "no such file or directory",
        IsADirectoryError: "it is a directory; expected a file",
        PermissionError: "permission denied",
    }
    return reasons.get(type(error), error.strerror or str(error))

"""Results of many logs in a file of JSON lines, one a log, so that work that was ended can go on."""

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

from attest_mav.errors import UnreadableDataError, UnwritableError
from attest_mav.runtime.files import reason_of

KEY: Final = "of"
"""Key of the object that tells which log, and which work on it, a result is of."""


class Results:
    """Results that are kept in a file as they come.

    work: describes the work that is done on each log, so that results of other work do not count.
    """

    def __init__(self, path: str, work: str) -> None:
        self._path: Final = Path(path)
        self._work: Final = work
        self._known: Final[dict[str, dict[str, Any]]] = {}
        self._descriptor = -1

    def known(self, log: str) -> dict[str, Any] | None:
        """The result that is kept for this log as it is now."""
        key = self._key(log)
        return None if key is None else self._known.get(json.dumps(key))

    def add(self, log: str, result: dict[str, Any]) -> None:
        """Keep a result; the line is in the file when this returns. A log that is not there has none to keep."""
        key = self._key(log)
        if key is None:
            return
        line = json.dumps({KEY: key, **result}, allow_nan=False) + "\n"
        try:
            os.write(self._descriptor, line.encode())
        except OSError as error:
            raise UnwritableError(f"cannot write {self._path}: {reason_of(error)}") from None

    @contextmanager
    def open(self) -> Iterator[None]:
        """Read what is there, and keep the file open for more. A last line that was cut is taken off."""
        try:
            self._descriptor = os.open(self._path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o666)
        except OSError as error:
            raise UnwritableError(f"cannot write {self._path}: {reason_of(error)}") from None
        try:
            self._read()
            yield
        finally:
            os.close(self._descriptor)

    def _read(self) -> None:
        data = self._path.read_bytes()
        for result in _parsed(self._path, data):
            self._known[json.dumps(result.pop(KEY))] = result
        os.truncate(self._descriptor, data.rfind(b"\n") + 1)

    def _key(self, log: str) -> dict[str, Any] | None:
        """A log by name, size and time of change, and the work; None for a log that is not there."""
        try:
            status = Path(log).stat()
        except (OSError, ValueError):
            return None
        name = os.fsencode(log).decode(errors="backslashreplace")
        return {"log": name, "bytes": status.st_size, "changed_ns": status.st_mtime_ns, "work": self._work}


def read_results(path: str) -> dict[str, dict[str, Any]]:
    """The last result of each log in a file of results, by the log's name; the log and the work stand under ``KEY``."""
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise UnreadableDataError(f"cannot read {path}: {reason_of(error)}") from None
    return {result[KEY]["log"]: result for result in _parsed(Path(path), data)}


def _parsed(path: Path, data: bytes) -> Iterator[dict[str, Any]]:
    """The results of all whole lines."""
    for number, line in enumerate(data[: data.rfind(b"\n") + 1].splitlines(), 1):
        try:
            result = json.loads(line)
            is_result = {"log", "bytes", "work"} <= result[KEY].keys()
        except (ValueError, AttributeError, KeyError, TypeError):
            is_result = False
        if not is_result:
            raise UnreadableDataError(
                f"{path}, line {number}: no result of a replay; expected a file that --results has written"
            )
        yield result

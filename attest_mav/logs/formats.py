"""The table of readable log formats. A new format is a module with a ``LogSource`` and one row here."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from attest_mav.errors import UnreadableDataError
from attest_mav.logs.dataflash.roles import DATAFLASH_ROLES
from attest_mav.logs.dataflash.source import DataflashSource, TextSource
from attest_mav.logs.detect import HEAD_BYTES, LogFormat, require_format
from attest_mav.logs.source import LogBytes, LogSource, MessageRoles
from attest_mav.logs.tlog.roles import TLOG_ROLES
from attest_mav.logs.tlog.source import open_stream, open_tlog


@dataclass(frozen=True)
class ReadableFormat:
    """One row of the table."""

    words: str
    """The format for people."""
    open_source: Callable[[LogBytes], LogSource]
    """Makes a source of the bytes of a log."""
    roles: MessageRoles
    """The messages of the format."""


READABLE: Final[Mapping[LogFormat, ReadableFormat]] = {
    "tlog": ReadableFormat("a tlog", open_tlog, TLOG_ROLES),
    "mavlink": ReadableFormat("a bare MAVLink stream", open_stream, TLOG_ROLES),
    "dataflash": ReadableFormat("a DataFlash log", DataflashSource, DATAFLASH_ROLES),
    "dataflash-text": ReadableFormat("a DataFlash log in text", TextSource, DATAFLASH_ROLES),
}
NOT_YET_READABLE: Final[Mapping[LogFormat, str]] = {"ulog": "a ULog"}


def open_source(data: LogBytes, name: str) -> LogSource:
    """The source of a log with these bytes; UnreadableDataError names the file ``name`` if no format fits."""
    log_format = require_format(data[:HEAD_BYTES], name)
    readable = READABLE.get(log_format)
    if readable is None:
        expected = " or ".join(known.words for known in READABLE.values())
        raise UnreadableDataError(f"{name}: {NOT_YET_READABLE[log_format]} cannot be read yet; expected {expected}")
    return readable.open_source(data)


def inertial_names() -> tuple[str, ...]:
    """The inertial messages of all readable formats, each once."""
    return tuple(dict.fromkeys(name for row in READABLE.values() for name in row.roles.inertial))


def reference_names() -> tuple[str, ...]:
    """The attitudes of all readable formats that can be named as reference, each once."""
    return tuple(dict.fromkeys(name for row in READABLE.values() for name in row.roles.named_reference))

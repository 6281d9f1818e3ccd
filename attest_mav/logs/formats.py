"""The table of readable log formats. A new format is a module with a ``LogSource`` and one row here.

The readers of a format are loaded with the first log of it: all of them take 20 ms.
"""

from collections.abc import Callable, Mapping
from typing import Final

from attest_mav.logs.dataflash.roles import DATAFLASH_ROLES
from attest_mav.logs.detect import HEAD_BYTES, LogFormat, require_format
from attest_mav.logs.source import LogBytes, LogSource, MessageRoles
from attest_mav.logs.tlog.roles import TLOG_ROLES
from attest_mav.logs.ulog.roles import ULOG_ROLES


class ReadableFormat:
    """One row of the table."""

    def __init__(self, words: str, open_source: Callable[[LogBytes], LogSource], roles: MessageRoles) -> None:
        self.words: Final = words
        """The format for people."""
        self.open_source: Final = open_source
        """Makes a source of the bytes of a log."""
        self.roles: Final = roles
        """The messages of the format."""


def _open_tlog(data: LogBytes) -> LogSource:
    from attest_mav.logs.tlog.source import open_tlog  # noqa: PLC0415

    return open_tlog(data)


def _open_stream(data: LogBytes) -> LogSource:
    from attest_mav.logs.tlog.source import open_stream  # noqa: PLC0415

    return open_stream(data)


def _open_dataflash(data: LogBytes) -> LogSource:
    from attest_mav.logs.dataflash.source import DataflashSource  # noqa: PLC0415

    return DataflashSource(data)


def _open_dataflash_text(data: LogBytes) -> LogSource:
    from attest_mav.logs.dataflash.source import TextSource  # noqa: PLC0415

    return TextSource(data)


def _open_ulog(data: LogBytes) -> LogSource:
    from attest_mav.logs.ulog.source import UlogSource  # noqa: PLC0415

    return UlogSource(data)


READABLE: Final[Mapping[LogFormat, ReadableFormat]] = {
    "tlog": ReadableFormat("a tlog", _open_tlog, TLOG_ROLES),
    "mavlink": ReadableFormat("a bare MAVLink stream", _open_stream, TLOG_ROLES),
    "dataflash": ReadableFormat("a DataFlash log", _open_dataflash, DATAFLASH_ROLES),
    "dataflash-text": ReadableFormat("a DataFlash log in text", _open_dataflash_text, DATAFLASH_ROLES),
    "ulog": ReadableFormat("a ULog", _open_ulog, ULOG_ROLES),
}


def open_source(data: LogBytes, name: str) -> LogSource:
    """The source of a log with these bytes; UnreadableDataError names the file ``name`` if no format fits."""
    return READABLE[require_format(data[:HEAD_BYTES], name)].open_source(data)


def inertial_names() -> tuple[str, ...]:
    """The inertial messages of all readable formats, each once."""
    return tuple(dict.fromkeys(name for row in READABLE.values() for name in row.roles.inertial))


def reference_names() -> tuple[str, ...]:
    """The attitudes of all readable formats that can be named as reference, each once."""
    return tuple(dict.fromkeys(name for row in READABLE.values() for name in row.roles.named_reference))

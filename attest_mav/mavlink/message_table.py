"""The table of a dialect's messages, taken from one of pymavlink's generated modules and kept as Python keeps bytecode.

Loading that module takes 35 ms and 12 MB, nearly all of it for classes and enums that nothing here uses. The table made
of it therefore stays in ``__pycache__`` beside the bytecode of this folder, with the time and the size of pymavlink's
module. Like bytecode it is made anew when these change, and at every start where Python may not write.
"""

import marshal
import sys
from importlib import import_module
from importlib.machinery import SourceFileLoader
from importlib.util import cache_from_source, find_spec
from typing import Any, Final

Row = tuple[int, str, int, list[str], list[str]]
"""Id, name, CRC extra, fields in wire order, and struct's code of each."""

FOLDER: Final = __file__.rpartition("/")[0]


def message_rows(module: str) -> list[Row]:
    """The messages of the module of that name, in its order."""
    spec = find_spec(module)
    if spec is None or not isinstance(spec.loader, SourceFileLoader):
        return rows_of_module(module)
    loader = spec.loader
    stats = loader.path_stats(loader.path)
    stamp = (module, stats["mtime"], stats["size"])
    path = cache_from_source(f"{FOLDER}/messages_of_{module.rpartition('.')[2]}.py")
    try:
        kept_stamp, kept = marshal.loads(loader.get_data(path))  # noqa: S302 - trusted as the bytecode beside it is
    except (OSError, ValueError, EOFError, TypeError):
        kept_stamp, kept = None, []
    if kept_stamp == stamp:
        rows: list[Row] = kept
        return rows
    rows = rows_of_module(module)
    if not sys.dont_write_bytecode:
        loader.set_data(path, marshal.dumps((stamp, rows)))
    return rows


def rows_of_module(module: str) -> list[Row]:
    """The same from the module itself."""
    return [_row(message) for message in import_module(module).mavlink_map.values()]


def _row(message: Any) -> Row:
    """The row of one of pymavlink's message classes."""
    codes = []
    for code, length, text in zip(
        bytes(message.native_format[1:]).decode(), message.lengths, message.array_lengths, strict=True
    ):
        if code == "c":
            codes.append(f"{max(text, 1)}s")
        else:
            codes.append(code if length == 1 else f"{length}{code}")
    return (message.id, message.msgname, message.crc_extra, list(message.ordered_fieldnames), codes)

"""The logs that a user names: files, folders with all logs in them, and patterns."""

from collections.abc import Iterable
from glob import glob, has_magic
from pathlib import Path
from typing import Final

from attest_mav.errors import UnreadableDataError

SUFFIXES: Final = (".tlog", ".bin", ".log", ".ulg")
"""Ends of the names of logs in a folder, in any case; each also with one of ``PACKED`` behind it."""
PACKED: Final = (".gz", ".zip")


def log_paths(named: Iterable[str]) -> list[str]:
    """The path of each log, in the order of the names and by name in a folder or pattern; each path once.

    A name that is no folder and no pattern is a log, whether or not it exists. UnreadableDataError for a folder
    without a log and a pattern without a match.
    """
    return list(dict.fromkeys(path for name in named for path in _paths(name)))


def _paths(name: str) -> list[str]:
    path = Path(name)
    if path.is_dir():
        found = sorted(str(one) for one in path.rglob("*") if is_log_name(one.name) and one.is_file())
        if not found:
            raise UnreadableDataError(f"no log in the folder {name}; expected files named *{', *'.join(SUFFIXES)}")
        return found
    if has_magic(name) and not path.exists():
        found = sorted(one for one in glob(name, recursive=True) if Path(one).is_file())  # noqa: PTH207  # from / too
        if not found:
            raise UnreadableDataError(f"no file matches {name}; expected one log or more")
        return found
    return [name]


def is_log_name(name: str) -> bool:
    """Whether a file of this name is taken for a log where a folder is named."""
    lower = name.lower()
    for packed in PACKED:
        lower = lower.removesuffix(packed)
    return lower.endswith(SUFFIXES) and not name.startswith(".")

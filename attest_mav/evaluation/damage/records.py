"""The records of an undamaged log, by the plain structure of each format and without the readers under test.

Only records with an identity are listed: of a ULog the data, of a DataFlash log all records, of recorded frames those
of known messages. ``description`` names the record that has to be read before this one can be found: the format of its
type (DataFlash), the subscription and the formats behind it (ULog).
"""

import re
from dataclasses import dataclass
from typing import Final

from attest_mav.logs.detect import LogFormat
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import message_id_at, size_at

STAMP_BYTES: Final = 8
FORMAT_TYPE: Final = 128
FORMAT_BYTES: Final = 89
ULOG_HEAD_BYTES: Final = 16


@dataclass(frozen=True)
class Record:
    """One record. ``lengths``: the places of the bytes that tell a length or a type, its own or that of others."""

    begin: int
    end: int
    kind: str
    """Its message, type or topic."""
    descriptions: tuple[tuple[int, int], ...] = ()
    """Begin and end of each record that describes it."""
    lengths: tuple[int, ...] = ()
    is_data: bool = True
    """False for a record without an identity of its own."""
    lead: int = 0
    """Bytes before it without which it is no record: the end of the line before."""


def records_of(log_format: LogFormat, log: bytes, dialect: Dialect) -> list[Record]:
    """The records up to the first byte that belongs to none."""
    if log_format == "dataflash":
        return _dataflash(log)
    if log_format == "dataflash-text":
        return _text(log)
    if log_format == "ulog":
        return _ulog(log)
    return _frames(log, STAMP_BYTES if log_format == "tlog" else 0, dialect)


def _frames(log: bytes, lead: int, dialect: Dialect) -> list[Record]:
    found = []
    at = 0
    while (size := size_at(log, at + lead, len(log))) > 0 and at + lead + size <= len(log):
        message_id = message_id_at(log, at + lead)
        known = message_id in dialect.by_id
        found.append(Record(at, at + lead + size, str(message_id), (), (at + lead + 1,), known))
        at += lead + size
    return found


def _dataflash(log: bytes) -> list[Record]:
    lengths = {FORMAT_TYPE: FORMAT_BYTES}
    names: dict[int, str] = {FORMAT_TYPE: "FMT"}
    places: dict[int, tuple[int, int]] = {}
    found = []
    at = 0
    while log[at : at + 2] == b"\xa3\x95" and at + 2 < len(log) and log[at + 2] in lengths:
        kind = log[at + 2]
        end = at + lengths[kind]
        if end > len(log):
            break
        told: tuple[int, ...] = (at + 2,)
        if kind == FORMAT_TYPE:
            lengths[log[at + 3]], places[log[at + 3]] = log[at + 4], (at, end)
            names[log[at + 3]] = log[at + 5 : at + 9].rstrip(b"\0").decode("ascii", "replace")
            told = (at + 2, at + 3, at + 4)
        own = () if kind == FORMAT_TYPE else (places[kind],)
        found.append(Record(at, end, names[kind], own, told, kind != FORMAT_TYPE))
        at = end
    return found


def _text(log: bytes) -> list[Record]:
    places: dict[str, tuple[int, int]] = {}
    found = []
    at = 0
    for line in log.splitlines(keepends=True):
        if not line.endswith(b"\n"):
            break
        end = at + len(line)
        fields = [field.strip() for field in line.decode("latin-1").split(",")]
        if fields[0] == "FMT":
            places[fields[3]] = (at, end)
            found.append(Record(at, end, "FMT", (), (end - 1,), is_data=False, lead=min(at, 1)))
        elif fields[0] in places:
            found.append(Record(at, end, fields[0], (places[fields[0]],), (end - 1,), lead=min(at, 1)))
        at = end
    return found


def _ulog(log: bytes) -> list[Record]:
    formats: dict[str, tuple[int, int]] = {}
    used: dict[str, set[str]] = {}
    topics: dict[bytes, tuple[str, tuple[int, int]]] = {}
    found = []
    at = ULOG_HEAD_BYTES
    while at + 3 <= len(log) and (end := at + 3 + int.from_bytes(log[at : at + 2], "little")) <= len(log):
        kind, body = log[at + 2 : at + 3], log[at + 3 : end]
        if kind == b"F":
            name, _, members = body.decode("ascii", "replace").partition(":")
            formats[name] = (at, end)
            used[name] = set(re.findall(r"(?:\A|;)(\w+)", members))
        elif kind == b"A":
            topic = body[3:].decode("ascii", "replace")
            topics[body[1:3]] = (f"{topic}/{body[0]}", (at, end))
        if kind == b"D" and body[:2] in topics:
            name, place = topics[body[:2]]
            needed = _needed(name.partition("/")[0], used)
            described = (place, *[formats[one] for one in needed if one in formats])
            found.append(Record(at, end, name, described, (at, at + 1, at + 2)))
        else:
            found.append(Record(at, end, kind.decode("latin-1"), (), (at, at + 1, at + 2), is_data=False))
        at = end
    return found


def _needed(topic: str, used: dict[str, set[str]]) -> set[str]:
    """The topic's format, and all formats inside it."""
    needed: set[str] = set()
    waiting = [topic]
    while waiting:
        name = waiting.pop()
        if name in used and name not in needed:
            needed.add(name)
            waiting += used[name]
    return needed

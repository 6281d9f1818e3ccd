"""One run: damage a log, read it, and count the intact records that were found.

A record is intact when all of its bytes stand together as in the undamaged log, with its time of arrival (tlog) and the
ends of its line and of the one before (text). A record can be found when the format's rules allow it:

- recorded frames (tlog, bare stream): always, since each frame has a checksum and describes itself;
- DataFlash, binary and text: behind an intact description of its type (FMT), if no damaged copy of that description
  stands between the two, since a description has no checksum either;
- ULog: behind an intact subscription and the intact formats of its topic, with the same condition.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from random import Random
from typing import Final

from attest_mav.evaluation.damage.injuries import Chance, Pieces, injured
from attest_mav.evaluation.damage.readings import Content, Reader, Reading
from attest_mav.evaluation.damage.records import Record, records_of
from attest_mav.logs.detect import LogFormat
from attest_mav.mavlink.dialect import Dialect


@dataclass(frozen=True)
class Outcome:
    """The result of one run."""

    intact: int
    """Intact records that can be found."""
    recovered: int
    """Those of them that the reader found."""
    altered: int
    """Records found that the undamaged log does not have: damage that no checksum shows."""
    missing: tuple[Content, ...]
    """The first records that were not found."""
    complaint: str
    """The bytes that were counted wrongly; "" where all is well."""


class Patient:
    """An undamaged log, and what is in it."""

    def __init__(self, log_format: LogFormat, log: bytes, dialect: Dialect) -> None:
        self.log_format: Final[LogFormat] = log_format
        records = records_of(log_format, log, dialect)
        self.log: Final = log[: records[-1].end] if records else b""
        self.records: Final = records
        self.reader: Final = Reader(log_format, dialect, self.log, records)
        data = [index for index, one in enumerate(records) if one.is_data]
        whole = self.reader.read(self.log)
        self.contents: Final[dict[int, Content]] = dict(zip(data, whole.found, strict=False))
        """What the reader finds in each record of the undamaged log."""
        self.fit: Final = bool(data) and len(data) == len(whole.found) and whole.lost_bytes == 0
        """False for a log that is damaged already, or empty."""

    def damaged(self, seed: int) -> Pieces:
        """The log with the damage of this seed."""
        rng = Random(f"damage {self.log_format} {seed}")  # noqa: S311  # repeatable, no secret
        return injured(Chance(rng, self.log, self.records))


def outcome(patient: Patient, pieces: Pieces, reading: Reading) -> Outcome:
    """What the reading of the damaged log has recovered."""
    survivors = survivors_of(pieces, patient.records)
    expected = Counter(patient.contents[index] for index, _ in survivors)
    found = Counter(reading.found)
    missing = expected - found
    altered = sum((found - Counter(patient.contents.values()) - expected).values())
    size = sum((one.end - one.begin if one.foreign is None else len(one.foreign)) for one in pieces)
    return Outcome(
        intact=sum(expected.values()),
        recovered=sum(expected.values()) - sum(missing.values()),
        altered=altered,
        missing=tuple(list(missing)[:3]),
        complaint=_complaint(reading, survivors, patient.records, size) if not missing else "",
    )


def survivors_of(pieces: Pieces, records: Sequence[Record]) -> list[tuple[int, int]]:
    """Number and new place of each intact record that can be found."""
    described: set[tuple[int, int]] = set()
    found = []
    place = 0
    for piece in pieces:
        if piece.foreign is not None:
            place += len(piece.foreign)
            continue
        for index, one in enumerate(records):
            if one.end <= piece.begin or one.begin - one.lead >= piece.end:
                continue
            if piece.begin <= one.begin - one.lead and one.end <= piece.end:
                described.add((one.begin, one.end))
                if one.is_data and described.issuperset(one.descriptions):
                    found.append((index, place + one.begin - piece.begin))
            else:
                described.discard((one.begin, one.end))
        place += piece.end - piece.begin
    return found


def _complaint(reading: Reading, survivors: list[tuple[int, int]], records: Sequence[Record], size: int) -> str:
    """Lost bytes that cannot be right."""
    kept = sum(records[index].end - records[index].begin for index, _ in survivors)
    if reading.lost_bytes > size - kept:
        return f"{reading.lost_bytes} bytes counted as lost, and {kept} of {size} belong to intact records"
    for begin, length in reading.places:
        for index, at in survivors:
            if at < begin + length and begin < at + records[index].end - records[index].begin:
                return f"{length} bytes at {begin} counted as lost, and an intact record stands at {at}"
    return ""

"""Damage to a log: which of its bytes stay, in which order, and what stands between them.

A damaged log is a list of pieces. A kept piece says where its bytes come from, so that the records that survive are
known by arithmetic and not by reading.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from random import Random
from typing import Final

from attest_mav.evaluation.damage.records import Record

LONGEST: Final = 2000
"""Bytes removed, inserted or zeroed at one place, at most."""
MOST: Final = 12
"""Places of damage in one log, at most."""


@dataclass(frozen=True)
class Piece:
    """Bytes of the original from ``begin`` to ``end``, or foreign ones in their place."""

    begin: int
    end: int
    foreign: bytes | None = None


@dataclass(frozen=True)
class Chance:
    """A source of random numbers, and the undamaged log that it harms."""

    rng: Random
    log: bytes
    records: Sequence[Record]

    def stretch(self) -> tuple[int, int]:
        """Begin and end of a few bytes of the log."""
        begin = self.rng.randrange(len(self.log))
        return begin, min(len(self.log), begin + self.rng.choice((1, 2, 7, 60, self.rng.randint(1, LONGEST))))


Pieces = list[Piece]
Injury = Callable[[Chance, Pieces], Pieces]


def injured(chance: Chance) -> Pieces:
    """The log with one to ``MOST`` damages of random kinds."""
    pieces = [Piece(0, len(chance.log))]
    for _ in range(chance.rng.randint(1, MOST)):
        pieces = chance.rng.choice(list(INJURIES.values()))(chance, pieces)
    return pieces


def content(pieces: Pieces, log: bytes) -> bytes:
    """The bytes of the damaged log."""
    return b"".join(log[one.begin : one.end] if one.foreign is None else one.foreign for one in pieces)


def flip(chance: Chance, pieces: Pieces) -> Pieces:
    """One bit is wrong."""
    return _altered(pieces, chance.log, chance.rng.randrange(len(chance.log)), 1 << chance.rng.randrange(8))


def mislead(chance: Chance, pieces: Pieces) -> Pieces:
    """A byte that tells a length or a type, or ends a line, is wrong."""
    places = chance.rng.choice(chance.records).lengths
    return _altered(pieces, chance.log, chance.rng.choice(places), chance.rng.randrange(1, 256)) if places else pieces


def remove(chance: Chance, pieces: Pieces) -> Pieces:
    """Bytes are missing."""
    begin, end = chance.stretch()
    return _replaced(pieces, begin, end, b"")


def insert(chance: Chance, pieces: Pieces) -> Pieces:
    """Random bytes are too many."""
    begin, end = chance.stretch()
    return _replaced(pieces, begin, begin, chance.rng.randbytes(end - begin))


def zero(chance: Chance, pieces: Pieces) -> Pieces:
    """A block is zero, as a card leaves it that lost its power."""
    begin, end = chance.stretch()
    return _replaced(pieces, begin, end, bytes(end - begin))


def duplicate(chance: Chance, pieces: Pieces) -> Pieces:
    """A block stands twice."""
    begin, end = chance.stretch()
    doubled: Pieces = []
    done = False
    for one in pieces:
        doubled.append(one)
        if not done and one.foreign is None and one.begin < end <= one.end:
            doubled[-1:] = [Piece(one.begin, end), Piece(max(begin, one.begin), end), Piece(end, one.end)]
            done = True
    return doubled


def cut(chance: Chance, pieces: Pieces) -> Pieces:
    """The end is missing."""
    return _replaced(pieces, chance.rng.randrange(len(chance.log) // 2, len(chance.log)), len(chance.log), b"")


def join(chance: Chance, pieces: Pieces) -> Pieces:
    """Another log, undamaged, goes before or behind; once, so that sizes do not explode."""
    if sum(one.begin == 0 and one.foreign is None for one in pieces) > 1:
        return pieces
    whole = Piece(0, len(chance.log))
    return [whole, *pieces] if chance.rng.random() < 0.5 else [*pieces, whole]


INJURIES: Final[Mapping[str, Injury]] = {
    "flip": flip,
    "mislead": mislead,
    "remove": remove,
    "insert": insert,
    "zero": zero,
    "duplicate": duplicate,
    "cut": cut,
    "join": join,
}


def _altered(pieces: Pieces, log: bytes, place: int, mask: int) -> Pieces:
    return _replaced(pieces, place, place + 1, bytes((log[place] ^ mask,)))


def _replaced(pieces: Pieces, begin: int, end: int, foreign: bytes) -> Pieces:
    """The original's bytes from ``begin`` to ``end`` replaced, in the first kept piece that has all of them."""
    found: Pieces = []
    done = False
    for one in pieces:
        if done or one.foreign is not None or not one.begin <= begin <= end <= one.end:
            found.append(one)
            continue
        found += [Piece(one.begin, begin), Piece(begin, end, foreign), Piece(end, one.end)]
        done = True
    return [one for one in found if one.foreign or (one.foreign is None and one.end > one.begin)]

"""Finds the intact frames in bytes; the rules that a link and a recording share.

Theory of operation
    A frame is intact when its id is in the dialect and its checksum fits. Nothing else about a candidate is believed:
    its length serves to test its checksum and for nothing more, and to refuse a MAVLink 1 frame that is longer than
    its message, since only MAVLink 2 extends messages. A candidate that fails is left by one byte, so an
    intact frame behind a false or damaged magic is always found.

    Right behind an intact frame the next one is *expected*, at one place. If it is not there the walker *searches*:
    every magic byte is a candidate. In a search one checksum in 65536 fits by chance; so a frame found there is
    doubted when no frame stands where the next one should, while another intact one begins inside it.

    A frame that lacks its last byte is whole again when the magic of the next one equals that byte, and no checksum
    tells whose byte it is. Two frames that share one byte are therefore both taken, and in a recording also those that
    share more, if the first one stood where it was expected. A link does not wait for the bytes that would show it.

    Ids that are not in the dialect have no known CRC extra. Such a frame is passed over as a whole (and counted in
    ``unknown``) only when its neighbours prove its bounds: it stands where a frame is expected, some CRC extra explains
    its checksum (one random candidate in 256 has one), and behind it comes an intact frame or the end of the data,
    with at most two more of its kind between. Everything else with an unknown id is searched like garbage.

    Frames with an incompatibility flag other than "signed" cannot be understood and are no frames. A signature is
    recognised by its length; an optional acceptance check may verify it in the bytes of each wanted frame.
"""

from collections.abc import Callable
from typing import Final

from mypy_extensions import i64

from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.candidates import BAD_CRC, UNKNOWN_ID, Candidates
from attest_mav.mavlink.wire.frame import (
    CHECKSUM_BYTES,
    INCOMPLETE,
    MAGIC_V1,
    MAGIC_V2,
    NO_FRAME,
    Frame,
    header_at,
    message_id_at,
)
from attest_mav.mavlink.wire.sequence import Sequences

AcceptanceCheck = Callable[[bytes], bool]
"""Whether an intact frame, given from its magic to the end of its signature, may be used."""


class Walker:
    """Walks from frame to frame; the base of Framer and TlogWalker.

    lead: so many bytes precede each frame, 8 in a tlog. looks_behind: the bytes behind a frame are there, as in a
    recording, so that they can be looked at before it is taken.

    Counters over everything walked: frames (intact, wanted or not), bad_bytes (in no frame), bad_crc (candidates with
    a known id whose checksum does not fit), unknown (frames with unknown ids passed over), lost (frames missing by
    their senders' sequence numbers; late and repeated ones are not), refused (by the acceptance check; not in lost),
    shared (frames that begin inside the one before). intact: a walk before has shown that every byte belongs to one
    intact frame, so that checksums, and what is behind a frame, are not looked at again.
    """

    def __init__(
        self,
        dialect: Dialect,
        wanted: frozenset[int] | None,
        lead: int,
        looks_behind: bool,
        accepts: AcceptanceCheck | None = None,
        intact: bool = False,
    ) -> None:
        self.dialect: Final = dialect
        self.wanted: Final = wanted
        self.frames: i64 = 0
        self.bad_bytes: i64 = 0
        self.bad_crc: i64 = 0
        self.unknown: i64 = 0
        self.refused: i64 = 0
        self.shared: i64 = 0
        self._accepts: Final = accepts
        self._lead: i64 = lead
        self._looks_behind: Final = looks_behind and not intact
        self._candidates: Final = Candidates(dialect, intact)
        self._is_wanted: Final = dialect.flags(wanted)
        self._sequences: Final = Sequences()
        self._data = b""
        self._end: i64 = 0
        self._final = False
        self._out: list[Frame] = []
        self._base: i64 = 0  # offset of the data in all the bytes
        self._done: i64 = 0  # everything before is accounted for
        self._place: i64 = lead  # where a frame is expected, or looked for
        self._searching = False
        self._behind_at: i64 = -1
        self._behind: i64 = 0
        """What stands at ``_behind_at``, see ``Candidates.at``."""
        self._shared_at: i64 = -1
        """Where a frame begins that shares bytes with the one at the present place; -1 for none."""

    @property
    def lost(self) -> int:
        """Frames missing so far."""
        return self._sequences.lost

    def _walk(self, data: bytes, stop: i64, final: bool) -> list[Frame]:
        """The wanted frames that begin before ``stop`` in data, which begins at the last walk's ``_done``.

        final: nothing comes behind data, so nothing is waited for.
        """
        self._data = data
        self._candidates.begin(data)
        self._end = len(data)
        self._final = final
        self._out = []
        self._behind_at = -1
        while self._place < stop:
            size = self._behind if self._place == self._behind_at else self._candidates.at(self._place)
            if size > 0 and (self._searching or self._looks_behind):
                size = self._weighed(size)
            if size > 0:
                self._take(size)
                if self._shared_at >= 0:
                    self._take_shared()
                continue
            if size == UNKNOWN_ID and not self._searching:
                size = self._candidates.proven_unknown(self._place, self._lead, final)
                if size > 0:
                    self.unknown += 1
                    self._pass(size)
                    continue
            if size == INCOMPLETE and not final:
                break
            if size == BAD_CRC and (self._searching or self._lead == 0):  # else the search comes back to it
                self.bad_crc += 1
            self._search_on()
        self._settle()
        out = self._out
        self._out = []
        return out

    def _weighed(self, size: i64) -> i64:
        """The size of the frame just found; NO_FRAME where it rather is a coincidence: see the theory.

        INCOMPLETE while bytes that decide are missing: how the bytes are cut must not change the frames.
        """
        end = self._place + size
        behind = self._behind = self._candidates.at(end + self._lead)
        self._behind_at = end + self._lead
        if behind == UNKNOWN_ID:
            behind = self._candidates.explained(self._behind_at)
        return size if behind > 0 else self._unfollowed(size, behind == INCOMPLETE and not self._final)

    def _unfollowed(self, size: i64, waits: bool) -> i64:
        """The same for a frame that no other one follows. waits: one may still follow."""
        end = self._place + size
        found = size
        inside = self._place + 1
        while inside < end:
            other = self._candidates.at(inside)
            if other > 0 and waits:
                return INCOMPLETE
            if other > 0:
                if self._searching and inside < end - 1:
                    return NO_FRAME
                self._shared_at = inside
                return size
            if other == INCOMPLETE and not self._final:
                found = INCOMPLETE
            inside += 1
        return found

    def _take_shared(self) -> None:
        """Take the frame that begins inside the one before the present place."""
        self.shared += 1
        self._place, self._shared_at = self._shared_at, -1
        self._take(self._candidates.at(self._place))

    def _take(self, size: i64) -> None:
        """The frame at the present place is intact: count it, append it if it is wanted, go behind it."""
        data = self._data
        at = self._place
        payload = at + header_at(data, at)
        message_id = message_id_at(data, at)
        sender = at + (5 if data[at] == MAGIC_V2 else 3)
        self.frames += 1
        accepts = self._accepts
        if accepts is not None and self._is_wanted[message_id] and not accepts(data[at : at + size]):
            self.refused += 1
            self._pass(size)
            return
        self._sequences.follow(data[sender], data[sender + 1], data[sender - 1])
        if self._is_wanted[message_id]:
            length: i64 = data[at + 1]
            self._out.append(
                Frame(
                    message_id,
                    data[sender],
                    data[sender + 1],
                    data[sender - 1],
                    2 if data[at] == MAGIC_V2 else 1,
                    at + size > payload + length + CHECKSUM_BYTES,
                    data[payload : payload + length],
                    self._arrival(size),
                    self._base + at,
                    size,
                )
            )
        self._pass(size)

    def _arrival(self, size: i64) -> i64:
        """rx_ns of the frame of ``size`` bytes at the present place."""
        raise NotImplementedError

    def _pass(self, size: i64) -> None:
        """Goes behind the frame of ``size`` bytes at the present place; the next one is expected there."""
        skipped = self._place - self._lead - self._done
        if skipped > 0:
            self.bad_bytes += skipped
        self._done = self._place + size
        self._place = self._done + self._lead
        self._searching = False

    def _search_on(self) -> None:
        """No frame here: go to the next magic byte."""
        # Where a frame was expected the search begins before its lead, which may be damaged and too short.
        place = self._place + 1 if self._searching or self._lead == 0 else self._done
        self._searching = True
        data = self._data
        end = self._end
        while place < end and data[place] != MAGIC_V2 and data[place] != MAGIC_V1:
            place += 1
        self._place = place

    def _settle(self) -> None:
        """Accounts for the bytes that a search has left behind, all of them at the end of the data."""
        if self._final:
            self.bad_bytes += self._end - self._done
            self._done = self._end
            self._place = self._end + self._lead
            self._searching = False
        elif self._searching and self._place - self._lead > self._done:
            self.bad_bytes += self._place - self._lead - self._done
            self._done = self._place - self._lead

    def _forget_done(self) -> None:
        """Counts places from ``_done`` on, for data that will begin there."""
        self._base += self._done
        self._place -= self._done
        self._done = 0

"""Finds MAVLink 1 and 2 frames in bytes: on a link (``Framer``) and, by the same rules, in a recording.

Theory of operation
    A frame is intact when its id is in the dialect and its checksum fits. Nothing else about a candidate is believed:
    its length serves to test its checksum and for nothing more. A candidate that fails is left by one byte, so an
    intact frame behind a false or damaged magic is always found.

    Right behind an intact frame the next one is *expected*, at one place. If it is not there the walker *searches*:
    every magic byte is a candidate. In a search one checksum in 65536 fits by chance; so a frame found there is
    doubted when no frame stands where the next one should, while another intact one begins inside it.

    Ids that are not in the dialect have no known CRC extra. Such a frame is passed over as a whole (and counted in
    ``unknown``) only when its neighbours prove its bounds: it stands where a frame is expected, some CRC extra explains
    its checksum (one random candidate in 256 has one), and behind it comes an intact frame or the end of the data,
    with at most two more of its kind between. Everything else with an unknown id is searched like garbage.

    Frames with an incompatibility flag other than "signed" cannot be understood and are no frames. A signature is
    recognised by its length, not verified.

Waiting
    A candidate with a known id whose end has not arrived holds back what is behind it, for at most 279 bytes (the
    longest frame less one). One with an unknown id where a frame is expected does so for at most 1119 bytes (four
    frames). ``Framer.finish`` ends the wait.
"""

from typing import Final

from mypy_extensions import i64

from attest_mav.mavlink.checksum import explaining_extra, mirrored, mirrored_crc
from attest_mav.mavlink.dialect import Dialect

MAGIC_V1: Final = 0xFE
MAGIC_V2: Final = 0xFD
SIGNED: Final = 0x01
"""The one incompatibility flag there is."""

# What a candidate can be besides an intact frame of so many bytes (> 0).
NO_FRAME: Final = 0
INCOMPLETE: Final = -1
UNKNOWN_ID: Final = -2
BAD_CRC: Final = -3

MAX_UNKNOWN_RUN: Final = 3
"""So many frames with unknown ids in a row can vouch for each other."""


class Frame:
    """One intact frame.

    payload: as it was on the wire, without the zeros that MAVLink 2 cuts off. version: 1 or 2. signed: it carries a
    signature (not verified). rx_ns: when it arrived. offset, size: where its magic byte stands in all the bytes that
    came before, and its length with header, checksum and signature.
    """

    def __init__(
        self,
        message_id: int,
        system: int,
        component: int,
        sequence: int,
        version: int,
        signed: bool,
        payload: bytes,
        rx_ns: int,
        offset: int = 0,
        size: int = 0,
    ) -> None:
        self.message_id: Final = message_id
        self.system: Final = system
        self.component: Final = component
        self.sequence: Final = sequence
        self.version: Final = version
        self.signed: Final = signed
        self.payload: Final = payload
        self.rx_ns: Final = rx_ns
        self.offset: Final = offset
        self.size: Final = size


class Walker:
    """Walks from frame to frame; the base of Framer and Recording. ``lead`` bytes precede each frame: 8 in a recording.

    Counters over everything walked: frames (intact, wanted or not), bad_bytes (in no frame), bad_crc (candidates with
    a known id whose checksum does not fit), unknown (frames with unknown ids passed over), lost (frames missing by
    their senders' sequence numbers; late and repeated frames are not counted).
    """

    def __init__(self, dialect: Dialect, wanted: frozenset[int] | None, lead: int) -> None:
        self.dialect: Final = dialect
        self.wanted: Final = wanted
        self.frames: i64 = 0
        self.bad_bytes: i64 = 0
        self.bad_crc: i64 = 0
        self.unknown: i64 = 0
        self.lost: i64 = 0
        self._lead: i64 = lead
        self._extras: Final = dialect.mirrored_extras
        self._ids: i64 = len(dialect.mirrored_extras)
        self._sequences: list[list[int]] = []
        self._base: i64 = 0  # offset of the buffer in all the bytes
        self._out: list[Frame] = []
        self._searching = False
        self._data = b""
        self._mirror = b""
        self._end: i64 = 0
        self._final = False
        self._done: i64 = 0  # everything before is accounted for
        self._place: i64 = lead  # where a frame is expected, or looked for
        self._restart()

    def _restart(self) -> None:
        """Forgets the stream, not the counters."""
        self._sequences = [[] for _ in range(256)]
        self._searching = False
        self._done = 0
        self._place = self._lead

    def _walk(self, data: bytes, stop: i64, final: bool) -> list[Frame]:
        """The wanted frames that begin before ``stop`` in data, which continues where ``_done`` was left.

        final: nothing comes behind data, so nothing is waited for. Afterwards ``_done`` says how many bytes of data
        need not be seen again.
        """
        self._data = data
        self._mirror = mirrored(data)
        self._end = len(data)
        self._final = final
        self._out = []
        while self._place < stop:
            size = self._candidate(self._place)
            if size > 0:
                if self._searching and self._doubtful(size):
                    self._search_on()
                else:
                    self._take(size)
            elif size == UNKNOWN_ID and not self._searching:
                size = self._proven_unknown()
                if size > 0:
                    self.unknown += 1
                    self._pass(size)
                elif size == INCOMPLETE and not final:
                    break
                else:
                    self._search_on()
            elif size == INCOMPLETE and not final:
                break
            else:
                self.bad_crc += 1 if size == BAD_CRC and (self._searching or self._lead == 0) else 0
                self._search_on()
        self._settle()
        out = self._out
        self._out = []
        return out

    def _candidate(self, at: i64) -> i64:
        """What stands at ``at``: the size of an intact frame, or one of the constants."""
        data = self._data
        left: i64 = self._end - at
        if left <= 0:
            return INCOMPLETE
        magic: i64 = data[at]
        if magic == MAGIC_V2:
            if left >= 3 and data[at + 2] > SIGNED:
                return NO_FRAME
            if left < 10:
                return INCOMPLETE
            message_id: i64 = data[at + 7] | (data[at + 8] << 8) | (data[at + 9] << 16)
            checksum: i64 = at + 10 + data[at + 1]
            size: i64 = checksum + 2 - at + (13 if data[at + 2] == SIGNED else 0)
        elif magic == MAGIC_V1:
            if left < 6:
                return INCOMPLETE
            message_id = data[at + 5]
            checksum = at + 6 + data[at + 1]
            size = checksum + 2 - at
        else:
            return NO_FRAME
        if message_id >= self._ids:
            return UNKNOWN_ID
        extra: i64 = self._extras[message_id]
        if extra < 0:
            return UNKNOWN_ID
        if size > left:
            return INCOMPLETE
        mirror = self._mirror
        received: i64 = (mirror[checksum] << 8) | mirror[checksum + 1]
        return size if mirrored_crc(mirror, at + 1, checksum, extra) == received else BAD_CRC

    def _doubtful(self, size: i64) -> bool:
        """Whether the frame just found in a search rather is a coincidence: see the module's theory."""
        behind = self._place + size
        if self._candidate(behind + self._lead) > 0:
            return False
        inside = self._place + 1
        while inside < behind:
            if self._candidate(inside) > 0:
                return True
            inside += 1
        return False

    def _proven_unknown(self) -> i64:
        """Size of the frame of an unknown id at the expected place; INCOMPLETE while undecided; else NO_FRAME."""
        at = self._place
        run: i64 = 0
        first: i64 = 0
        while run < MAX_UNKNOWN_RUN:
            size = self._explained(at)
            if size <= 0:
                return size
            if run == 0:
                first = size
            if self._final and at + size == self._end:
                return first
            at += size + self._lead
            behind = self._candidate(at)
            if behind != UNKNOWN_ID:
                return first if behind > 0 else behind if behind == INCOMPLETE else NO_FRAME
            run += 1
        return NO_FRAME

    def _explained(self, at: i64) -> i64:
        """Size of the candidate with an unknown id at ``at`` when some CRC extra explains its checksum."""
        data = self._data
        header: i64 = 10 if data[at] == MAGIC_V2 else 6
        checksum: i64 = at + header + data[at + 1]
        size: i64 = checksum + 2 - at
        if header == 10 and data[at + 2] == SIGNED:
            size += 13
        if at + size > self._end:
            return INCOMPLETE
        return size if explaining_extra(self._mirror, at + 1, checksum) >= 0 else NO_FRAME

    def _take(self, size: i64) -> None:
        """The frame at the present place is intact: count it, append it if it is wanted, go behind it."""
        data = self._data
        at = self._place
        self.frames += 1
        signed = False
        if data[at] == MAGIC_V2:
            version: i64 = 2
            payload: i64 = at + 10
            message_id: i64 = data[at + 7] | (data[at + 8] << 8) | (data[at + 9] << 16)
            signed = data[at + 2] == SIGNED
        else:
            version = 1
            payload = at + 6
            message_id = data[at + 5]
        sender: i64 = payload - (5 if version == 2 else 3)
        self._follow_sequence(data[sender], data[sender + 1], data[sender - 1])
        if self.wanted is None or message_id in self.wanted:
            self._out.append(
                Frame(
                    message_id,
                    data[sender],
                    data[sender + 1],
                    data[sender - 1],
                    version,
                    signed,
                    data[payload : payload + data[at + 1]],
                    self._arrival(size),
                    self._base + at,
                    size,
                )
            )
        self._pass(size)

    def _arrival(self, size: i64) -> int:
        """rx_ns of the frame at the present place."""
        raise NotImplementedError

    def _follow_sequence(self, system: i64, component: i64, sequence: i64) -> None:
        """Counts the frames missing since this sender's last one; a gap above 127 is a late or repeated frame."""
        row = self._sequences[system]
        if not row:
            row = [-1] * 256
            self._sequences[system] = row
        last: i64 = row[component]
        gap: i64 = (sequence - last - 1) & 0xFF
        if last < 0:
            gap = 0
        if gap < 128:
            self.lost += gap
            row[component] = sequence

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
        if self._searching or self._lead == 0:
            self._place += 1
        else:
            self._place = self._done  # the lead may be damaged, and shorter than it should be
        self._searching = True
        data = self._data
        place = self._place
        end = self._end
        while place < end:
            byte: i64 = data[place]
            if byte == MAGIC_V2 or byte == MAGIC_V1:
                break
            place += 1
        self._place = place

    def _settle(self) -> None:
        """Accounts for the bytes that a search has left behind, all of them at the end of the data."""
        if self._final:
            self.bad_bytes += self._end - self._done
            self._done = self._end
        elif self._searching and self._place - self._lead > self._done:
            self.bad_bytes += self._place - self._lead - self._done
            self._done = self._place - self._lead


class Framer(Walker):
    """The frames of a link, from bytes as they arrive, cut anywhere.

    wanted: the ids to return; None for all. The rest is checked and counted, and costs little.
    """

    def __init__(self, dialect: Dialect, wanted: frozenset[int] | None) -> None:
        super().__init__(dialect, wanted, 0)
        self._pending = b""
        self._rx_ns = 0

    def feed(self, data: bytes, rx_ns: int) -> list[Frame]:
        """The wanted frames completed by data, which arrived at rx_ns (host clock)."""
        return self._continue(data, rx_ns, False)

    def finish(self, rx_ns: int) -> list[Frame]:
        """The wanted frames behind candidates that were still waited for: for a stream that ends or falls silent."""
        frames = self._continue(b"", rx_ns, True)
        self._restart_link()
        return frames

    def reset(self) -> None:
        """Forgets the bytes and sequence numbers of the present stream, for a link opened again. Counters stay."""
        self.bad_bytes += len(self._pending)
        self._restart_link()

    def _restart_link(self) -> None:
        self._pending = b""
        self._restart()

    def _continue(self, data: bytes, rx_ns: int, final: bool) -> list[Frame]:
        self._rx_ns = rx_ns
        buffer = self._pending + data if self._pending else data
        frames = self._walk(buffer, len(buffer), final)
        self._pending = buffer[self._done :]
        self._base += self._done
        self._place -= self._done
        self._done = 0
        return frames

    def _arrival(self, size: i64) -> int:
        return self._rx_ns

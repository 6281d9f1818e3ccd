"""Decides on each frame of one link by its signature, before anything in it is used.

A signed frame counts when its signature was made with our key, when its timestamp is later than the last one of its
stream (system, component, link id), and when it is at most a minute older than our own time. Nothing is learned from a
frame whose signature is wrong: otherwise one forged timestamp in the far future would lock the true sender out. A
correct signature in the future counts, and our own time follows it.

An unsigned frame counts where the link does not require signatures, unless its system has signed with our key: then
only somebody else can have sent it.
"""

from enum import Enum
from typing import Final

from attest_mav.mavlink.component.line_limit import LineLimit
from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.signing.clock import SigningClock
from attest_mav.mavlink.signing.settings import SigningSettings
from attest_mav.mavlink.signing.signature import LATEST, is_made_with, is_signed, link_id_of, timestamp_in
from attest_mav.mavlink.signing.streams import SignedStreams
from attest_mav.mavlink.wire.frame import MAGIC_V2, message_id_at

OLDEST: Final = 60 * 100_000
"""A frame may be so much older than our own time, in ticks: a minute."""
TOLD_AHEAD: Final = 60 * 100_000
"""A correct timestamp that is further ahead of ours is told, in ticks."""
TICKS_PER_S: Final = 100_000
RECENT_NS: Final = 10_000_000_000
"""A system that was heard in this time is named in the status."""


class Trust(Enum):
    """The outcome of a frame's signature, the best first."""

    VERIFIED = "verified"
    """Signed with our key, in time."""
    UNKNOWN_KEY = "unknown key"
    """Signed, and not with our key."""
    OLD = "old"
    """Signed with our key, and repeated or older than a minute."""
    FUTURE = "future"
    """Signed with our key, with a timestamp near the end of its 48 bits."""
    DROPPED = "dropped"
    """Unsigned, and dropped."""
    UNSIGNED = "unsigned"
    """Unsigned, and taken."""


class Verifier:
    """The acceptance check of one link. ``streams``: the timestamps heard on all links with the same key."""

    def __init__(
        self,
        dialect: Dialect,
        name: str,
        settings: SigningSettings,
        clock: SigningClock,
        streams: SignedStreams,
        notebook: Notebook,
    ) -> None:
        self.requires: Final = settings.requires
        """Whether unsigned frames are dropped."""
        self.counts: Final = dict.fromkeys(Trust, 0)
        """Frames so far, by outcome."""
        self._heard: Final[dict[tuple[int, Trust], int]] = {}
        self._name: Final = name
        self._key: Final = settings.key
        self._exempt: Final = frozenset([dialect.id_of(message) for message in settings.accept_unsigned])
        self._clock: Final = clock
        self._streams: Final = streams
        self._notebook: Final = notebook
        self._lines: Final = LineLimit()

    def accepts(self, frame: bytes) -> bool:
        """Whether a whole frame, given from its magic to the end of its signature, may be used."""
        sender = 5 if frame[0] == MAGIC_V2 else 3
        system, component = frame[sender], frame[sender + 1]
        trust = self._signed(frame, system, component) if is_signed(frame) else self._unsigned(frame, system, component)
        self.counts[trust] += 1
        if component != self._streams.own_component:
            self._heard[system, trust] = self._clock.now_ns
        return trust in {Trust.VERIFIED, Trust.UNSIGNED}

    @property
    def authentic(self) -> int:
        """Frames so far that somebody with our key has signed, in time or too early."""
        return self.counts[Trust.VERIFIED] + self.counts[Trust.OLD]

    def systems(self, now_ns: int) -> list[tuple[int, Trust]]:
        """The systems heard in the last seconds, each with the best outcome of its frames, in order of their ids."""
        best: dict[int, Trust] = {}
        for trust in Trust:
            for (system, outcome), heard_ns in self._heard.items():
                if outcome is trust and now_ns - heard_ns < RECENT_NS:
                    best.setdefault(system, trust)
        return sorted(best.items(), key=lambda one: one[0])

    def _signed(self, frame: bytes, system: int, component: int) -> Trust:
        if not is_made_with(self._key, frame):
            self._warn("key", f"frames of system {system} are signed, and not with our key: dropped")
            return Trust.UNKNOWN_KEY
        timestamp = timestamp_in(frame)
        if timestamp > LATEST:
            self._warn("future", f"system {system} signs with an impossible time: dropped; set its clock")
            return Trust.FUTURE
        ahead = timestamp - self._clock.timestamp
        if ahead < -OLDEST or not self._streams.take((system, component, link_id_of(frame)), timestamp):
            return Trust.OLD
        if ahead > 0:
            self._clock.follow(timestamp)
        if ahead > TOLD_AHEAD:
            self._warn(
                "ahead", f"system {system} signs with a time {ahead // TICKS_PER_S} s ahead of ours: ours follows it"
            )
        return Trust.VERIFIED

    def _unsigned(self, frame: bytes, system: int, component: int) -> Trust:
        if message_id_at(frame, 0) in self._exempt and not self._streams.has_signed(system, component):
            return Trust.UNSIGNED
        if self._streams.has_signing_system(system):
            self._warn("forged", f"unsigned frames under system {system}, which signs with our key: dropped")
            return Trust.DROPPED
        return Trust.DROPPED if self.requires else Trust.UNSIGNED

    def _warn(self, kind: str, text: str) -> None:
        """Leave a warning, at most one of a kind in a minute."""
        suffix = self._lines.suffix(kind, self._clock.now_ns)
        if suffix is not None:
            self._notebook.warning(f"{self._name}: {text}{suffix}")

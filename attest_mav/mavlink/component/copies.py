"""Copies of frames: the same sequence number with the same content, by another link or once more by the same one."""

from typing import Final

from attest_mav.mavlink.wire.frame import Frame

WINDOW_NS: Final = 2_000_000_000
"""A frame that comes again within this time is a copy."""
SHARE_NS: Final = 2_000_000_000
"""A link that has brought a copy within this time brings the same stream as the others."""


class _Seen:
    """A frame that was used."""

    def __init__(self, link: int, frame: Frame, now_ns: int) -> None:
        self.link: Final = link
        self.message_id: Final = frame.message_id
        self.payload: Final = frame.payload
        self.now_ns: Final = now_ns


class Copies:
    """Remembers the last frames of one sender by their sequence numbers."""

    def __init__(self) -> None:
        self.dropped = 0
        """Copies so far."""
        self.original_link = -1
        """The link that brought the original of the last copy."""
        self._seen: Final[dict[int, _Seen]] = {}
        self._shared_ns: Final[dict[int, int]] = {}
        self._newest = -1

    def is_copy(self, link: int, frame: Frame, now_ns: int) -> bool:
        """Whether the frame has come before."""
        seen = self._seen.get(frame.sequence)
        if (
            seen is None
            or seen.message_id != frame.message_id
            or now_ns - seen.now_ns >= WINDOW_NS
            or seen.payload != frame.payload
        ):
            return False
        self.dropped += 1
        self.original_link = seen.link
        self._shared_ns[link] = now_ns
        return True

    def taken(self, link: int, frame: Frame, now_ns: int) -> None:
        """Remember a frame that is used."""
        self._seen[frame.sequence] = _Seen(link, frame, now_ns)
        self._newest = frame.sequence

    def continues(self, link: int, frame: Frame, now_ns: int) -> bool:
        """Whether a link that brings the same stream brings a frame that is newer than all that were taken."""
        shared_ns = self._shared_ns.get(link)
        if shared_ns is None or now_ns - shared_ns >= SHARE_NS:
            return False
        return 0 < (frame.sequence - self._newest) & 0xFF < 128

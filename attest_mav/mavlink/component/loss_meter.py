"""The share of a link's frames that are lost or damaged, from the counters of its framers."""

from typing import Final

SPAN_NS: Final = 3_000_000_000
"""The share is measured over this time."""
SHOWN: Final = 0.05
"""Smaller shares are no reason for anything."""
MIN_FRAMES: Final = 20


class LossMeter:
    """``share``: of the frames that were sent to us on this link, 0 to 1."""

    def __init__(self) -> None:
        self.share = 0.0
        self._is_damage = False
        self._before = (0, 0, 0)
        self._began_ns = 0

    def take(self, frames: int, lost: int, bad_crc: int, now_ns: int) -> None:
        """Take the counters: intact frames, frames missing by their numbers, frames with a wrong checksum."""
        if now_ns - self._began_ns < SPAN_NS:
            return
        got, missing, damaged = frames - self._before[0], lost - self._before[1], bad_crc - self._before[2]
        self._before, self._began_ns = (frames, lost, bad_crc), now_ns
        self.share = missing / (got + missing) if got + missing >= MIN_FRAMES else 0.0
        self._is_damage = 2 * damaged >= missing

    @property
    def text(self) -> str:
        """What the link does to frames, "" where it loses few."""
        if self.share < SHOWN:
            return ""
        return f"{100.0 * self.share:.0f} % of the frames are {'damaged' if self._is_damage else 'lost'} on the link"

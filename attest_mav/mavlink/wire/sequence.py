"""Frames that are missing, by the sequence numbers of their senders."""

from mypy_extensions import i64


class Sequences:
    """Follows every sender. lost: frames missing so far; late and repeated ones are not counted."""

    def __init__(self) -> None:
        self.lost: i64 = 0
        self._last: list[list[int]] = [[] for _ in range(256)]

    def forget(self) -> None:
        """Whatever comes next is nobody's second frame; ``lost`` stays."""
        self._last = [[] for _ in range(256)]

    def follow(self, system: i64, component: i64, sequence: i64) -> None:
        """Take a frame's number. A gap above 127 is a late or repeated frame."""
        row = self._last[system]
        if not row:
            row = [-1] * 256
            self._last[system] = row
        last: i64 = row[component]
        gap: i64 = (sequence - last - 1) & 0xFF if last >= 0 else 0
        if gap < 128:
            self.lost += gap
            row[component] = sequence

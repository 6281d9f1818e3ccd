"""Frames that are missing, by the sequence numbers of their senders."""

from mypy_extensions import i64


class Sequences:
    """Follows every sender. lost: frames missing so far; late and repeated ones are not counted."""

    def __init__(self) -> None:
        self.lost: i64 = 0
        self._rows: list[list[int]] = [[] for _ in range(256)]
        """The last numbers by system and component, -1 before the first; that of the newest sender is out of date."""
        self._system: i64 = 0
        self._component: i64 = 0
        self._last: i64 = -1
        """The newest sender, whose frame the next one mostly is too, and its last number."""

    def forget(self) -> None:
        """Whatever comes next is nobody's second frame; ``lost`` stays."""
        self._rows = [[] for _ in range(256)]
        self._last = -1

    def follow(self, system: i64, component: i64, sequence: i64) -> None:
        """Take a frame's number. A gap above 127 is a late or repeated frame."""
        if system != self._system or component != self._component:
            self._row(self._system)[self._component] = self._last
            self._last = self._row(system)[component]
            self._system, self._component = system, component
        last = self._last
        gap: i64 = (sequence - last - 1) & 0xFF if last >= 0 else 0
        if gap < 128:
            self.lost += gap
            self._last = sequence

    def _row(self, system: i64) -> list[int]:
        """The last numbers of a system's components."""
        row = self._rows[system]
        if not row:
            row = [-1] * 256
            self._rows[system] = row
        return row

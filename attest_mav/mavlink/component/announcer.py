"""Texts for people at a ground station: STATUSTEXT, limited in number, the newest one of each topic.

A text waits until it may be sent. A newer text of the same topic replaces one that waits, so that a condition that
comes and goes is told as it stands. Texts of severity CRITICAL and worse are not counted against the limit of a minute.
"""

from typing import Final

from attest_mav.mavlink.constants import MAV_SEVERITY_CRITICAL

SPACING_NS: Final = 1_000_000_000
"""At most one text in this time."""
MINUTE_NS: Final = 60_000_000_000
MAX_PER_MINUTE: Final = 6
"""At most so many texts less severe than CRITICAL in a minute."""
REPEAT_NS: Final = 10_000_000_000
"""The same text of a topic is not repeated within this time."""


class Announcement:
    """One text. topic: the condition that it tells of. severity: MAV_SEVERITY, the worst is 0."""

    def __init__(self, topic: str, severity: int, text: str) -> None:
        self.topic: Final = topic
        self.severity: Final = severity
        self.text: Final = text


class Announcer:
    """Keeps texts until they may be sent."""

    def __init__(self) -> None:
        self._waiting: Final[dict[str, Announcement]] = {}
        self._last: Final[dict[str, tuple[str, int]]] = {}
        self._sent_ns: list[int] = []
        self._next_ns = 0

    def announce(self, announcement: Announcement) -> None:
        """Take a text to be sent as soon as the limits allow."""
        self._waiting.pop(announcement.topic, None)
        self._waiting[announcement.topic] = announcement

    def take(self, now_ns: int) -> Announcement | None:
        """The text to be sent now: the most severe, of equal ones the oldest; None while none may be sent."""
        if now_ns < self._next_ns:
            return None
        self._sent_ns = [sent_ns for sent_ns in self._sent_ns if now_ns - sent_ns < MINUTE_NS]
        for one in sorted(self._waiting.values(), key=_severity):
            if one.severity > MAV_SEVERITY_CRITICAL and len(self._sent_ns) >= MAX_PER_MINUTE:
                return None
            del self._waiting[one.topic]
            if self._repeats(one, now_ns):
                continue
            self._last[one.topic] = (one.text, now_ns)
            self._next_ns = now_ns + SPACING_NS
            if one.severity > MAV_SEVERITY_CRITICAL:
                self._sent_ns.append(now_ns)
            return one
        return None

    @property
    def next_deadline_ns(self) -> int | None:
        """When ``take`` has a text, None while none waits."""
        if not self._waiting:
            return None
        worst = min(one.severity for one in self._waiting.values())
        if worst > MAV_SEVERITY_CRITICAL and len(self._sent_ns) >= MAX_PER_MINUTE:
            return max(self._next_ns, self._sent_ns[0] + MINUTE_NS)
        return self._next_ns

    def _repeats(self, one: Announcement, now_ns: int) -> bool:
        last = self._last.get(one.topic)
        return last is not None and last[0] == one.text and now_ns - last[1] < REPEAT_NS


def _severity(one: Announcement) -> int:
    return one.severity

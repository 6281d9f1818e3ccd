"""The vehicle's frames on all links: each is used once, from whichever link brings it.

A stream of one message is taken from one link, since an autopilot numbers and times its frames on each of its ports by
itself. Another link takes it over when the first has been silent for three intervals of the message. A link that brings
copies of the same frames fills in what the first one has lost. Answers and texts count from every link.
"""

from typing import Final

from attest_mav.mavlink.component.copies import Copies
from attest_mav.mavlink.component.identity_watch import IdentityWatch
from attest_mav.mavlink.component.line_limit import LineLimit
from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import Frame

EVENTS: Final = ("HEARTBEAT", "PARAM_VALUE", "STATUSTEXT", "AUTOPILOT_VERSION", "COMMAND_ACK")
"""Messages that are no stream."""
SHORTEST_TAKEOVER_NS: Final = 300_000_000
LONGEST_TAKEOVER_NS: Final = 3_000_000_000
"""Bounds of the silence after which another link takes a stream over."""
INTERVALS: Final = 3
"""That silence in intervals of the message."""
AWAY_NS: Final = 2_000_000_000
"""The vehicle has been silent for this long on all links: nothing is requested. Its heartbeats come once a second."""
SILENT_NS: Final = 500_000_000
"""The vehicle has been silent for this long on all links: rates over this time tell of the links alone."""
LOOP_COPIES: Final = 20
"""Copies within ``LOOP_SPAN_NS`` on the link that brought the originals: a router sends frames twice, or in a loop."""
LOOP_SPAN_NS: Final = 5_000_000_000


class _Home:
    """The link that a stream is taken from."""

    def __init__(self, link: int, now_ns: int) -> None:
        self.link = link
        self.heard_ns = now_ns
        self._interval_ns = LONGEST_TAKEOVER_NS // INTERVALS

    def arrived(self, now_ns: int) -> None:
        """Follow the usual interval of the message."""
        self._interval_ns += (now_ns - self.heard_ns - self._interval_ns) // 8
        self.heard_ns = now_ns

    def is_silent(self, now_ns: int) -> bool:
        """Whether another link may take over."""
        patience_ns = min(max(INTERVALS * self._interval_ns, SHORTEST_TAKEOVER_NS), LONGEST_TAKEOVER_NS)
        return now_ns - self.heard_ns >= patience_ns


class VehicleTraffic:
    """Decides on each frame with the vehicle's ids. ``links``: their names."""

    def __init__(self, dialect: Dialect, links: list[str], notebook: Notebook) -> None:
        self.identity = IdentityWatch()
        """Two senders with the vehicle's ids."""
        self.is_signed = False
        """Whether the vehicle's newest frame carries a signature."""
        self.link = 0
        """The link of the frame taken last."""
        self._events: Final = frozenset([dialect.id_of(name) for name in EVENTS])
        self._links: Final = links
        self._notebook: Final = notebook
        self._lines: Final = LineLimit()
        self._copies = Copies()
        self._homes: Final[dict[int, _Home]] = {}
        self._heard_ns = self._resumed_ns = -AWAY_NS
        self._loop_began_ns = 0
        self._loop_copies = 0
        self._looping = -1

    def begin_anew(self) -> None:
        """The vehicle is another one, or there is none."""
        self.identity = IdentityWatch()
        self._copies = Copies()
        self._homes.clear()
        self.is_signed = False

    def take(self, link: int, frame: Frame, now_ns: int) -> bool:
        """Whether to use this frame of the vehicle."""
        if now_ns - self._heard_ns >= SILENT_NS:
            self._resumed_ns = now_ns
        self._heard_ns = now_ns
        self.is_signed = frame.signed
        if self._copies.is_copy(link, frame, now_ns):
            if self._copies.original_link == link:
                self._watch_loop(link, now_ns)
            return False
        self.identity.frame(link, frame.sequence, now_ns)
        if frame.message_id not in self._events and not self._is_home(link, frame, now_ns):
            return False
        self._copies.taken(link, frame, now_ns)
        self.link = link
        return True

    def link_broken(self, link: int) -> None:
        """The stream of this link ended: another one may take over at once."""
        for message_id, home in list(self._homes.items()):
            if home.link == link:
                del self._homes[message_id]

    def is_away(self, now_ns: int) -> bool:
        """Whether nothing has come from the vehicle for some time, so that no request would be answered."""
        return now_ns - self._heard_ns >= AWAY_NS

    def silent_ns(self, now_ns: int) -> int:
        """When the vehicle was last silent on all links: now, or at the end of its last silence."""
        return now_ns if now_ns - self._heard_ns >= SILENT_NS else self._resumed_ns

    def remarks(self, system: int, now_ns: int) -> list[str]:
        """What is wrong with the vehicle's frames, for the status; noted in the log once a minute."""
        remarks = []
        evidence = self.identity.evidence(now_ns)
        if evidence:
            remarks.append(f"two vehicles use system {system} ({evidence}): give each a system id of its own")
        if self._looping >= 0 and now_ns - self._loop_began_ns < 2 * LOOP_SPAN_NS:
            name = self._links[self._looping]
            remarks.append(f"{name} brings frames more than once: a router loops, or forwards twice")
        return remarks

    def note_remarks(self, system: int, now_ns: int) -> None:
        """Leave a warning for each remark, once a minute."""
        for remark in self.remarks(system, now_ns):
            if self._lines.suffix(remark, now_ns) is not None:
                self._notebook.warning(remark)

    def _is_home(self, link: int, frame: Frame, now_ns: int) -> bool:
        home = self._homes.get(frame.message_id)
        if home is None:
            self._homes[frame.message_id] = _Home(link, now_ns)
            return True
        if home.link == link:
            home.arrived(now_ns)
            return True
        if home.is_silent(now_ns):
            self._homes[frame.message_id] = _Home(link, now_ns)
            return True
        return self._copies.continues(link, frame, now_ns)

    def _watch_loop(self, link: int, now_ns: int) -> None:
        """Count the copies on the link that brought the originals."""
        if now_ns - self._loop_began_ns >= LOOP_SPAN_NS:
            if self._loop_copies < LOOP_COPIES:
                self._looping = -1
            self._loop_began_ns, self._loop_copies = now_ns, 0
        self._loop_copies += 1
        if self._loop_copies >= LOOP_COPIES:
            self._looping = link

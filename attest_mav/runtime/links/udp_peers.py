"""The senders that a UDP listener answers.

The source of a datagram can be forged, and then the answers hit somebody else. A sender becomes a peer with its first
intact MAVLink frame, is answered for a short time after it, and for longer once it has gone on speaking. A new sender
never displaces one that has spoken for some time and still does.
"""

from typing import Final

from attest_mav.runtime.links.base import Address

MAX_PEERS: Final = 16
"""A listener answers at most this many senders."""
PROVEN_NS: Final = 3_000_000_000
"""A sender that has gone on for this long is known: nobody forges a source for nothing."""
FIRST_SILENCE_NS: Final = 3_000_000_000
"""A new sender that is silent for this long is answered no more."""
SILENCE_NS: Final = 30_000_000_000
"""A known sender that is silent for this long is answered no more, unless it is the only one."""


class _Peer:
    def __init__(self, now_ns: int) -> None:
        self.first_ns: Final = now_ns
        self.heard_ns = now_ns

    @property
    def is_known(self) -> bool:
        return self.heard_ns - self.first_ns >= PROVEN_NS


class UdpPeers:
    """Who is answered, by address."""

    def __init__(self) -> None:
        self._peers: Final[dict[Address, _Peer]] = {}

    def __len__(self) -> int:
        return len(self._peers)

    def heard(self, address: Address, now_ns: int) -> bool:
        """An intact frame came from there; True where it makes a new peer."""
        peer = self._peers.get(address)
        if peer is not None:
            peer.heard_ns = now_ns
            return False
        self._forget_silent(now_ns)
        if len(self._peers) >= MAX_PEERS and not self._make_room():
            return False
        self._peers[address] = _Peer(now_ns)
        return True

    def answered(self, now_ns: int) -> list[Address]:
        """The addresses to send to."""
        self._forget_silent(now_ns)
        return list(self._peers)

    def _forget_silent(self, now_ns: int) -> None:
        """Drop the silent ones; of known ones, the one heard last stays."""
        known = [one for one, peer in self._peers.items() if peer.is_known]
        last = max(known, key=lambda one: self._peers[one].heard_ns, default=None)
        for address, peer in list(self._peers.items()):
            limit_ns = SILENCE_NS if peer.is_known else FIRST_SILENCE_NS
            if address != last and now_ns - peer.heard_ns > limit_ns:
                del self._peers[address]

    def _make_room(self) -> bool:
        """Drop the new sender that has been silent longest; False where all are known."""
        new = [one for one, peer in self._peers.items() if not peer.is_known]
        if not new:
            return False
        del self._peers[min(new, key=lambda one: self._peers[one].heard_ns)]
        return True

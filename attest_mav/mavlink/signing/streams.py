"""The timestamps of all streams that sign with one key, whichever link brings them.

A stream is a system, a component and a link id of the sender. The links share the table, so that a frame recorded on
one of them cannot be played again on another.
"""

from typing import Final

StreamId = tuple[int, int, int]


class SignedStreams:
    """The last timestamp of each stream. Only correct signatures come in here, so only holders of the key fill it.

    own_component: our component id, under which our own frames may come back; they prove nothing about their system.
    """

    def __init__(self, own_component: int) -> None:
        self.own_component: Final = own_component
        self._last: Final[dict[StreamId, int]] = {}
        self._components: Final[set[tuple[int, int]]] = set()
        self._systems: Final[set[int]] = set()

    def take(self, stream: StreamId, timestamp: int) -> bool:
        """Take a timestamp; False where it is not later than the last one of the stream."""
        if timestamp <= self._last.get(stream, -1):
            return False
        self._last[stream] = timestamp
        system, component, _ = stream
        if component != self.own_component:
            self._components.add((system, component))
            self._systems.add(system)
        return True

    def has_signed(self, system: int, component: int) -> bool:
        """Whether this component has signed with the key."""
        return (system, component) in self._components

    def has_signing_system(self, system: int) -> bool:
        """Whether a component of this system has signed with the key."""
        return system in self._systems

"""Puts a vehicle that is no real one, simulated or recorded, on a link, in real time or a multiple of it.

Simulated time is the time since the start, times the speed. If the machine cannot keep up, the vehicle falls behind
and stays behind: it is advanced in slices, between which the link is served and signals are heard.
"""

import socket
import time
from math import ceil
from typing import Final, Protocol

from attest_mav.mavlink.wire.framer import Framer
from attest_mav.runtime.links.base import Link
from attest_mav.runtime.links.served import ServedLink
from attest_mav.runtime.loop import Loop, Timer

SLICE_NS: Final = 100_000_000
"""The most that the vehicle is advanced at once, simulated time."""


class Vehicle(Protocol):
    """A source of frames on its own time, ns from 0."""

    @property
    def framer(self) -> Framer:
        """Counts the frames that arrive."""

    def handle(self, data: bytes, now_ns: int, /) -> None:
        """Take bytes that arrived."""

    def frames_until(self, now_ns: int, /) -> list[bytes]:
        """All frames that were sent since the last call, up to and including ``now_ns``, oldest first."""

    @property
    def next_deadline_ns(self) -> int | None:
        """When ``frames_until`` may have something; None after the end."""


class VehicleHost:
    """One vehicle on one link. duration_ns: when to end, simulated time; None for never. speed: times real time."""

    def __init__(self, vehicle: Vehicle, link: Link, duration_ns: int | None, speed: float) -> None:
        self._vehicle: Final = vehicle
        self._link: Final = link
        self._duration_ns: Final = duration_ns
        self._speed: Final = speed
        self._start_ns = 0
        self._simulated_ns = 0
        self._loop: Final = Loop()
        self._loop.add(ServedLink(link, self._receive, vehicle.framer.reset))
        self._loop.add(Timer(self._deadline_ns, self._advance))

    def run(self, stop: socket.socket) -> None:
        """Serve the link until the duration is over, or ``stop`` becomes readable (see ``stop_signals``)."""
        self._start_ns = time.monotonic_ns()
        try:
            self._loop.run(stop)
        finally:
            self._loop.close()

    def _receive(self, data: bytes, now_ns: int) -> None:
        """Take bytes that arrived on the link, and send the answers to them."""
        before = self._vehicle.framer.frames
        self._vehicle.handle(data, self._until_ns(now_ns))
        if self._vehicle.framer.frames > before:
            self._link.confirm(now_ns)
        self._advance(now_ns)

    def _advance(self, now_ns: int) -> None:
        """Advance the vehicle by at most a slice and send its frames; end after the last one, or the duration."""
        until_ns = self._until_ns(now_ns)
        for frame in self._vehicle.frames_until(until_ns):
            self._link.send(frame, now_ns)
        self._simulated_ns = until_ns
        is_over = self._vehicle.next_deadline_ns is None
        if is_over or (self._duration_ns is not None and until_ns >= self._duration_ns):
            self._loop.stop()

    def _until_ns(self, now_ns: int) -> int:
        """The simulated time to advance to."""
        until_ns = min(round((now_ns - self._start_ns) * self._speed), self._simulated_ns + SLICE_NS)
        return until_ns if self._duration_ns is None else min(until_ns, self._duration_ns)

    def _deadline_ns(self) -> int:
        """When the vehicle has something to send, or the time is over, on the host's clock."""
        due_ns = self._vehicle.next_deadline_ns
        if due_ns is None:
            return self._start_ns
        if self._duration_ns is not None:
            due_ns = min(due_ns, self._duration_ns)
        return self._start_ns + ceil(due_ns / self._speed)

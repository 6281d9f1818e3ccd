"""Puts a fake autopilot on a link, in real time or a multiple of it.

Simulated time is the time since the start, times the speed. If the machine cannot keep up, the vehicle falls behind
and stays behind: it is advanced in slices, between which the link is served and signals are heard.
"""

import selectors
import socket
import time
from typing import Final

from attest_mav.runtime.links.base import Link
from attest_mav.sim.autopilot import FakeAutopilot

SLICE_NS: Final = 100_000_000
"""The most that the vehicle is advanced at once, simulated time."""

LONGEST_WAIT_S: Final = 1.0


class SimHost:
    """One vehicle on one link. duration_ns: when to end, simulated time; None for never. speed: times real time."""

    def __init__(self, vehicle: FakeAutopilot, link: Link, duration_ns: int | None, speed: float) -> None:
        self.vehicle = vehicle
        self.link = link
        self.duration_ns = duration_ns
        self.speed = speed
        self.start_ns = 0
        self.simulated_ns = 0
        self.epoch = link.epoch
        self.watched: int | None = None

    def run(self, stop: socket.socket) -> None:
        """Serve the link until the duration is over, or ``stop`` becomes readable (see ``stop_signals``)."""
        with selectors.DefaultSelector() as selector:
            selector.register(stop, selectors.EVENT_READ)
            self.start_ns = time.monotonic_ns()
            while not self._is_over():
                self._watch(selector)
                ready = selector.select(self._wait_s(time.monotonic_ns()))
                if any(key.fileobj is stop for key, _ in ready):
                    return
                self._serve(time.monotonic_ns())

    def _is_over(self) -> bool:
        return self.duration_ns is not None and self.simulated_ns >= self.duration_ns

    def _serve(self, now_ns: int) -> None:
        """Take what has arrived, then advance the vehicle and send what it says."""
        link = self.link
        if link.wants_write:
            link.flush(now_ns)
        data = link.receive(now_ns)
        if link.epoch != self.epoch:
            self.epoch = link.epoch
            self.vehicle.framer.reset()
        until_ns = min(self._simulated(now_ns), self.simulated_ns + SLICE_NS)
        if self.duration_ns is not None:
            until_ns = min(until_ns, self.duration_ns)
        if data:
            self.vehicle.handle(data, until_ns)
        for frame in self.vehicle.frames_until(until_ns):
            link.send(frame, now_ns)
        self.simulated_ns = until_ns

    def _simulated(self, now_ns: int) -> int:
        return round((now_ns - self.start_ns) * self.speed)

    def _wait_s(self, now_ns: int) -> float:
        """Until the vehicle, the link or the end wants attention."""
        due_ns = self.vehicle.next_deadline_ns
        if self.duration_ns is not None:
            due_ns = min(due_ns, self.duration_ns)
        wait_ns = self.start_ns + due_ns / self.speed - now_ns
        if self.link.next_deadline_ns is not None:
            wait_ns = min(wait_ns, self.link.next_deadline_ns - now_ns)
        return min(max(wait_ns * 1e-9, 0.0), LONGEST_WAIT_S)

    def _watch(self, selector: selectors.DefaultSelector) -> None:
        """Keep the selector's idea of the link up to date: descriptors come and go."""
        events = selectors.EVENT_READ | (selectors.EVENT_WRITE if self.link.wants_write else 0)
        fd = self.link.fd
        if fd != self.watched:
            if self.watched is not None:
                selector.unregister(self.watched)
            if fd is not None:
                selector.register(fd, events)
            self.watched = fd
        elif fd is not None and selector.get_key(fd).events != events:
            selector.modify(fd, events)

"""Disturbances of the line: losses, copies, delays, disorder, damage, and clocks."""

from collections.abc import Callable, Iterable
from math import inf
from typing import Final

from attest_mav.evaluation.disturbed_flights.frames import message_id, shifted, with_sender
from attest_mav.evaluation.disturbed_flights.row import Delivery, Filter, Meddle, Tools

INERTIAL: Final = ("RAW_IMU", "SCALED_IMU", "SCALED_IMU2", "HIGHRES_IMU")

MeddleMaker = Callable[[Tools], Meddle]


def lossy(share: float) -> MeddleMaker:
    """This share of the frames is lost."""

    def make(tools: Tools) -> Meddle:
        return lambda _t_s, frames: [(0.0, frame) for frame in frames if tools.rng.random() >= share]

    return make


def without(*names: str) -> MeddleMaker:
    """These messages are lost."""

    def make(tools: Tools) -> Meddle:
        ids = tools.ids(*names)
        return lambda _t_s, frames: [(0.0, frame) for frame in frames if message_id(frame) not in ids]

    return make


def copied(delays_s: tuple[float, ...]) -> MeddleMaker:
    """Every frame comes once after each of these delays."""
    return lambda _tools: lambda _t_s, frames: [(delay_s, frame) for frame in frames for delay_s in delays_s]


def delayed(delay_s: Callable[[float], float]) -> MeddleMaker:
    """All is late by a function of the time since the beginning."""

    def make(_tools: Tools) -> Meddle:
        began_s = inf

        def meddle(t_s: float, frames: list[bytes]) -> list[Delivery]:
            nonlocal began_s
            began_s = min(began_s, t_s)
            return [(delay_s(t_s - began_s), frame) for frame in frames]

        return meddle

    return make


def disordered(spread_s: float) -> MeddleMaker:
    """Each frame is late by a random time up to this."""

    def make(tools: Tools) -> Meddle:
        return lambda _t_s, frames: [(spread_s * tools.rng.random(), frame) for frame in frames]

    return make


def damaged(share: float) -> MeddleMaker:
    """One bit of this share of the bytes is wrong."""

    def damage(tools: Tools, frame: bytes) -> bytes:
        rng = tools.rng
        return bytes(byte ^ (1 << rng.randrange(8)) if rng.random() < share else byte for byte in frame)

    return lambda tools: lambda _t_s, frames: [(0.0, damage(tools, frame)) for frame in frames]


def amid_garbage(size: int) -> MeddleMaker:
    """Before each frame come random bytes, up to so many."""

    def make(tools: Tools) -> Meddle:
        rng = tools.rng
        return lambda _t_s, frames: [(0.0, rng.randbytes(rng.randrange(size)) + frame) for frame in frames]

    return make


def repeated(stretch_s: float, period_s: float, skipped: int) -> MeddleMaker:
    """The last stretch comes again each period; with other sequence numbers where ``skipped`` is not 0."""

    def make(tools: Tools) -> Meddle:
        past: list[tuple[float, bytes]] = []
        due_s = [0.0]

        def meddle(t_s: float, frames: list[bytes]) -> Iterable[Delivery]:
            past.extend((t_s, frame) for frame in frames)
            past[:] = [one for one in past if one[0] > t_s - stretch_s]
            again: list[bytes] = []
            if t_s >= due_s[0]:
                due_s[0] = t_s + period_s
                again = [with_sender(tools.dialect, frame, frame[5], skipped) for _, frame in past]
            return [(0.0, frame) for frame in [*frames, *again]]

        return meddle

    return make


def clock_set(shift_ms: int) -> MeddleMaker:
    """The vehicle's clock is off by this."""

    def make(tools: Tools) -> Meddle:
        return lambda _t_s, frames: [(0.0, shifted(tools.dialect, frame, shift_ms)) for frame in frames]

    return make


def renamed(system: int) -> MeddleMaker:
    """The vehicle uses another system id."""

    def make(tools: Tools) -> Meddle:
        return lambda _t_s, frames: [(0.0, with_sender(tools.dialect, frame, system)) for frame in frames]

    return make


def deaf_to(*names: str) -> Callable[[Tools], Filter]:
    """The vehicle does not get these messages of ours; without a name, none at all."""

    def make(tools: Tools) -> Filter:
        ids = tools.ids(*names)
        return lambda _t_s, frame: bool(ids) and message_id(frame) not in ids

    return make

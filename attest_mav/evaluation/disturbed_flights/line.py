"""The line of a disturbed flight."""

from collections.abc import Iterable
from typing import Final

from attest_mav.evaluation.disturbed_flights.frames import message_id
from attest_mav.evaluation.disturbed_flights.row import Disturbance, Filter, Meddle, Tools


def _as_it_is(_t_s: float, frames: list[bytes]) -> Iterable[tuple[float, bytes]]:
    return [(0.0, frame) for frame in frames]


def _all(_t_s: float, _frame: bytes) -> bool:
    return True


class DisturbedLine:
    """A ``Line`` that is disturbed in the time of a row."""

    def __init__(self, row: Disturbance, tools: Tools) -> None:
        self._row: Final = row
        self._meddle: Final[Meddle] = _as_it_is if row.meddle is None else row.meddle(tools)
        self._hears: Final[Filter] = _all if row.hears is None else row.hears(tools)
        self._last_ns = 0
        self.reports: Final[list[bytes]] = []
        """The attitudes that the autopilot has sent, until somebody takes them."""
        self._report: Final = tools.dialect.id_of("ATTITUDE")

    def deliver(self, now_ns: int, frames: list[bytes]) -> Iterable[tuple[int, bytes]]:
        """See ``Line``."""
        t_s = now_ns * 1e-9
        self.reports.extend(frame for frame in frames if message_id(frame) == self._report)
        meddle = self._meddle if self._is_disturbed(t_s) else _as_it_is
        for delay_s, frame in meddle(t_s, frames):
            arrival_ns = now_ns + round(delay_s * 1e9)
            if self._row.in_order:
                arrival_ns = self._last_ns = max(arrival_ns, self._last_ns)
            yield arrival_ns, frame

    def passes(self, now_ns: int, frame: bytes) -> bool:
        """See ``Line``."""
        t_s = now_ns * 1e-9
        return not self._is_disturbed(t_s) or self._hears(t_s, frame)

    def _is_disturbed(self, t_s: float) -> bool:
        return self._row.begin_s <= t_s < self._row.end_s

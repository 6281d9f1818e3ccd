"""An open request for one setting of the autopilot, and the rule by which an answer counts.

PARAM_VALUE carries no proof of its sender. The first answer to a request of ours counts where nothing is known yet. A
value that differs from the known one counts when two requests in a row were answered alike with it, so a single frame
that nobody asked for changes nothing, and two senders that contradict each other change nothing either.
"""

from enum import IntEnum
from math import isnan
from typing import Final

from attest_mav.vehicle_settings import Setting

FIRST_PAUSE_NS: Final = 1_000_000_000
"""Pause after the first request; it doubles after each one."""
MAX_TRIES: Final = 6
"""Requests at 0, 1, 3, 7, 15 and 31 s; given up at 63 s. The early ones may be lost while the autopilot boots or a
ground station downloads all parameters."""
CONFIRM_NS: Final = 300_000_000
"""A changed value is requested once more after this time."""


class Answer(IntEnum):
    """What an answer to a request means."""

    COUNTS = 0
    """The setting has this value."""
    UNPROVEN = 1
    """The value is a new one: it is requested once more."""
    REFUTED = 2
    """The autopilot confirms the known value: another one that came was not the autopilot's."""
    CONTRADICTED = 3
    """Two answers differ: there are two senders."""


class ParameterRequest:
    """An open request for one setting: the names under which autopilots have it, tried in turn.

    is_doubt: the request asks again because a value came that nobody had requested.
    """

    def __init__(self, setting: Setting, names: list[str], now_ns: int, is_doubt: bool = False) -> None:
        self.setting: Final = setting
        self.names: Final = names
        self.is_doubt: Final = is_doubt
        self.tries = 0
        self.due_ns = now_ns
        self._first: float | None = None

    def next_name(self, now_ns: int) -> str:
        """The name to request now; the next request follows after the doubled pause."""
        name = self.names[self.tries % len(self.names)]
        self.due_ns = now_ns + (FIRST_PAUSE_NS << self.tries)
        self.tries += 1
        return name

    def judge(self, value: float, known: float | None, now_ns: int) -> Answer:
        """What this answer means. known: the value that counts so far, None for none."""
        first = self._first
        if first is not None:
            return Answer.COUNTS if same(value, first) else Answer.CONTRADICTED
        if known is None:
            return Answer.COUNTS
        if same(value, known):
            return Answer.REFUTED if self.is_doubt else Answer.COUNTS
        self._first = value
        self.due_ns = now_ns + CONFIRM_NS
        self.tries = min(self.tries, MAX_TRIES - 1)
        return Answer.UNPROVEN


def same(one: float, other: float) -> bool:
    """Whether two values of a setting are equal; NaN, the autopilot's own default, equals itself."""
    return one == other or (isnan(one) and isnan(other))

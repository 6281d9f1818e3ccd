"""TIMESYNC: questions for the autopilot's time with their answers, and answers to the questions of others.

A question carries our clock in ts1 and zero in tc1; the answer repeats ts1 and has the other clock in tc1. An answer
counts for the one question whose ts1 it repeats: ArduPilot sends its answers to everybody, without a target. The two
bytes of the target are an extension of the message, which dialects older than that have not.
"""

from collections import deque
from typing import Final

from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import Frame
from attest_mav.vehicle_reports import TimeExchange

FIRST_EXCHANGES: Final = 8
FIRST_PERIOD_NS: Final = 250_000_000
"""At first, and after the clock was set, so many questions are asked at this period."""
PERIOD_NS: Final = 5_000_000_000
HURRY_NS: Final = 200_000_000
"""Where samples seem late the next question is asked this long after the last one."""
OPEN_QUESTIONS: Final = 64
"""Questions whose answers are waited for; the oldest is given up."""
UNANSWERED: Final = 10
"""After so many questions without any answer the autopilot is taken not to answer."""

ANSWERS_PER_S: Final = 20
"""Most answers to others on one link in a second."""
TARGET_AT: Final = 16
"""Where the target's system and component stand in the payload."""


class TimeQuestion:
    """TIMESYNC with tc1 zero, of another component. system, component: who is asked, 0 for everybody."""

    def __init__(self, ts1_ns: int, payload: bytes) -> None:
        target = payload[TARGET_AT : TARGET_AT + 2].ljust(2, b"\0")
        self.ts1_ns: Final = ts1_ns
        self.system: Final[int] = target[0]
        self.component: Final[int] = target[1]

    def is_for(self, system: int, component: int) -> bool:
        """Whether the component with these ids is asked, alone or with others."""
        return self.system in (0, system) and self.component in (0, component)

    @property
    def is_for_all(self) -> bool:
        """Whether several components are asked."""
        return self.system == 0 or self.component == 0


class AnswerLimit:
    """Counts the answers on one link: not more than ``ANSWERS_PER_S`` in any second that it begins."""

    def __init__(self) -> None:
        self._began_ns = 0
        self._count = 0

    def allows(self, now_ns: int) -> bool:
        """Whether one more may be sent now; it is counted."""
        if now_ns - self._began_ns >= 1_000_000_000:
            self._began_ns, self._count = now_ns, 0
        self._count += 1
        return self._count <= ANSWERS_PER_S


class TimeSync:
    """The questions for one vehicle's time. asks: False asks nothing. It does not send: ``poll`` says when to."""

    def __init__(self, dialect: Dialect, asks: bool, notebook: Notebook) -> None:
        self.answers = 0
        """Answers of the autopilot so far."""
        self._fields: Final = dialect.layout("TIMESYNC").pick("tc1", "ts1")
        self._asks: Final = asks
        self._notebook: Final = notebook
        self._open: deque[int] = deque(maxlen=OPEN_QUESTIONS)
        self._exchanges: list[TimeExchange] = []
        self._fast = 0
        self._unanswered = 0
        self._asked_ns = 0
        self._due_ns = 0

    def begin(self, now_ns: int) -> None:
        """A vehicle was found, found again, or has set its clock: ask it a few times soon."""
        self._fast = FIRST_EXCHANGES
        self._due_ns = now_ns

    def forget(self) -> None:
        """Drop the questions: the vehicle is another one, or there is none."""
        self._open.clear()
        self._exchanges.clear()
        self.answers = self._unanswered = 0

    def hurry(self) -> None:
        """The samples seem late: ask soon."""
        self._due_ns = min(self._due_ns, self._asked_ns + HURRY_NS)

    def poll(self, now_ns: int) -> bool:
        """Whether a question is to be sent now, with ``now_ns`` as its ts1."""
        if not self._asks or now_ns < self._due_ns:
            return False
        self._fast = max(0, self._fast - 1)
        self._asked_ns = now_ns
        self._due_ns = now_ns + (FIRST_PERIOD_NS if self._fast else PERIOD_NS)
        self._open.append(now_ns)
        self._unanswered += 1
        if self._unanswered == UNANSWERED and not self.answers:
            self._notebook.info(
                "TIMESYNC is not answered: delays of samples are known only as far as they grow or shrink"
            )
        return True

    @property
    def next_deadline_ns(self) -> int | None:
        """When ``poll`` is due; None for never."""
        return self._due_ns if self._asks else None

    def question(self, frame: Frame) -> TimeQuestion | None:
        """The question in a frame, None for an answer."""
        tc1_ns, ts1_ns = self._fields.unpack(frame.payload)
        return TimeQuestion(ts1_ns, frame.payload) if tc1_ns == 0 else None

    def answered(self, frame: Frame, now_ns: int) -> None:
        """Take an answer of the autopilot; one that repeats none of our open questions is another's."""
        tc1_ns, ts1_ns = self._fields.unpack(frame.payload)
        if ts1_ns not in self._open:
            return
        self._open.remove(ts1_ns)
        self.answers += 1
        self._exchanges.append(TimeExchange(ts1_ns, tc1_ns, now_ns))

    def take(self) -> list[TimeExchange]:
        """The exchanges since the last call, oldest first."""
        exchanges = self._exchanges
        if exchanges:
            self._exchanges = []
        return exchanges

"""One row of the table: what happens, and what must hold then."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from math import inf
from random import Random
from typing import Final

from attest_mav.estimation.events import Agreement
from attest_mav.mavlink.component.encoder import Encoder
from attest_mav.mavlink.dialect import Dialect
from attest_mav.sim.autopilot import FakeAutopilot

BEGIN_S: Final = 15.0
"""When a disturbance begins: the service is settled by then, s."""

SYSTEM: Final = 1
"""System id of the fake autopilot."""

AGREE: Final = frozenset({Agreement.AGREE})
DOUBT: Final = AGREE | {Agreement.UNDECIDED}
ACCUSE: Final = DOUBT | {Agreement.DISAGREE}


class Tools:
    """The things that a disturbance works with; each flight has its own."""

    def __init__(self, dialect: Dialect, vehicle: FakeAutopilot, rng: Random) -> None:
        self.dialect: Final = dialect
        self.vehicle: Final = vehicle
        self.rng: Final = rng

    def forger(self, system: int = SYSTEM, component: int = 1) -> Encoder:
        """A sender under these ids, with sequence numbers of its own."""
        return Encoder(self.dialect, system, component)

    def ids(self, *names: str) -> frozenset[int]:
        """The ids of these messages."""
        return frozenset(self.dialect.id_of(name) for name in names)


Delivery = tuple[float, bytes]
"""Delay on the line, s, and a frame."""

Meddle = Callable[[float, list[bytes]], Iterable[Delivery]]
"""The deliveries in place of the frames that the vehicle sends now. The time is that of the flight, s."""

Filter = Callable[[float, bytes], bool]
"""Whether a frame of ours reaches the vehicle at this time of the flight, s."""


@dataclass(frozen=True)
class Disturbance:
    """One row. While it lasts only these verdicts may stand, and what is published must be fresh and near the truth."""

    name: str
    """The thing that happens, in words."""
    meddle: Callable[[Tools], Meddle] | None = None
    """Makes the disturbance of the line towards us."""
    hears: Callable[[Tools], Filter] | None = None
    """Makes the disturbance of the line towards the vehicle."""
    faults: tuple[str, ...] = ()
    """Faults on board, with their times; see ``fault_text``."""
    scenario: str = "square"
    personality: str = "ardupilot"
    begin_s: float = BEGIN_S
    lasts_s: float = 10.0
    after_s: float = 12.0
    """Time flown after the end, s."""
    in_order: bool = False
    """Frames do not overtake each other on the line."""
    clock_shifts_ms: tuple[int, ...] = (0,)
    """By so much the stamps that we get may differ from the vehicle's clock, ms."""
    sign: str = ""
    """Regular expression: a line of the log or the status that names the disturbance; "" for one that needs none."""
    detected_s: float = 2.0
    """Bound of the time until the sign, s."""
    recovered_s: float = 1.0
    """Bound of the time from the end until AGREE stands and attitudes are sent, to stay so, s."""
    verdicts: frozenset[Agreement] = AGREE
    """The verdicts that may stand from the beginning to the recovery."""
    tilt_deg: float = 1.5
    """Bound of the true tilt error of what is published, degrees."""
    sent_hz: float = inf
    """Bound of the attitudes sent while it lasts, Hz; finite where none may be."""
    accused_s: float = inf
    """Bound of the time until DISAGREE, s; infinite where nobody need be accused."""

    @property
    def end_s(self) -> float:
        """When it ends, s."""
        return self.begin_s + self.lasts_s

"""Long flights of the whole service beside a healthy fake autopilot: nobody may be accused, and doubt must be rare."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import degrees, isfinite
from typing import Final

from attest_mav.algebra import tilt_between
from attest_mav.config.parsing import parse_config
from attest_mav.errors import UsageError
from attest_mav.estimation.events import Agreement
from attest_mav.evaluation.harness import TrialMap
from attest_mav.evaluation.service_flight import PlainLine, ServiceFlight
from attest_mav.mavlink.dialect import Dialect, load_dialect
from attest_mav.service.service import Service
from attest_mav.sim.autopilot import FakeAutopilot
from attest_mav.sim.personality import PERSONALITIES
from attest_mav.sim.scenarios import SCENARIOS
from attest_mav.sim.settings import SimSettings

SETTLED_S: Final = 30.0
"""The first seconds are no part of the figures: alignment and first contact."""
LOOK_NS: Final = 100_000_000
"""The verdict is looked at so often."""
LARGEST_UNDECIDED: Final = 0.02
"""Share of the time after settling."""


@dataclass(frozen=True)
class CleanFlight:
    """One flight to be flown."""

    scenario: str
    """One of the simulator's."""
    personality: str
    """``ardupilot`` or ``px4``."""
    seed: int
    """Of the simulator's noise."""
    seconds: float
    """Length, settling included, s."""


@dataclass(frozen=True)
class CleanFigures:
    """What came of flights of one scenario and personality."""

    name: str
    """Personality and scenario."""
    flown_s: float
    """Time after settling, s."""
    disagree_s: float
    """Time with the verdict DISAGREE, s."""
    undecided_s: float
    """Time with the verdict UNDECIDED or without one, s."""
    silent_s: float
    """Time without an ATTITUDE_QUATERNION in the last half second, s."""
    worst_tilt_deg: float
    """Largest true tilt error of what was sent, degrees."""

    @property
    def meets(self) -> bool:
        """Whether nobody was accused, and doubt was rare."""
        return self.disagree_s == 0.0 and self.undecided_s <= LARGEST_UNDECIDED * self.flown_s


class _Watch:
    """Looks at one flight while it is flown."""

    def __init__(self, dialect: Dialect, vehicle: FakeAutopilot) -> None:
        self.counts = dict.fromkeys(Agreement, 0)
        self.silent = 0
        self.worst_tilt = 0.0
        self._vehicle: Final = vehicle
        self._id: Final = dialect.id_of("ATTITUDE_QUATERNION")
        self._fields: Final = dialect.layout("ATTITUDE_QUATERNION").pick("time_boot_ms", "q1", "q2", "q3", "q4")
        self._sent_ns = 0

    def sent(self, frames: Iterable[bytes], now_ns: int) -> None:
        """Take what the service sent."""
        for frame in frames:
            if int.from_bytes(frame[7:10], "little") != self._id:
                continue
            self._sent_ns = now_ns
            boot_ms, w, x, y, z = self._fields.unpack(frame[10:-2])
            if now_ns > SETTLED_S * 1e9:
                truth = self._vehicle.truth(boot_ms * 1_000_000).q_nb
                self.worst_tilt = max(self.worst_tilt, tilt_between(truth, (w, x, y, z)))

    def look(self, service: Service, now_ns: int) -> None:
        """Count the verdict of this instant."""
        if now_ns <= SETTLED_S * 1e9:
            return
        verdict = service.snapshot(now_ns).verdict
        self.counts[Agreement.UNDECIDED if verdict is None else verdict.verdict.agreement] += 1
        self.silent += now_ns - self._sent_ns > 500_000_000


def fly(flight: CleanFlight) -> CleanFigures:
    """Fly one on virtual time."""
    settings = SimSettings(scenario=flight.scenario, personality=flight.personality, fast_rate_hz=50.0)
    dialect = load_dialect()
    vehicle = FakeAutopilot(settings, flight.seed, dialect)
    config = parse_config('[[link]]\nurl = "udpin::0"\n', "clean flight")
    flown = ServiceFlight(vehicle, config, dialect, PlainLine())
    watch = _Watch(dialect, vehicle)
    look_ns, end_ns = 0, round(flight.seconds * 1e9)
    while flown.now_ns < end_ns:
        watch.sent(flown.advance(look_ns), flown.now_ns)
        flown.service.take_notes()
        if flown.now_ns >= look_ns:
            look_ns = flown.now_ns + LOOK_NS
            watch.look(flown.service, flown.now_ns)
    step_s = LOOK_NS * 1e-9
    looks = sum(watch.counts.values())
    name = f"{flight.personality} {flight.scenario}"
    disagree, undecided = watch.counts[Agreement.DISAGREE], watch.counts[Agreement.UNDECIDED]
    worst_deg = degrees(watch.worst_tilt)
    return CleanFigures(name, looks * step_s, disagree * step_s, undecided * step_s, watch.silent * step_s, worst_deg)


def flights(hours: float, seconds: float, seed: int) -> list[CleanFlight]:
    """All scenarios and personalities, one after another, until that many hours are full.

    Raises UsageError for no time at all, and for flights that end before their figures begin.
    """
    if not (isfinite(hours) and hours > 0.0):
        raise UsageError(f"{hours:g} hours: expected a positive number")
    if not (isfinite(seconds) and seconds > SETTLED_S):
        raise UsageError(
            f"{seconds:g} s a flight: expected more than {SETTLED_S:g} s, which are no part of the figures"
        )
    kinds = [(scenario, personality) for scenario in SCENARIOS for personality in PERSONALITIES]
    count = max(1, round(hours * 3600.0 / seconds))
    return [CleanFlight(*kinds[place % len(kinds)], seed + place // len(kinds), seconds) for place in range(count)]


def run_all(chosen: list[CleanFlight], trial_map: TrialMap) -> Iterator[CleanFigures]:
    """The figures of all flights, in order."""
    return trial_map(fly, chosen)


def summary(figures: Iterable[CleanFigures]) -> list[CleanFigures]:
    """The figures by scenario and personality: sums, and the largest error."""
    totals: dict[str, CleanFigures] = {}
    for one in figures:
        before = totals.get(one.name, CleanFigures(one.name, 0.0, 0.0, 0.0, 0.0, 0.0))
        totals[one.name] = CleanFigures(
            one.name,
            before.flown_s + one.flown_s,
            before.disagree_s + one.disagree_s,
            before.undecided_s + one.undecided_s,
            before.silent_s + one.silent_s,
            max(before.worst_tilt_deg, one.worst_tilt_deg),
        )
    return list(totals.values())

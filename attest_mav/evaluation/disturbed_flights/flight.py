"""One disturbed flight, watched: what stood in the status, what was sent, and when both were good again."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from math import degrees, hypot, inf, radians
from typing import Final

from attest_mav.algebra import q_from_euler, tilt_between
from attest_mav.config.parsing import parse_config
from attest_mav.estimation.events import Agreement
from attest_mav.evaluation.disturbed_flights.line import DisturbedLine
from attest_mav.evaluation.disturbed_flights.row import Disturbance, Tools
from attest_mav.evaluation.service_flight import ServiceFlight
from attest_mav.mavlink.component.outputs import boot_ms
from attest_mav.mavlink.constants import MAV_STATE_ACTIVE
from attest_mav.mavlink.dialect import Dialect, load_dialect
from attest_mav.service.status import status_line
from attest_mav.sim.autopilot import FakeAutopilot
from attest_mav.sim.draws import generator
from attest_mav.sim.fault_text import parse_faults
from attest_mav.sim.settings import SimSettings

LOOK_NS: Final = 100_000_000
"""Period at which the status is looked at, ns."""
LOOK_DIGITS: Final = 3
"""Decimals of a second to which the time of a look is known: the flight's clock goes on by 0.1 ms at least."""
FRESH_S: Final = 0.5
"""The default of ``estimate.stale_s``: nothing older is published, s."""
ROUNDING_S: Final = 0.021
"""An age is not known better: by the cut of time_boot_ms to milliseconds, and half of the shortest round trip, s."""
LARGEST_SIGMA: Final = radians(3.0)
"""The default of ``output.max_sigma_deg``: nothing less certain is published, rad."""
UNIT: Final = 1e-6
"""A quaternion in single precision has the length 1 as closely as this."""
LINES_A_MINUTE: Final = 60
"""Bound of the lines of the log."""


@dataclass(frozen=True)
class Look:
    """The status at one instant."""

    t_s: float
    agreement: Agreement
    reason: str
    is_good: bool
    """AGREE stands, the heartbeat is ACTIVE, and an attitude was sent within ``FRESH_S``."""


@dataclass(frozen=True)
class Outcome:
    """The figures of one row."""

    detected_s: float
    """Time from the beginning to the sign, s; infinite without."""
    accused_s: float
    """The same to DISAGREE."""
    recovered_s: float
    """Time from the end to the state that stays good, s; infinite without."""
    verdicts: tuple[tuple[Agreement, str], ...]
    """Verdicts with their reasons from the beginning to the recovery, each once, in order."""
    sent_hz: float
    """Attitudes sent while it lasted, Hz."""
    oldest_s: float
    """Largest age of an attitude when it was sent, by the vehicle's clock, s."""
    worst_tilt_deg: float
    """Largest true tilt error of an attitude sent from the beginning on, degrees."""
    autopilot_tilt_deg: float
    """The same of the attitudes that the autopilot sent before it was accused, or at all."""
    lines: int
    """Lines of the log from the beginning on."""
    unsound: int = 0
    """Attitudes sent from the beginning on that are no unit quaternion, or that we did not believe ourselves."""


class Watch:
    """Looks at one flight."""

    def __init__(self, row: Disturbance, flown: ServiceFlight, line: DisturbedLine, dialect: Dialect) -> None:
        self._row: Final = row
        self._line: Final = line
        self._report: Final = dialect.layout("ATTITUDE").pick("time_boot_ms", "roll", "pitch", "yaw")
        self._autopilot_tilt = 0.0
        self._accused = False
        self._flown: Final = flown
        self._sign: Final = re.compile(row.sign or r"(?!)")
        self._id: Final = dialect.id_of("ATTITUDE_QUATERNION")
        self._fields: Final = dialect.layout("ATTITUDE_QUATERNION").pick("time_boot_ms", "q1", "q2", "q3", "q4")
        self._looks: Final[list[Look]] = []
        self._detected_s = inf
        self._sent_s = -inf
        self._sent = 0
        self._oldest_s = self._worst_tilt = 0.0
        self._unsound = 0
        self._lines = 0
        self._before = flown.service.snapshot(0)

    def sent(self, frames: Iterable[bytes]) -> None:
        """Take what the service sent."""
        now_s = self._flown.now_ns * 1e-9
        for frame in frames:
            if int.from_bytes(frame[7:10], "little") == self._id:
                self._sent_s = now_s
                self._sent += self._row.begin_s <= now_s < self._row.end_s
                self._check(frame, now_s)

    def _check(self, frame: bytes, now_s: float) -> None:
        """Age and error by the shift of the clock that fits best."""
        sent_ms, *q_nb = self._fields.unpack(frame[10:-2])
        vehicle = self._flown.vehicle
        times_s = [(sent_ms - one) % 2**32 * 1e-3 + vehicle.boot_ns * 1e-9 for one in self._row.clock_shifts_ms]
        time_s = min(times_s, key=lambda one: abs(now_s - one))
        self._oldest_s = max(self._oldest_s, now_s - time_s)
        if now_s >= self._row.begin_s:
            w, x, y, z = q_nb
            ours = self._flown.service.estimate
            is_this_one = ours is not None and boot_ms(ours.t_ns) == sent_ms  # no newer one since
            doubted = ours is not None and is_this_one and ours.tilt_sigma > LARGEST_SIGMA
            self._unsound += doubted or not abs(hypot(w, x, y, z) - 1.0) < UNIT
            truth = vehicle.truth(round(time_s * 1e9)).q_nb
            self._worst_tilt = max(self._worst_tilt, tilt_between(truth, (w, x, y, z)))

    def _take_reports(self) -> None:
        """Take what the autopilot says of its attitude, until it is accused."""
        vehicle = self._flown.vehicle
        for frame in self._line.reports:
            report_ms, roll, pitch, yaw = self._report.unpack(frame[10:-2])
            if self._flown.now_ns >= self._row.begin_s * 1e9 and not self._accused:
                truth = vehicle.truth(report_ms * 1_000_000 + vehicle.boot_ns).q_nb
                self._autopilot_tilt = max(self._autopilot_tilt, tilt_between(truth, q_from_euler(roll, pitch, yaw)))
        self._line.reports.clear()

    def look(self) -> None:
        """Look at the status and the log."""
        self._take_reports()
        service, now_ns = self._flown.service, self._flown.now_ns
        now_s = now_ns * 1e-9
        texts = [note.text for note in service.take_notes()]
        seen = service.snapshot(now_ns)
        if now_s >= self._row.begin_s:
            self._lines += len(texts)
            texts.append(status_line(seen, self._before))
            if self._detected_s == inf and any(map(self._sign.search, texts)):
                self._detected_s = now_s - self._row.begin_s
            standing = seen.verdict
            agreement = Agreement.UNDECIDED if standing is None else standing.verdict.agreement
            self._accused = self._accused or agreement is Agreement.DISAGREE
            is_good = agreement is Agreement.AGREE and seen.state == MAV_STATE_ACTIVE and now_s - self._sent_s < FRESH_S
            self._looks.append(Look(now_s, agreement, "" if standing is None else standing.verdict.reason, is_good))
        self._before = seen

    def outcome(self) -> Outcome:
        """The figures, at the end of the flight."""
        row, looks = self._row, self._looks
        bad_s = [look.t_s for look in looks if not look.is_good]
        good_s = max(bad_s[-1] + LOOK_NS * 1e-9 if bad_s else row.begin_s, row.end_s)
        accused = [look.t_s for look in looks if look.agreement is Agreement.DISAGREE]
        kinds = [(look.agreement, look.reason) for look in looks if look.t_s < good_s]
        return Outcome(
            detected_s=self._detected_s,
            accused_s=accused[0] - row.begin_s if accused else inf,
            recovered_s=inf if good_s > looks[-1].t_s else round(good_s - row.end_s, LOOK_DIGITS),
            verdicts=tuple(dict.fromkeys(kinds)),
            sent_hz=self._sent / row.lasts_s,
            oldest_s=self._oldest_s,
            worst_tilt_deg=degrees(self._worst_tilt),
            autopilot_tilt_deg=degrees(self._autopilot_tilt),
            lines=self._lines,
            unsound=self._unsound,
        )


def fly(row: Disturbance, seed: int = 1) -> Outcome:
    """Fly one row on virtual time."""
    dialect = load_dialect()
    settings = SimSettings(
        scenario=row.scenario, personality=row.personality, fast_rate_hz=50.0, faults=parse_faults(row.faults)
    )
    vehicle = FakeAutopilot(settings, seed, dialect)
    line = DisturbedLine(row, Tools(dialect, vehicle, generator(row.name, str(seed))))
    flown = ServiceFlight(vehicle, parse_config('[[link]]\nurl = "udpin::0"\n', row.name), dialect, line)
    watch = Watch(row, flown, line, dialect)
    look_ns, end_ns = 0, round((row.end_s + row.after_s) * 1e9)
    while flown.now_ns < end_ns:
        watch.sent(flown.advance(look_ns))
        if flown.now_ns >= look_ns:
            look_ns = flown.now_ns + LOOK_NS
            watch.look()
    return watch.outcome()


def misses(row: Disturbance, found: Outcome) -> list[str]:
    """The bounds of a row that were missed, in words."""
    figures = (
        ("detected", found.detected_s, row.detected_s if row.sign else inf, "s"),
        ("accused", found.accused_s, row.accused_s, "s"),
        ("recovered", found.recovered_s, row.recovered_s, "s"),
        ("sent", found.sent_hz, row.sent_hz, "Hz"),
        ("oldest sent", found.oldest_s, FRESH_S + ROUNDING_S, "s"),
        ("tilt error sent", found.worst_tilt_deg, row.tilt_deg, "deg"),
        ("unsound attitudes sent", float(found.unsound), 0.0, ""),
        ("lines a minute", 60.0 * found.lines / (row.lasts_s + row.after_s), LINES_A_MINUTE, ""),
    )
    missed = [f"{name} {value:.2f} {unit}, limit {limit:g}" for name, value, limit, unit in figures if value > limit]
    wrong = [f"{agreement.name} ({reason})" for agreement, reason in found.verdicts if agreement not in row.verdicts]
    return missed + [f"verdict {text}" for text in sorted(wrong)]

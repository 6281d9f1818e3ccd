"""Rows of the table at random, one after another in one flight: none may leave anything behind that spoils the next."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import replace
from math import isfinite
from random import Random
from typing import Final

from attest_mav.config.parsing import parse_config
from attest_mav.evaluation.disturbed_flights.flight import LOOK_NS, Outcome, Watch
from attest_mav.evaluation.disturbed_flights.line import DisturbedLine
from attest_mav.evaluation.disturbed_flights.row import BEGIN_S, DOUBT, Disturbance, Tools
from attest_mav.evaluation.service_flight import ServiceFlight
from attest_mav.mavlink.dialect import load_dialect
from attest_mav.sim.autopilot import FakeAutopilot
from attest_mav.sim.draws import generator
from attest_mav.sim.fault_text import parse_faults
from attest_mav.sim.settings import SimSettings

PAUSE_S: Final = (0.0, 10.0)
"""Between the end of what is flown for one row and the beginning of the next, s."""
REBOOT: Final = "reboot"
"""Forgers of later rows would have to learn of it: they send times since the first start."""
_START: Final = re.compile(r"@[0-9.]+")


def movable(row: Disturbance) -> bool:
    """Whether a row can stand anywhere in a flight round the square."""
    is_usual = (row.scenario, row.personality, row.begin_s) == ("square", "ardupilot", BEGIN_S)
    return is_usual and isfinite(row.recovered_s) and not any(one.startswith(REBOOT) for one in row.faults)


def moved(row: Disturbance, begin_s: float) -> Disturbance:
    """The same row at another time, with the bounds that hold anywhere in a flight and for every seed.

    A row's own bounds are those of one draw of noise, at one corner of the square. Here doubt may come at any time, as
    it does in two percent of a flight without disturbance; all must be well before the next row begins; and the tilt
    may err by twice the bound. Accusations, signs, ages and soundness are held to as they are.
    """
    return replace(
        row,
        begin_s=begin_s,
        faults=tuple(_START.sub(f"@{begin_s:.3f}", one) for one in row.faults),
        verdicts=row.verdicts | DOUBT,
        recovered_s=row.after_s,
        tilt_deg=2.0 * row.tilt_deg,
    )


def plan(rows: Iterable[Disturbance], count: int, seed: int) -> list[Disturbance]:
    """So many of the rows, drawn anew after all were flown, at times of the flight."""
    rng = Random(seed)  # noqa: S311  (not for secrets)
    choice = [row for row in rows if movable(row)]
    drawn: list[Disturbance] = []
    begin_s = BEGIN_S
    while len(drawn) < count:
        for row in rng.sample(choice, min(len(choice), count - len(drawn))):
            drawn.append(moved(row, round(begin_s, 3)))
            begin_s += row.lasts_s + row.after_s + rng.uniform(*PAUSE_S)
    return drawn


class CampaignLine:
    """The line of the row that is flown."""

    def __init__(self, line: DisturbedLine) -> None:
        self.present = line

    def deliver(self, now_ns: int, frames: list[bytes]) -> Iterable[tuple[int, bytes]]:
        """See ``Line``."""
        return self.present.deliver(now_ns, frames)

    def passes(self, now_ns: int, frame: bytes) -> bool:
        """See ``Line``."""
        return self.present.passes(now_ns, frame)


def fly_all(rows: list[Disturbance], seed: int) -> Iterator[tuple[Disturbance, Outcome]]:
    """Fly rows at their times in one flight on virtual time; each with its outcome."""
    dialect = load_dialect()
    faults = parse_faults(text for row in rows for text in row.faults)
    vehicle = FakeAutopilot(SimSettings(scenario="square", fast_rate_hz=50.0, faults=faults), seed, dialect)
    lines = [DisturbedLine(row, Tools(dialect, vehicle, generator(row.name, str(seed)))) for row in rows]
    line = CampaignLine(lines[0])
    flown = ServiceFlight(vehicle, parse_config('[[link]]\nurl = "udpin::0"\n', "campaign"), dialect, line)
    look_ns = 0
    for row, line.present in zip(rows, lines, strict=True):
        watch = Watch(row, flown, line.present, dialect)
        end_ns = round((row.end_s + row.after_s) * 1e9)
        while flown.now_ns < end_ns:
            watch.sent(flown.advance(look_ns))
            if flown.now_ns >= look_ns:
                look_ns = flown.now_ns + LOOK_NS
                watch.look()
        yield row, watch.outcome()

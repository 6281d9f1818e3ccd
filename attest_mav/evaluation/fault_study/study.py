"""The tasks of a study: a log with its card as it was recorded, or a clean log with one fault put into it."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Final

from attest_mav.errors import UnreadableDataError
from attest_mav.evaluation.fault_study.card import Fault, FaultCard, FaultGroup
from attest_mav.evaluation.fault_study.catalogue import INJECTED, InjectedFault
from attest_mav.evaluation.fault_study.edits import faulted
from attest_mav.evaluation.fault_study.figures import FaultFigures, figures_of
from attest_mav.evaluation.fault_study.flown import between, fly
from attest_mav.evaluation.fault_study.recording import LaneRecording, recorded_lanes
from attest_mav.evaluation.fault_study.stand_in import always_right, misled
from attest_mav.evaluation.flight_study.flights import flying_interval
from attest_mav.evaluation.harness import TrialMap
from attest_mav.filters.registry import default_filter
from attest_mav.samples import ImuSample

LEAD_S: Final = 70.0
"""So much of a clean flight is flown before a fault begins: the filters have learnt their sensors by then."""
TRAIL_S: Final = 26.0
"""And so much after it ends."""
PLACE: Final = 0.45
"""A fault begins at this share of the flying time."""
SETTLED_S: Final = 60.0
"""Figures of a flight without a fault begin here, s after its first sample."""


@dataclass(frozen=True)
class FaultTask:
    """One flight to be flown.

    log: the bytes of the tlog, so that a task can go to any process. card: the faults in it; None for a clean flight.
    injected: the place in ``INJECTED`` of the fault to put into it, None for none. lanes: how many of the inertial
    streams are used, 0 for all.
    """

    log: bytes = field(repr=False)
    card: FaultCard | None = None
    injected: int | None = None
    lanes: int = 0


def tasks_of(log: bytes, card: FaultCard | None, wanted: str, lanes: int) -> list[FaultTask]:
    """All tasks of one log: a recorded card is one; a clean flight is one, and one for each fault with ``wanted``."""
    if card is not None:
        return [FaultTask(log, card, lanes=lanes)]
    named = [place for place, fault in enumerate(INJECTED) if wanted in fault.name]
    return [FaultTask(log, lanes=lanes), *(FaultTask(log, None, place, lanes) for place in named)]


def run_all(tasks: Iterable[FaultTask], wanted: str, trial_map: TrialMap) -> Iterator[FaultFigures]:
    """The figures of all faults whose name has ``wanted``, in order."""
    for found in trial_map(run, tasks):
        yield from (one for one in found if wanted in one.fault.name)


def run(task: FaultTask) -> list[FaultFigures]:
    """Fly a task; the figures of its faults."""
    flight = recorded_lanes(task.log)
    if task.injected is not None:
        return [_run_injected(flight, INJECTED[task.injected], _lanes(flight, task))]
    flown = fly(flight, flight.recording.samples, default_filter("velocity-aided"), _lanes(flight, task))
    if task.card is None:
        first_s = _first_time(flight) + SETTLED_S
        last_s = max(flown.autopilot.t_s, default=first_s)
        if last_s <= first_s:
            raise UnreadableDataError(f"expected a flight of more than {SETTLED_S:g} s with the autopilot's attitude")
        return [figures_of(Fault("no fault", first_s, last_s, FaultGroup.CLEAN), flown, (first_s, last_s), ())]
    card = task.card
    return [figures_of(fault, flown, card.window(place), card.leave_out) for place, fault in enumerate(card.faults)]


def _lanes(flight: LaneRecording, task: FaultTask) -> tuple[str, ...]:
    return flight.lanes[: task.lanes] if task.lanes else flight.lanes


def _run_injected(flight: LaneRecording, injected: InjectedFault, lanes: tuple[str, ...]) -> FaultFigures:
    """Fly the piece of a clean flight around one fault."""
    began_s, ended_s = flying_interval(flight.recording)
    origin_s = _first_time(flight)
    start_s = origin_s + began_s + PLACE * (ended_s - began_s - injected.duration_s - TRAIL_S)
    end_s = start_s + injected.duration_s
    samples = between(flight.recording.samples, start_s - LEAD_S, end_s + TRAIL_S)
    one = default_filter("velocity-aided")
    changed = faulted(samples, start_s, end_s, injected.change(flight.lanes))
    changed = misled(flight, changed, flight.lanes[0], one) if injected.misleads else always_right(flight, changed)
    fault = Fault(injected.name, start_s, end_s, injected.group, _accused(flight, injected))
    return figures_of(fault, fly(flight, changed, one, lanes), FaultCard((fault,)).window(0), ())


def _accused(flight: LaneRecording, injected: InjectedFault) -> tuple[str, ...]:
    return (flight.lanes[0], injected.accused) if injected.accused else ()


def _first_time(flight: LaneRecording) -> float:
    """Time of the first sample of the first stream by the sensors' clock, s."""
    stamps = (
        sample.t_ns * 1e-9
        for sample in flight.recording.samples
        if isinstance(sample, ImuSample) and sample.source == flight.lanes[0]
    )
    return next(stamps, 0.0)

"""The receiver of a flight while it is replayed: whoever draws it over log time."""

from collections.abc import Sequence
from typing import Final, Protocol

from attest_mav.estimate import Estimate
from attest_mav.estimation.events import LaneEvent, Verdict
from attest_mav.replay.comparison import ComparedAttitude, ComparisonSink
from attest_mav.samples import ImuSample, Sample
from attest_mav.types import EarthField, Quat


class FlightObserver(ComparisonSink, Protocol):
    """Sees a flight as it is replayed. ``elapsed_s`` is log time, s; ``name`` is that of a filter."""

    def begin(self, field: EarthField) -> None:
        """The flight begins, in this magnetic field of the Earth."""

    def imu(self, sample: ImuSample, elapsed_s: float) -> None:
        """Take the next inertial sample of a lane."""

    def estimate(self, name: str, estimate: Estimate, sample: ImuSample) -> None:
        """Take the next estimate of the selected lane, beside the inertial sample that ``imu`` took last."""

    def verdict(self, name: str, verdict: Verdict, elapsed_s: float) -> None:
        """Take the next verdict on the autopilot's attitude."""

    def lane_event(self, name: str, event: LaneEvent, elapsed_s: float) -> None:
        """Take the next event of a lane."""

    def reference(self, q_nb: Quat, elapsed_s: float) -> None:
        """Take the next attitude of the reference."""

    def vehicle(self, sample: Sample, elapsed_s: float) -> None:
        """Take the next sample that is neither inertial nor an attitude; it came at this log time."""


class ObserverTee:
    """Shows one flight to several observers."""

    def __init__(self, observers: Sequence[FlightObserver]) -> None:
        self._observers: Final = list(observers)

    def begin(self, field: EarthField) -> None:
        """The flight begins."""
        for one in self._observers:
            one.begin(field)

    def imu(self, sample: ImuSample, elapsed_s: float) -> None:
        """Show it to each of them, as all that follow."""
        for one in self._observers:
            one.imu(sample, elapsed_s)

    def estimate(self, name: str, estimate: Estimate, sample: ImuSample) -> None:
        """Show an estimate."""
        for one in self._observers:
            one.estimate(name, estimate, sample)

    def verdict(self, name: str, verdict: Verdict, elapsed_s: float) -> None:
        """Show a verdict."""
        for one in self._observers:
            one.verdict(name, verdict, elapsed_s)

    def lane_event(self, name: str, event: LaneEvent, elapsed_s: float) -> None:
        """Show an event."""
        for one in self._observers:
            one.lane_event(name, event, elapsed_s)

    def reference(self, q_nb: Quat, elapsed_s: float) -> None:
        """Show an attitude of the reference."""
        for one in self._observers:
            one.reference(q_nb, elapsed_s)

    def vehicle(self, sample: Sample, elapsed_s: float) -> None:
        """Show another sample."""
        for one in self._observers:
            one.vehicle(sample, elapsed_s)

    def write(self, compared: ComparedAttitude) -> None:
        """Show an attitude with its errors."""
        for one in self._observers:
            one.write(compared)


class ComparisonTee:
    """Gives each compared attitude to several receivers."""

    def __init__(self, sinks: Sequence[ComparisonSink]) -> None:
        self._sinks: Final = list(sinks)

    def write(self, compared: ComparedAttitude) -> None:
        """Give it to each of them."""
        for sink in self._sinks:
            sink.write(compared)


def joined(sink: ComparisonSink | None, observer: FlightObserver | None) -> ComparisonSink | None:
    """One receiver of compared attitudes for the two; None where there is neither."""
    if sink is None or observer is None:
        return observer if sink is None else sink
    return ComparisonTee([sink, observer])

"""A substitute for the autopilot's estimator, for faults put into a flight that was recorded without them."""

from bisect import bisect_right
from collections.abc import Sequence
from typing import Final

from attest_mav.algebra import q_exp, q_mul, scale
from attest_mav.estimate import Estimate
from attest_mav.estimation.lane import Lane
from attest_mav.estimation.timebase import wrapped_difference_ns
from attest_mav.estimation.vehicle import AidSettings, Vehicle
from attest_mav.evaluation.fault_study.recording import LaneRecording
from attest_mav.filters.base import AttitudeFilter
from attest_mav.replay.bridge import Knot, interpolate
from attest_mav.replay.stamping import BurstStamp, Stamped
from attest_mav.samples import AttitudeSample, ImuSample, Sample
from attest_mav.types import NO_TIME, AttitudeRole, Quat


class Truth:
    """The truth of a whole flight over time."""

    def __init__(self, flight: LaneRecording) -> None:
        self._knots: Final[list[Knot]] = []
        plan = flight.recording.plan
        stamp = BurstStamp()
        for sample in flight.recording.samples:
            if isinstance(sample, AttitudeSample):
                if sample.source == plan.reference:
                    self._add(stamp.untimed(sample) if sample.t_ns == NO_TIME else Stamped(sample, sample.t_ns))
                elif sample.source == plan.timing:
                    self._add(stamp.timed(sample.t_ns, sample.rx_ns))
        self._add(stamp.finish())
        self._times: Final = [knot.t_ns for knot in self._knots]

    def at(self, t_ns: int) -> Quat:
        """The attitude then, or the nearest one known."""
        place = bisect_right(self._times, t_ns)
        if place == 0 or place == len(self._knots):
            return self._knots[min(place, len(self._knots) - 1)].q_nb
        return interpolate(self._knots[place - 1], self._knots[place], t_ns)

    def _add(self, stamped: Stamped | None) -> None:
        if stamped is not None and (not self._knots or stamped.t_ns > self._knots[-1].t_ns):
            self._knots.append(Knot(stamped.t_ns, stamped.sample.q_nb, stamped.sample.rates))


def always_right(flight: LaneRecording, samples: Sequence[Sample]) -> list[Sample]:
    """The samples with an autopilot whose attitude is the truth."""
    truth = Truth(flight)
    return [
        _saying(sample, truth.at(sample.t_ns))
        if isinstance(sample, AttitudeSample) and sample.role == AttitudeRole.AUTOPILOT
        else sample
        for sample in samples
    ]


def misled(flight: LaneRecording, samples: Sequence[Sample], lane: str, one: AttitudeFilter) -> list[Sample]:
    """The samples with an autopilot that is a filter on one inertial stream, faults and all.

    Before that filter has an attitude it is the autopilot's own.
    """
    recording = flight.recording
    vehicle = Vehicle(AidSettings())
    if recording.earth_field is not None:
        vehicle.field = recording.earth_field.direction
    alone = Lane(lane, one.with_vehicle_settings(recording.settings), vehicle)
    newest: Estimate | None = None
    changed: list[Sample] = []
    for sample in samples:
        if isinstance(sample, AttitudeSample):
            autopilot = sample.role == AttitudeRole.AUTOPILOT and newest is not None
            changed.append(_at(sample, newest) if autopilot and newest is not None else sample)
            continue
        if not isinstance(sample, ImuSample):
            vehicle.take(sample)
        elif sample.source == lane:
            for event in alone.handle(sample):
                newest = event if isinstance(event, Estimate) else newest
        changed.append(sample)
    return changed


def _at(sample: AttitudeSample, estimate: Estimate) -> AttitudeSample:
    """The attitude of an estimate, carried to the time of the sample."""
    apart_s = wrapped_difference_ns(sample.t_ns, estimate.t_ns) * 1e-9
    return _saying(sample, q_mul(estimate.q_nb, q_exp(scale(estimate.rates, 0.5 * apart_s))))


def _saying(sample: AttitudeSample, q_nb: Quat) -> AttitudeSample:
    return sample.with_attitude(q_nb, frame_known=True)

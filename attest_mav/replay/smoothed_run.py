"""The smoothed attitude within a replay: the reference, or compared with another one, with the spread of its sigmas."""

from typing import Final

from attest_mav.estimate import Estimate
from attest_mav.logs.source import SMOOTHED, Plan
from attest_mav.replay.comparison import Attitude, ComparedAttitude, Comparison, ComparisonSink
from attest_mav.replay.metrics import ErrorColumns
from attest_mav.replay.reference_track import ReferenceTrack
from attest_mav.replay.smoothed import SmoothedFlight
from attest_mav.samples import ImuSample


class SmoothedRun:
    """Follows the inertial samples of a replay."""

    def __init__(
        self, flight: SmoothedFlight, plan: Plan, reference: ReferenceTrack, sink: ComparisonSink | None
    ) -> None:
        self.comparison: Final = Comparison(SMOOTHED, reference, sink)
        """Empty where the smoothed attitude is the reference."""
        self.noise: Final = flight.noise
        self.has_refuted: Final = flight.has_refuted
        """Whether the flight contradicts the calibration; the smoothed attitude is then made without it."""
        self.is_reference: Final = plan.reference == SMOOTHED
        self.is_sure = True
        """False while its sigma is too large for others to be compared with it."""
        self.unsure = 0
        """Samples that would have counted but for that sigma."""
        self.sigmas: Final = ErrorColumns()
        """Of the samples that count, rad."""
        self._flight: Final = flight
        self._sink: Final = sink
        self._lane: Final = plan.imu
        flight.begin()

    def take(self, sample: ImuSample, elapsed_s: float, counted: bool, unix_s: float | None) -> Estimate | None:
        """The smoothed attitude at the next inertial sample; None where the smoother did not use the sample.

        elapsed_s: log time, s. counted: whether the time that is left out of the figures is over. unix_s: UTC, s since
        1970, None where it is not known.
        """
        now = self._flight.at(sample.t_ns)
        if now is None:
            return None
        self.is_sure = now.is_sure or not self.is_reference
        self.unsure += counted and not self.is_sure
        if counted and self.is_sure:
            self.sigmas.add(now.tilt_sigma, now.heading_sigma)
        north, sigmas = self._flight.north, (now.tilt_sigma, now.heading_sigma)
        attitude = Attitude(sample.t_ns, elapsed_s, now.q_nb, north, *sigmas, counted, unix_s=unix_s)
        if not self.is_reference:
            self.comparison.add(attitude)
        elif self._sink is not None:
            self._sink.write(ComparedAttitude(SMOOTHED, attitude, None, None))
        return Estimate(self._lane, SMOOTHED, sample.t_ns, sample.rx_ns, now.q_nb, now.rates, north, *sigmas, 0.0)

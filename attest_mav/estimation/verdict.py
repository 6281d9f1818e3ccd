"""The verdict: whether the autopilot's attitude agrees with ours.

Tilt and heading are judged apart, never as Euler differences. A difference counts when it exceeds the larger of a
threshold and three of our own sigmas, and when it does so for a hold time. The estimate is carried to the time of
the autopilot's message with its own rates, so that fast motion is not mistaken for disagreement.
"""

from dataclasses import dataclass
from math import isfinite, nan, radians
from typing import Final

from attest_mav.algebra import heading_between, norm, q_exp, q_mul, scale, tilt_between
from attest_mav.estimation.events import Agreement, Verdict
from attest_mav.estimation.timebase import wrapped_difference_ns
from attest_mav.types import AttitudeSample, Estimate, North, Quat

REASONS: Final = (
    "agrees",
    "tilt",
    "heading",
    "frozen",
    "no-estimate",
    "no-reference",
    "low-confidence",
    "settling",
)
"""The codes of ``Verdict.reason``. "settling" means a change of verdict is being held for the hold time."""

MAX_PAIRING_S: Final = 0.3
"""An estimate is carried over at most this time to meet a reference, s."""
FROZEN_COUNT: Final = 3
"""Bit-identical attitudes in a row while the vehicle turns: an autopilot that works never sends two."""
FROZEN_RATE: Final = 0.02
"""rad/s."""


@dataclass(frozen=True)
class VerdictSettings:
    """tilt: threshold, rad; the heading's is twice that. aided_tilt: the same while our own attitude is ``aided``.

    Aided, 3 degrees are cautious for real sensors; without a velocity filters err by degrees in flight, and the
    threshold is ArduPilot's own before arming. hold_s: a difference must last this long to count.
    release: share of the threshold below which a disagreement ends. max_sigma: above this tilt sigma of our own,
    rad, there is no verdict. stale_s: a reference older than this is no reference.
    """

    tilt: float = radians(10.0)
    aided_tilt: float = radians(3.0)
    hold_s: float = 1.0
    release: float = 0.7
    max_sigma: float = radians(5.0)
    stale_s: float = 1.0


class Judge:
    """Pairs the newest estimate with the autopilot's attitudes as they come."""

    def __init__(self, settings: VerdictSettings) -> None:
        self._settings = settings
        self._estimate: Estimate | None = None
        self._disagrees = False
        self._opposing_since_ns = -1
        self._last_q: Quat = (0.0, 0.0, 0.0, 0.0)
        self._same_count = 0

    def take_estimate(self, estimate: Estimate) -> None:
        """Remember the newest estimate of the primary lane."""
        self._estimate = estimate

    def forget_estimate(self) -> None:
        """There is no valid estimate any more."""
        self._estimate = None

    def judge(self, reference: AttitudeSample) -> Verdict:
        """The verdict on one attitude of the autopilot. ``reference`` must carry a time."""
        estimate = self._estimate
        if estimate is None:
            return self._undecided("no-estimate", reference)
        apart_s = wrapped_difference_ns(reference.t_ns, estimate.t_ns) * 1e-9
        if abs(apart_s) > MAX_PAIRING_S:
            return self._undecided("no-estimate", reference)
        if estimate.tilt_sigma > self._settings.max_sigma:
            return self._undecided("low-confidence", reference)
        ours = q_mul(estimate.q_nb, q_exp(scale(estimate.rates, 0.5 * apart_s)))
        tilt = tilt_between(ours, reference.q_nb)
        heading = nan
        if estimate.north == North.TRUE:
            heading = heading_between(reference.q_nb, ours)
        return self._decide(estimate, reference, tilt, heading)

    def _decide(self, estimate: Estimate, reference: AttitudeSample, tilt: float, heading: float) -> Verdict:
        """Apply thresholds, hysteresis and hold time to one pair of differences."""
        if self._frozen(estimate, reference):
            self._disagrees = True
            self._opposing_since_ns = -1
            return self._verdict(Agreement.DISAGREE, "frozen", tilt, heading, reference)
        reason = self._offence(estimate, tilt, heading)
        opposes = (reason != "agrees") != self._disagrees
        if not opposes:
            self._opposing_since_ns = -1
        elif self._opposing_since_ns < 0:
            self._opposing_since_ns = reference.t_ns
        if opposes and self._lasted(reference):
            self._disagrees = not self._disagrees
            self._opposing_since_ns = -1
        if self._disagrees:
            return self._verdict(
                Agreement.DISAGREE, "settling" if reason == "agrees" else reason, tilt, heading, reference
            )
        return self._verdict(Agreement.AGREE, "agrees" if reason == "agrees" else "settling", tilt, heading, reference)

    def _lasted(self, reference: AttitudeSample) -> bool:
        """True when the opposing differences have lasted for the hold time."""
        return wrapped_difference_ns(reference.t_ns, self._opposing_since_ns) * 1e-9 >= self._settings.hold_s

    def _offence(self, estimate: Estimate, tilt: float, heading: float) -> str:
        """Which difference is too large now: "tilt", "heading" or "agrees"."""
        share = self._settings.release if self._disagrees else 1.0
        threshold = self._settings.aided_tilt if estimate.aided else self._settings.tilt
        if tilt > share * _limit(threshold, estimate.tilt_sigma):
            return "tilt"
        if abs(heading) > share * _limit(2.0 * threshold, estimate.heading_sigma):
            return "heading"
        return "agrees"

    def _frozen(self, estimate: Estimate, reference: AttitudeSample) -> bool:
        """True when the autopilot repeats one attitude bit for bit while the vehicle turns."""
        self._same_count = self._same_count + 1 if reference.q_nb == self._last_q else 1
        self._last_q = reference.q_nb
        return self._same_count >= FROZEN_COUNT and norm(estimate.rates) > FROZEN_RATE

    def _undecided(self, reason: str, reference: AttitudeSample) -> Verdict:
        self._opposing_since_ns = -1
        return self._verdict(Agreement.UNDECIDED, reason, nan, nan, reference)

    def _verdict(
        self, agreement: Agreement, reason: str, tilt: float, heading: float, reference: AttitudeSample
    ) -> Verdict:
        return Verdict(agreement, reason, tilt, heading, reference.source, reference.t_ns, reference.rx_ns)


def _limit(threshold: float, sigma: float) -> float:
    """max(T, 3 sigma); a filter without covariance (NaN) has the threshold alone."""
    return max(threshold, 3.0 * sigma) if isfinite(sigma) else threshold

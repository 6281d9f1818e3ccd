"""The verdict: whether the autopilot's attitude agrees with ours.

Evidence is time, by the autopilot's own time stamps:
it grows while the attitude differs from every attitude of ours that is not refuted, and falls while it does not, so
that a repeated or an agreeing frame in between erases nothing.

AGREE claims that both attitudes are good to the threshold, so our own sigma has to be small enough to say so.
DISAGREE needs a difference above the threshold and above what our sigma explains, for a time, and the magnetic field
must not fit the autopilot's attitude as well as ours: gyros that are off alike turn all of ours. UNDECIDED is the
rest, with the reason.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import nan, radians
from typing import Final

from attest_mav.algebra import is_finite_number, q_conj, q_mul
from attest_mav.estimate import Estimate
from attest_mav.estimation.difference import SLOW_S, Difference, Member, difference_of
from attest_mav.estimation.events import Agreement, Verdict
from attest_mav.estimation.field_evidence import FieldReading
from attest_mav.estimation.offset import OffsetMonitor
from attest_mav.estimation.pairing import Carried, Pairing
from attest_mav.estimation.reference import Reference
from attest_mav.samples import AttitudeSample
from attest_mav.types import Quat

REASONS: Final = (
    "agrees",
    "tilt",
    "heading",
    "frozen",
    "offset",
    "settling",
    "disputed",
    "doubted",
    "heading-uncertain",
    "low-confidence",
    "low-rate",
    "no-estimate",
    "no-reference",
    "unknown-frame",
    "two-senders",
)
"""The codes of ``Verdict.reason``. settling: a difference has not lasted long enough to count, or an offset is being
measured. disputed: our own attitudes differ on it. two-senders: messages of two clocks come
under the vehicle's ids. doubted: all of ours were contradicted just now,
or the magnetic field is not for ours. offset: a steady
one, as a trim that is not known makes it, or a trim that was changed in flight: the attitudes agree but for it, and
nothing tells which trim is right."""


@dataclass(frozen=True)
class VerdictSettings:
    """When the autopilot counts as wrong; angles in rad, the heading's threshold is twice the tilt's."""

    tilt: float = radians(10.0)
    """Threshold beside a filter whose sigma does not cover its errors in flight (ArduPilot's own before arming)."""
    proven_tilt: float = radians(3.0)
    """The same beside a filter whose sigma does, see ``FilterState.sigma_is_proven``."""
    hold_s: float = 0.6
    """A difference must have been there for this long, less the time that it was not."""
    release: float = 0.9
    """Share of the limits below which a difference is over while DISAGREE stands."""
    max_sigma: float = radians(5.0)
    """Above this tilt sigma of our own there is no verdict."""
    agree_sigma: float = radians(2.0)
    """Above this tilt sigma of our own there is no AGREE."""
    stale_s: float = 1.0
    """A reference older than this is none, unless the autopilot sends it at longer intervals."""


class Judge:
    """Weighs the autopilot's attitudes against the set of ours as both come."""

    def __init__(self, settings: VerdictSettings) -> None:
        self._settings = settings
        self.trim_moved = False
        """Whether the trim was changed in flight: the autopilot then levels by another attitude than at take-off."""
        self._pairing: Final = Pairing()
        self._members: tuple[Member, ...] = ()
        self._doubts = False
        self._readings: Mapping[str, FieldReading] = {}
        self._sources: dict[str, Reference] = {}

    def take_estimate(
        self,
        estimate: Estimate,
        members: Sequence[Member] = (),
        *,
        doubts: bool = False,
        readings: Mapping[str, FieldReading] | None = None,
    ) -> tuple[Verdict, ...]:
        """Remember the newest estimate, and the attitudes beside it that are not refuted; verdicts that waited.

        doubts: neither agreement nor disagreement can be said at present; evidence is collected all the same.
        readings: the newest one of each magnetometer, by the name of its inertial message; None without any.
        """
        self._members = tuple(members)
        self._doubts = doubts
        self._readings = {} if readings is None else readings
        waited = self._pairing.take(estimate)
        return tuple([self._weigh(reference) for reference in waited]) if waited else ()

    def forget_estimate(self) -> None:
        """There is no valid estimate any more."""
        self._pairing.forget()
        self._members = ()

    def forget_attitudes(self) -> None:
        """The autopilot's attitudes have stopped: none waits any more, and no accusation stands that could go on."""
        self._pairing.forget_waiting()
        for source in self._sources.values():
            source.is_accused = False

    def use(self, settings: VerdictSettings) -> None:
        """Judge by other settings from now on."""
        self._settings = settings

    def judge(self, sample: AttitudeSample) -> tuple[Verdict, ...]:
        """The verdict on one attitude of the autopilot, which must carry a time; none while it waits or repeats."""
        source = self._source(sample)
        if source.repeats(sample):
            return ()
        return () if self._pairing.waits(sample) else (self._weigh(sample),)

    def interval_s(self, source: str) -> float:
        """The usual interval of a source of attitudes, s; 0 while it is not known."""
        known = self._sources.get(source)
        return 0.0 if known is None else known.interval_s

    def contradictions(self, source: str) -> int:
        """Attitudes of a source that contradict another one of the same time stamp."""
        known = self._sources.get(source)
        return 0 if known is None else known.contradictions

    def _source(self, sample: AttitudeSample) -> Reference:
        known = self._sources.get(sample.source)
        if known is None:
            known = self._sources[sample.source] = Reference(OffsetMonitor())
        return known

    def _weigh(self, sample: AttitudeSample) -> Verdict:
        """Compare one attitude with all of ours at its time, and add to the evidence."""
        source = self._source(sample)
        elapsed_s = source.advance(sample)
        carried = self._pairing.at(sample.t_ns)
        if carried is None:
            return _verdict(Agreement.UNDECIDED, "no-estimate", None, source, sample)
        estimate = carried.estimate
        if estimate.tilt_sigma > self._settings.max_sigma:
            return _verdict(Agreement.UNDECIDED, _doubt(estimate, "low-confidence"), None, source, sample)
        if not sample.frame_known and not estimate.tilt_sigma > self._settings.agree_sigma:
            source.offset.learn(carried.q_nb, sample, estimate.tilt_sigma)
        theirs = sample.q_nb if sample.frame_known else source.offset.undone(sample)
        differences = self._differences(carried, theirs, source.disagrees)
        agree = differences[0].is_near and not (differences[0].is_off or self._doubts)
        if agree and is_finite_number(differences[0].heading):
            source.field.note_agreement()
        turn = q_mul(theirs, q_conj(carried.q_nb))
        source.field.take(self._readings, estimate.lane, turn, agree, sample.t_ns)
        frozen = source.is_frozen(estimate.rates)
        all_off = frozen or all(one.is_off for one in differences)
        may_be_trim = not sample.frame_known and source.offset.may_be_trim(differences[0].tilt)
        if not (may_be_trim and all_off):
            source.add(elapsed_s if all_off else -elapsed_s, self._settings.hold_s)
        verdict = self._said(estimate, source, sample, differences, "frozen" if frozen else "")
        source.is_accused = verdict.agreement == Agreement.DISAGREE
        return verdict

    def _said(
        self,
        estimate: Estimate,
        source: Reference,
        sample: AttitudeSample,
        differences: list[Difference],
        offence: str,
    ) -> Verdict:
        """The verdict that follows from the evidence and from the differences now."""
        first = differences[0]
        off = offence or next((one.reason for one in differences if one.is_off), "")
        by_heading = offence != "" or not first.heading_is_near
        by_velocity = estimate.sigma_is_proven and source.field.tells_no_heading(estimate.lane)
        unproven = by_velocity and offence == "" and not first.heading_is_near
        forbidden = unproven or source.field.forbids(sample.t_ns, by_heading)
        unsupported = source.disagrees and off != "" and forbidden
        if self._doubts or unsupported:
            return _verdict(Agreement.UNDECIDED, "doubted", first, source, sample)
        if source.disagrees and (off != "" or source.is_accused):
            return _verdict(Agreement.DISAGREE, off or "settling", first, source, sample)
        reason = ""
        if off:
            all_off = offence or all(one.is_off for one in differences)
            reason = "settling" if all_off else "disputed"
        elif not all(one.is_near for one in differences):
            reason = "heading-uncertain" if first.reason == "heading" else _doubt(estimate, "low-confidence")
        elif estimate.tilt_sigma > self._settings.agree_sigma or _blind(estimate):
            reason = _doubt(estimate, "low-confidence")
        elif self.trim_moved or (not sample.frame_known and source.offset.angles is not None):
            reason = "offset"
        if reason:
            return _verdict(Agreement.UNDECIDED, reason, first, source, sample)
        return _verdict(Agreement.AGREE, "agrees", first, source, sample)

    def _differences(self, carried: Carried, theirs: Quat, disagrees: bool) -> list[Difference]:
        """The autopilot's attitude beside the selected one and every other member of the set."""
        estimate = carried.estimate
        selected = Member((1.0, 0.0, 0.0, 0.0), estimate.tilt_sigma, estimate.heading_sigma)
        share = self._settings.release if disagrees else 1.0
        threshold = self._settings.proven_tilt if estimate.sigma_is_proven else self._settings.tilt
        return [
            difference_of(q_mul(carried.q_nb, one.turn), one, carried, theirs, threshold, share)
            for one in (selected, *self._members)
        ]


def _blind(estimate: Estimate) -> bool:
    """True for a filter that knows no sigma beside samples that are too slow to follow motion."""
    return not is_finite_number(estimate.tilt_sigma) and estimate.dt_s > SLOW_S


def _doubt(estimate: Estimate, reason: str) -> str:
    """The reason for too little confidence: the rate where it is low."""
    return "low-rate" if estimate.dt_s > SLOW_S else reason


def _verdict(
    agreement: Agreement, reason: str, difference: Difference | None, source: Reference, sample: AttitudeSample
) -> Verdict:
    tilt, heading = (nan, nan) if difference is None else (difference.tilt, difference.heading)
    return Verdict(agreement, reason, tilt, heading, sample.source, sample.t_ns, sample.rx_ns, source.offset.angles)

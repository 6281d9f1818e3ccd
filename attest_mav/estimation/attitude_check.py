"""The autopilot's attitudes on their way to the verdict: which message counts, and when it has stopped.

Each message (ATTITUDE, ATTITUDE_QUATERNION) is weighed by itself. The quaternion counts where it comes about as often
as the Euler angles; a few of them hide nothing. While any message that still comes is contradicted, so is the
autopilot: a second message that agrees does not cover for it.
"""

from collections.abc import Mapping, Sequence
from math import inf, nan
from typing import Final

from attest_mav.estimate import Estimate
from attest_mav.estimation.difference import Member
from attest_mav.estimation.events import Agreement, Verdict
from attest_mav.estimation.field_evidence import FieldReading
from attest_mav.estimation.verdict import Judge, VerdictSettings
from attest_mav.samples import AttitudeSample
from attest_mav.types import AttitudeForm, AttitudeRole

STALE_INTERVALS: Final = 2.5
"""A stream has stopped when nothing has come for longer than this many of its own intervals."""
UNKNOWN_FRAME: Final = "unknown-frame"
"""The reason while attitudes come, and none in a frame that is known."""
COMPARABLE: Final = 2.0
"""A quaternion that comes at up to this many times the Euler angles' interval is preferred to them."""


class _Source:
    """A message of attitudes: its form, its last verdict, and when it was last heard (host clock, ns)."""

    def __init__(self, form: AttitudeForm) -> None:
        self.form: Final = form
        self.rx_ns = -1
        self.verdict: Verdict | None = None


class AttitudeCheck:
    """Everything between the autopilot's attitudes and ``verdict``, the newest one."""

    def __init__(self, settings: VerdictSettings) -> None:
        self.judge: Final = Judge(settings)
        self.verdict: Verdict | None = None
        self.attitude: AttitudeSample | None = None
        """The newest attitude of the message that counts, as it was compared."""
        self._settings = settings
        self._sources: Final[dict[str, _Source]] = {}
        self._refused_ns = -1

    def use(self, settings: VerdictSettings) -> None:
        """Judge by other settings from now on."""
        self._settings = settings
        self.judge.use(settings)

    def take(self, sample: AttitudeSample) -> tuple[Verdict, ...]:
        """Judge an attitude that the autopilot flies by; others tell nothing."""
        if sample.role != AttitudeRole.AUTOPILOT:
            return ()
        source = self._sources.get(sample.source)
        if source is None:
            source = self._sources[sample.source] = _Source(sample.form)
        source.rx_ns = sample.rx_ns
        verdict = self.verdict
        if verdict is None or not verdict.source or verdict.source == sample.source:
            self.attitude = sample
        return self._chosen(self.judge.judge(sample))

    def refuse(self, sample: AttitudeSample) -> tuple[Verdict, ...]:
        """Take an attitude whose frame is not known; the verdict that follows once no other one comes."""
        now_ns = sample.rx_ns
        if sample.role != AttitudeRole.AUTOPILOT:
            return ()
        self._refused_ns = now_ns
        said = self.verdict is not None and self.verdict.reason == UNKNOWN_FRAME
        if said or any(self._is_live(name, now_ns) for name in self._sources):
            return ()
        return (self.undecided(UNKNOWN_FRAME, now_ns),)

    def take_estimate(
        self,
        estimate: Estimate,
        members: Sequence[Member] = (),
        *,
        doubts: bool = False,
        readings: Mapping[str, FieldReading] | None = None,
    ) -> tuple[Verdict, ...]:
        """Take our newest attitude, see ``Judge.take_estimate``; the verdicts on attitudes that waited for it."""
        return self._chosen(self.judge.take_estimate(estimate, members, doubts=doubts, readings=readings))

    def undecided(self, reason: str, now_ns: int) -> Verdict:
        """There is no verdict any more, for this reason."""
        self.verdict = Verdict(Agreement.UNDECIDED, reason, nan, nan, self._preferred(now_ns), -1, now_ns)
        return self.verdict

    def poll(self, now_ns: int) -> tuple[Verdict, ...]:
        """The verdict that follows from no attitude having come until then (host clock)."""
        deadline_ns = self.deadline_ns
        if deadline_ns is None or now_ns < deadline_ns:
            return ()
        verdict = self.undecided("no-reference", now_ns)
        self._sources.clear()
        self.judge.forget_attitudes()
        self._refused_ns = -1
        return (verdict,)

    @property
    def deadline_ns(self) -> int | None:
        """When the attitudes have stopped if none comes, host clock; None while none has come."""
        deadlines = [source.rx_ns + self._stale_ns(name) for name, source in self._sources.items()]
        if self._refused_ns >= 0:
            deadlines.append(self._refused_ns + int(1e9 * self._settings.stale_s))
        return max(deadlines, default=None)

    def _chosen(self, verdicts: tuple[Verdict, ...]) -> tuple[Verdict, ...]:
        """Those of the verdicts that become the verdict."""
        return tuple([verdict for verdict in verdicts if self._becomes(verdict)]) if verdicts else ()

    def _becomes(self, verdict: Verdict) -> bool:
        now_ns = verdict.rx_ns
        source = self._sources.get(verdict.source)
        if source is None:
            return False
        source.verdict = verdict
        if len(self._sources) == 1:
            self.verdict = verdict
            return True
        accusers = [
            name
            for name, one in self._sources.items()
            if one.verdict is not None and one.verdict.agreement == Agreement.DISAGREE and self._is_live(name, now_ns)
        ]
        first = self._preferred(now_ns)
        if verdict.source != (accusers[0] if accusers and first not in accusers else first):
            return False
        self.verdict = verdict
        return True

    def _preferred(self, now_ns: int) -> str:
        """Name of the message that counts, "" while none comes."""
        live = [name for name in self._sources if self._is_live(name, now_ns)]
        if not live:
            return next(iter(self._sources), "")
        shortest_s = min(self._interval_s(name) for name in live)
        comparable = [name for name in live if self._interval_s(name) <= COMPARABLE * shortest_s]
        return max(comparable, key=lambda name: self._sources[name].form)

    def _interval_s(self, name: str) -> float:
        """The usual interval of a message, s; infinite while it came only once."""
        interval_s = self.judge.interval_s(name)
        return interval_s if interval_s > 0.0 else inf

    def _is_live(self, name: str, now_ns: int) -> bool:
        return now_ns < self._sources[name].rx_ns + self._stale_ns(name)

    def _stale_ns(self, name: str) -> int:
        return int(1e9 * max(self._settings.stale_s, STALE_INTERVALS * self.judge.interval_s(name)))

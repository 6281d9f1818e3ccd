"""A tlog decoded once, with all of its inertial streams."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

from attest_mav.errors import UnreadableDataError
from attest_mav.logs.source import LogSource, LogSummary, Plan, Progress, SampleBatch
from attest_mav.logs.tlog.source import open_tlog
from attest_mav.replay.engine import Recording, record
from attest_mav.samples import AttitudeSample
from attest_mav.types import AttitudeRole

LEAST_SHARE: Final = 0.5
"""An inertial stream with less than this share of the samples of the most frequent one is no lane."""


@dataclass(frozen=True)
class LanePlan(Plan):
    """A plan with further inertial messages."""

    lanes: tuple[str, ...] = ()
    """All inertial messages, ``imu`` first."""

    @property
    def messages(self) -> frozenset[str]:
        """All messages to be decoded."""
        return super().messages.union(self.lanes)


class AllLanes:
    """A log source that decodes every inertial stream of the plan's vehicle."""

    def __init__(self, source: LogSource) -> None:
        self.lanes: tuple[str, ...] = ()
        """Names of the streams, the plan's first; known once ``samples`` has been asked for."""
        self._source: Final = source
        self._summary: LogSummary | None = None

    def summary(self, progress: Progress | None = None) -> LogSummary:
        """The content of the log."""
        self._summary = self._source.summary(progress)
        return self._summary

    def samples(self, plan: Plan) -> Iterator[SampleBatch]:
        """The samples of the plan and of the other inertial streams."""
        self.lanes = self._lanes_of(plan)
        return self._source.samples(
            LanePlan(plan.vehicle, plan.imu, plan.reference, plan.autopilot, plan.timing, self.lanes)
        )

    def notes(self, plan: Plan) -> Sequence[str]:
        """Remarks on the plan's inertial message."""
        return self._source.notes(plan)

    def refusals(self, plan: Plan) -> Sequence[str]:
        """Reasons why readings were not decoded."""
        return self._source.refusals(plan)

    def _lanes_of(self, plan: Plan) -> tuple[str, ...]:
        summary = self._summary or self.summary()
        vehicle = summary.vehicles[plan.vehicle]
        least = LEAST_SHARE * vehicle.count(plan.imu)
        others = [name for name in summary.roles.inertial if name != plan.imu and vehicle.count(name) > least]
        return (plan.imu, *others)


@dataclass(frozen=True)
class LaneRecording:
    """A decoded log, and the names of its inertial streams, the one that a replay would choose first."""

    recording: Recording
    lanes: tuple[str, ...]


@lru_cache(maxsize=1)
def recorded_lanes(log: bytes) -> LaneRecording:
    """The log decoded; tasks of one log follow each other, so that each process decodes it once.

    UnreadableDataError for a log without a simulator's truth: nothing could be said of errors.
    """
    source = AllLanes(open_tlog(log))
    recording = record(source)
    if not any(isinstance(one, AttitudeSample) and one.role == AttitudeRole.TRUTH for one in recording.samples):
        raise UnreadableDataError("the log has no true attitude: expected SIM_STATE or SIMSTATE of a simulator")
    return LaneRecording(recording, source.lanes)

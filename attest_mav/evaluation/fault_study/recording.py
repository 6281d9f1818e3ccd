"""A tlog decoded once, with all of its inertial streams."""

from dataclasses import dataclass
from functools import lru_cache

from attest_mav.errors import UnreadableDataError
from attest_mav.logs.tlog.source import open_tlog
from attest_mav.replay.engine import Recording, record
from attest_mav.samples import AttitudeSample
from attest_mav.types import AttitudeRole


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
    recording = record(open_tlog(log), every_sensor=True)
    if not any(isinstance(one, AttitudeSample) and one.role == AttitudeRole.TRUTH for one in recording.samples):
        raise UnreadableDataError("the log has no true attitude: expected SIM_STATE or SIMSTATE of a simulator")
    return LaneRecording(recording, (recording.plan.imu, *recording.plan.other_sensors))

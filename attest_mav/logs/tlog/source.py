"""A telemetry log as a source of samples: the survey is the first pass, the decoder runs in the second."""

from collections.abc import Iterator
from mmap import mmap
from typing import Final

from attest_mav.errors import UnreadableDataError
from attest_mav.logs.source import EXPECTED, ByteSink, LogSummary, Plan, Progress, SampleBatch
from attest_mav.logs.tlog.annotate import OUR_COMPONENT, AnnotatedLogWriter
from attest_mav.logs.tlog.reader import TlogReader, read_windows
from attest_mav.logs.tlog.roles import AIDING, FRAME
from attest_mav.logs.tlog.summary import summarize
from attest_mav.logs.tlog.survey import Survey
from attest_mav.mavlink.component.encoder import Encoder
from attest_mav.mavlink.decode.decoder import Decoder, of_message
from attest_mav.mavlink.dialect import Dialect, load_dialect
from attest_mav.mavlink.wire.frame import Frame
from attest_mav.types import Sample

BATCH_FRAMES: Final = 64
"""Frames decoded at a time: many against the cost of a batch, few enough that the samples stay in the cache."""


def open_tlog(data: mmap | bytes) -> "TlogSource":
    """The source of a tlog, with the dialect that knows all messages."""
    return TlogSource(data, load_dialect())


class TlogSource:
    """The ``LogSource`` of a tlog in memory: a file mapped by ``mmap``, or bytes."""

    def __init__(self, data: mmap | bytes, dialect: Dialect) -> None:
        self._data: Final = data
        self._dialect: Final = dialect
        self._survey: Survey | None = None
        self._decoder = Decoder(dialect)

    def summary(self, progress: Progress | None = None) -> LogSummary:
        """First pass. UnreadableDataError if the log has no MAVLink message."""
        survey = Survey(self._dialect)
        for frames in read_windows(self._data, survey.counter):
            survey.take(frames)
            if progress is not None:
                progress(survey.counter.position / len(self._data))
        if not survey.counter.frames:
            raise UnreadableDataError(
                f"this is no log that is known here: it has no MAVLink message; expected {EXPECTED}"
            )
        self._survey = survey
        return summarize(survey, self._dialect)

    def samples(self, plan: Plan) -> Iterator[SampleBatch]:
        """Second pass, a few frames of the log at a time."""
        self._decoder = self._decoder_for(plan)
        wanted = frozenset(self._dialect.id_of(name) for name in plan.messages.union(AIDING, FRAME))
        reader = TlogReader(self._data, self._dialect, wanted)
        for frames in reader.batches():
            for start in range(0, len(frames), BATCH_FRAMES):
                yield self._decoded(frames[start : start + BATCH_FRAMES], plan)

    def notes(self, plan: Plan) -> list[str]:
        """Remarks of the decoder on the inertial message."""
        return [f"{source}: {note}" for source, note in self._decoder.notes.items() if source == plan.imu]

    def refusals(self, plan: Plan) -> list[str]:
        """Reasons of the decoder, or the missing heartbeat."""
        system, _ = plan.vehicle
        if system not in self._decoder.autopilots:
            return [f"the log has no HEARTBEAT of system {system}'s autopilot, which would tell its units"]
        about = of_message(plan.imu)
        return [reason for source, reason in self._decoder.refusals.items() if source in about]

    def estimate_writer(self, plan: Plan, sink: ByteSink) -> AnnotatedLogWriter:
        """A writer of this log with ATTITUDE_QUATERNION of our component inserted."""
        return AnnotatedLogWriter(self._data, sink, Encoder(self._dialect, plan.vehicle[0], OUR_COMPONENT))

    def _decoder_for(self, plan: Plan) -> Decoder:
        """A decoder that knows the autopilot from the start, also if its first heartbeat comes late in the log."""
        decoder = Decoder(self._dialect)
        heartbeat = None if self._survey is None else self._survey.heartbeats.get(plan.vehicle)
        if heartbeat is not None:
            decoder.decode(heartbeat)
        return decoder

    def _decoded(self, frames: list[Frame], plan: Plan) -> SampleBatch:
        """The samples of the plan's vehicle."""
        system, component = plan.vehicle
        decoder = self._decoder
        samples: list[Sample] = []
        positions: list[int] = []
        for frame in frames:
            if frame.system == system and frame.component == component:
                end = frame.offset + frame.size
                for sample in decoder.decode(frame):
                    samples.append(sample)
                    positions.append(end)
        return SampleBatch(samples, positions, frames[-1].offset / len(self._data))

"""A telemetry log as a source of samples: the survey is the first pass, the decoder runs in the second."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from attest_mav.errors import UnreadableDataError
from attest_mav.logs.source import EXPECTED, ByteSink, LogBytes, LogSummary, Plan, Progress, SampleBatch
from attest_mav.logs.tlog.clocks import LogClocks
from attest_mav.logs.tlog.reader import TlogReader
from attest_mav.logs.tlog.roles import AIDING, FRAME, SELF_REPORTS
from attest_mav.logs.tlog.stamp_repair import FixRepair, StampRepair
from attest_mav.logs.tlog.stamps import time_field
from attest_mav.logs.tlog.summary import summarize
from attest_mav.logs.tlog.survey import Survey
from attest_mav.logs.windows import read_windows
from attest_mav.mavlink.decode.decoder import Decoder, of_message
from attest_mav.mavlink.decode.units import MagnitudeCheck
from attest_mav.mavlink.dialect import Dialect, load_dialect
from attest_mav.mavlink.wire.frame import Frame
from attest_mav.samples import Sample

if TYPE_CHECKING:
    from attest_mav.logs.tlog.annotate import AnnotatedLogWriter

FIX: Final = "GPS_RAW_INT"
BARE_NOTE: Final = "a bare MAVLink stream, without the times of arrival of a tlog: it is read by the vehicle's clock"
BATCH_FRAMES: Final = 64
"""Frames decoded at a time: many against the cost of a batch, few enough that the samples stay in the cache."""


def open_tlog(data: LogBytes) -> "TlogSource":
    """The source of a tlog, with the dialect that knows all messages."""
    return TlogSource(data, load_dialect())


def open_stream(data: LogBytes) -> "MavlinkSource":
    """The source of a bare stream of frames, with the same dialect."""
    return MavlinkSource(data, load_dialect(), bare=True)


class MavlinkSource:
    """The ``LogSource`` of recorded frames. ``bare``: without times."""

    def __init__(self, data: LogBytes, dialect: Dialect, bare: bool = False) -> None:
        self._data: Final = data
        self._dialect: Final = dialect
        self._bare: Final = bare
        self._survey: Survey | None = None
        self._clocks: LogClocks | None = None
        self._decoder = Decoder(dialect)
        self._repairs: dict[int, StampRepair | FixRepair] = {}
        self._is_annotated = False

    def summary(self, progress: Progress | None = None) -> LogSummary:
        """First pass. UnreadableDataError if the log has no MAVLink message."""
        survey = Survey(self._dialect, self._bare)
        for frames in read_windows(self._data, survey.counter):
            survey.take(frames)
            if progress is not None:
                progress(survey.counter.position / len(self._data))
        if not survey.counter.frames:
            raise UnreadableDataError(
                f"this is no log that is known here: it has no MAVLink message; expected {EXPECTED}"
            )
        clocks = survey.clocks()
        self._survey, self._clocks = survey, clocks
        log_format = "mavlink" if self._bare else "tlog"
        return summarize(survey, clocks, self._dialect, log_format, len(self._data))

    def samples(self, plan: Plan) -> Iterator[SampleBatch]:
        """Second pass, a few frames of the log at a time."""
        self._decoder = self._decoder_for(plan)
        wanted = frozenset(self._dialect.id_of(name) for name in plan.messages.union(AIDING, FRAME, SELF_REPORTS))
        self._repairs = self._repairs_for(plan)
        is_intact = self._survey is not None and self._survey.counter.is_intact
        reader = TlogReader(self._data, self._dialect, wanted, self._bare, is_intact)
        length = len(self._data)
        for frames in reader.batches():
            for start in range(0, len(frames), BATCH_FRAMES):
                yield self._decoded(frames[start : start + BATCH_FRAMES], plan, length)

    def notes(self, plan: Plan) -> list[str]:
        """Remarks of the decoder on the inertial message, and on the clocks."""
        clocks = (
            []
            if self._clocks is None
            else [*self._clocks.arrivals.notes, self._clocks.sensor(plan.vehicle, plan.imu).note]
        )
        return [
            *(f"{source}: {note}" for source, note in self._decoder.notes.items() if source == plan.imu),
            *([BARE_NOTE] if self._bare else []),
            *(note for note in clocks if note),
        ]

    def refusals(self, plan: Plan) -> list[str]:
        """Reasons of the decoder, the missing heartbeat, or a clock that no filter can go by."""
        system, _ = plan.vehicle
        if system not in self._decoder.autopilots:
            return [f"the log has no HEARTBEAT of system {system}'s autopilot, which would tell its units"]
        about = of_message(plan.imu)
        reasons = [reason for source, reason in self._decoder.refusals.items() if source in about]
        obstacle = "" if self._clocks is None else self._clocks.sensor(plan.vehicle, plan.imu).obstacle
        return [reason for reason in (self._too_few(plan), obstacle, *reasons) if reason]

    def _too_few(self, plan: Plan) -> str:
        """The reason why the units of a handful of inertial messages cannot be known."""
        count = (
            0 if self._survey is None else self._survey.counter.count_of(plan.vehicle, self._dialect.id_of(plan.imu))
        )
        if count >= MagnitudeCheck.WINDOW:
            return ""
        return f"{count} {plan.imu}, fewer than the {MagnitudeCheck.WINDOW} that are needed to know its units"

    def _decoder_for(self, plan: Plan) -> Decoder:
        """A decoder that knows the autopilot from the start, also if its first heartbeat comes late in the log."""
        decoder = Decoder(self._dialect)
        heartbeat = None if self._survey is None else self._survey.heartbeats.get(plan.vehicle)
        if heartbeat is not None:
            decoder.decode(heartbeat)
        return decoder

    def _repairs_for(self, plan: Plan) -> dict[int, StampRepair | FixRepair]:
        """The repairs of times that are not time since boot, by message id."""
        if self._clocks is None:
            return {}
        dialect, repairs = self._dialect, dict[int, StampRepair | FixRepair]()
        for name in (plan.imu, *plan.other_sensors):
            rule = self._clocks.sensor(plan.vehicle, name).rule
            if not rule.is_plain:
                repairs[dialect.id_of(name)] = StampRepair(rule, time_field(dialect, name))
        clock = self._clocks.sensor(plan.vehicle, plan.imu)
        if clock.is_unix:
            repairs[dialect.id_of(FIX)] = FixRepair(clock.rule.shift, time_field(dialect, FIX))
        return repairs

    def _decoded(self, frames: list[Frame], plan: Plan, length: int) -> SampleBatch:
        """The samples of the plan's vehicle. length: of the log, bytes."""
        system, component = plan.vehicle
        decoder = self._decoder
        repairs = self._repairs
        samples: list[Sample] = []
        positions: list[int] = []
        for frame in frames:
            if frame.system == system and frame.component == component:
                repair = repairs.get(frame.message_id) if repairs else None
                decoded = decoder.decode(frame if repair is None else repair.repaired(frame))
                samples.extend(decoded)
                if self._is_annotated:
                    positions.extend([frame.offset + frame.size] * len(decoded))
        return SampleBatch(samples, positions, frames[-1].offset / length)


class TlogSource(MavlinkSource):
    """The source of a tlog, which can hold our estimates."""

    def estimate_writer(self, plan: Plan, sink: ByteSink) -> "AnnotatedLogWriter":
        """A writer of this log with ATTITUDE_QUATERNION of our component inserted."""
        from attest_mav.logs.tlog.annotate import OUR_COMPONENT, AnnotatedLogWriter  # noqa: PLC0415 - costs 2 ms
        from attest_mav.mavlink.component.encoder import Encoder  # noqa: PLC0415

        self._is_annotated = True
        return AnnotatedLogWriter(self._data, sink, Encoder(self._dialect, plan.vehicle[0], OUR_COMPONENT))

"""A recorded flight of any log format: the protocol between the formats and the replay.

A source is read in two passes. ``summary`` gives the content of the log, from which a ``Plan`` is made; ``samples``
decodes only the messages of the plan, in order of time and at constant memory. The user of a source knows no message
id, frame or file structure: a message is a name, and its uses stand in ``MessageRoles``.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, Protocol, runtime_checkable

from attest_mav.estimate import Estimate
from attest_mav.record import Record
from attest_mav.samples import PositionSample, Sample
from attest_mav.vehicle_reports import ParameterSample
from attest_mav.vehicle_settings import VehicleSettings

VehicleId = tuple[int, int]
"""(system, component) of the samples of one vehicle."""

Progress = Callable[[float], None]
"""Is called with the share of the work done, 0 to 1."""

SMOOTHED: Final = "smoothed"
"""The reference that is no message: the smoothed attitude, made of the inertial samples and their aids."""

EXPECTED: Final = "a tlog, a DataFlash log (.bin, .log) or a ULog"
"""The log formats, for error messages."""


@dataclass(frozen=True)
class MessageRoles:
    """The uses that a format's messages have, by name. Each tuple is ordered: the preferred one first."""

    inertial: tuple[str, ...]
    """Inertial messages, on which a filter can run."""
    truth: tuple[str, ...]
    """Attitudes of a simulator's vehicle, free of error."""
    reference: tuple[str, ...]
    """Attitudes to compare with, the truths among them, in the order in which one is chosen."""
    named_reference: tuple[str, ...]
    """Attitudes to compare with if the user names one."""
    autopilot: tuple[str, ...]
    """The autopilot's own attitude."""
    untimed: tuple[str, ...]
    """Attitudes without a time on the sensor's clock."""
    other_sensors: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """By inertial message those of the vehicle's other inertial sensors."""


class FlightDate(Record):
    """The date of a flight."""

    def __init__(self, unix_s: float, note: str = "") -> None:
        self.unix_s: Final = unix_s
        self.note: Final = note
        """A remark for people, "" if nothing speaks against the date."""


@dataclass(frozen=True)
class VehicleSummary:
    """The content of a log that comes from one sender."""

    vehicle: VehicleId
    is_autopilot: bool
    """True for a sender that says that it is a flight controller."""
    counts: Mapping[str, int]
    """Number of messages by name."""
    inertial: tuple[str, ...]
    """All inertial messages of the format, the best one for this vehicle first, present or not."""
    in_simulator: bool
    """True for a flight in ArduPilot's simulator, whose magnetic field is that of a table."""
    position: PositionSample | None
    """The first position with a 3-D fix."""
    velocity_lack: str
    """The reason why the log has no receiver velocity, for people; "" if it has one."""
    settings: VehicleSettings
    """The settings of the vehicle, from firmware and parameters."""
    parameters: tuple[ParameterSample, ...]
    """The parameters in the log behind ``settings``, the last one of each setting."""
    opening: tuple[Sample, ...] = ()
    """The vehicle as the log's first samples tell it: its first heartbeat, its firmware, the first value of each
    parameter."""

    first_settings: VehicleSettings | None = None
    """The settings that hold before the vehicle has told any; None for a format that tells all at its beginning."""

    date: FlightDate | None = None
    """The date of the flight; None for that of the position's ``rx_ns``."""
    spans: Mapping[str, float] = field(default_factory=dict)
    """Share of the log from the first to the last attitude, by name; 1 where nothing is told."""
    unfit: Mapping[str, str] = field(default_factory=dict)
    """Attitudes that nothing can be compared with: the reason for people, by name."""

    def count(self, name: str) -> int:
        """Number of messages of that name."""
        return self.counts.get(name, 0)

    @property
    def has_velocity(self) -> bool:
        """True if a receiver's velocity is in the log."""
        return not self.velocity_lack


@dataclass(frozen=True)
class LogSummary:
    """The content of a log, from the first pass over it."""

    log_format: str
    roles: MessageRoles
    messages: int
    """Intact messages of all senders."""
    bad_bytes: int
    """Bytes that belong to no intact message."""
    duration_s: float
    """Time from the first to the last message, s."""
    vehicles: Mapping[VehicleId, VehicleSummary]
    """All senders, in order of their ids."""


@dataclass(frozen=True)
class Plan:
    """The messages of one vehicle that the second pass decodes, by name; None where the log has none."""

    vehicle: VehicleId
    imu: str
    """The inertial message."""
    reference: str | None
    """The attitude that all others are compared with; ``SMOOTHED`` for the smoothed one."""
    autopilot: str | None
    """The autopilot's own attitude, unless that is the reference."""
    timing: str | None
    """The message whose time an untimed reference takes."""
    other_sensors: tuple[str, ...] = ()
    """The inertial messages of the vehicle's other sensors."""

    @property
    def messages(self) -> frozenset[str]:
        """The names above."""
        names = (self.imu, self.reference, self.autopilot, self.timing, *self.other_sensors)
        return frozenset(name for name in names if name is not None and name != SMOOTHED)


class LogBytes(Protocol):
    """The bytes of a log, to be read in pieces: ``bytes``, a mapped file, or an open one."""

    def __len__(self) -> int:
        """Number of bytes."""

    def __getitem__(self, span: slice, /) -> bytes:
        """One piece of them."""


@runtime_checkable
class NotedBytes(LogBytes, Protocol):
    """Bytes with remarks on where they come from, such as a damaged archive."""

    @property
    def notes(self) -> Sequence[str]:
        """The remarks, for people."""


class SampleBatch:
    """The samples of one stretch of a log, in order of time."""

    def __init__(self, samples: list[Sample], positions: list[int], share: float) -> None:
        self.samples: Final = samples
        self.positions: Final = positions
        """For each sample the end of its record in the log, for the source's ``EstimateWriter``; empty without one."""
        self.share: Final = share
        """Share of the log that has been read, 0 to 1."""


class LogSource(Protocol):
    """A log of one format, open for reading."""

    def summary(self, progress: Progress | None = None) -> LogSummary:
        """First pass. UnreadableDataError if the log has no message."""

    def samples(self, plan: Plan) -> Iterator[SampleBatch]:
        """Second pass: the samples of the plan's messages, and of all that aid a filter or tell an attitude's frame.

        The aiding messages do not depend on the plan, so that the result of a filter does not depend on its company.
        """

    def notes(self, plan: Plan) -> Sequence[str]:
        """Remarks on the plan's inertial message for the reader of the figures; complete after ``samples``."""

    def refusals(self, plan: Plan) -> Sequence[str]:
        """Reasons why readings of the plan's inertial message were not decoded; complete after ``samples``."""


class ByteSink(Protocol):
    """Takes bytes, for example a file object."""

    def write(self, data: bytes, /) -> object:
        """Take the next bytes."""


class EstimateWriter(Protocol):
    """Writes a log that also holds our estimates."""

    def insert(self, estimate: Estimate, position: int) -> None:
        """Insert an estimate at the position of its sample (``SampleBatch``). Positions never decrease."""

    def finish(self) -> None:
        """The last estimate has been inserted."""


@runtime_checkable
class AnnotatableSource(LogSource, Protocol):
    """A log whose format can hold our estimates."""

    def estimate_writer(self, plan: Plan, sink: ByteSink) -> EstimateWriter:
        """A writer of this log with estimates of the plan's vehicle inserted, into ``sink``.

        From now on ``samples`` tells positions.
        """

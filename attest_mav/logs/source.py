"""A recorded flight of any log format: the protocol between the formats and the replay.

A source is read in two passes. ``summary`` gives the content of the log, from which a ``Plan`` is made; ``samples``
decodes only the messages of the plan, in order of time and at constant memory. The user of a source knows no message
id, frame or file structure: a message is a name, and its uses stand in ``MessageRoles``.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
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


class MessageRoles(Record):
    """The uses that a format's messages have, by name. Each tuple is ordered: the preferred one first."""

    def __init__(
        self,
        inertial: tuple[str, ...],
        truth: tuple[str, ...],
        reference: tuple[str, ...],
        named_reference: tuple[str, ...],
        autopilot: tuple[str, ...],
        untimed: tuple[str, ...],
        other_sensors: Mapping[str, tuple[str, ...]] | None = None,
    ) -> None:
        self.inertial: Final = inertial
        """Inertial messages, on which a filter can run."""
        self.truth: Final = truth
        """Attitudes of a simulator's vehicle, free of error."""
        self.reference: Final = reference
        """Attitudes to compare with, the truths among them, in the order in which one is chosen."""
        self.named_reference: Final = named_reference
        """Attitudes to compare with if the user names one."""
        self.autopilot: Final = autopilot
        """The autopilot's own attitude."""
        self.untimed: Final = untimed
        """Attitudes without a time on the sensor's clock."""
        self.other_sensors: Final[Mapping[str, tuple[str, ...]]] = {} if other_sensors is None else other_sensors
        """By inertial message those of the vehicle's other inertial sensors."""


class FlightDate(Record):
    """The date of a flight."""

    def __init__(self, unix_s: float, note: str = "") -> None:
        self.unix_s: Final = unix_s
        self.note: Final = note
        """A remark for people, "" if nothing speaks against the date."""


class VehicleSummary(Record):
    """The content of a log that comes from one sender."""

    def __init__(
        self,
        vehicle: VehicleId,
        is_autopilot: bool,
        counts: Mapping[str, int],
        inertial: tuple[str, ...],
        in_simulator: bool,
        position: PositionSample | None,
        velocity_lack: str,
        settings: VehicleSettings,
        parameters: tuple[ParameterSample, ...],
        opening: tuple[Sample, ...] = (),
        first_settings: VehicleSettings | None = None,
        date: FlightDate | None = None,
        spans: Mapping[str, float] | None = None,
        unfit: Mapping[str, str] | None = None,
    ) -> None:
        self.vehicle: Final = vehicle
        self.is_autopilot: Final = is_autopilot
        """True for a sender that says that it is a flight controller."""
        self.counts: Final = counts
        """Number of messages by name."""
        self.inertial: Final = inertial
        """All inertial messages of the format, the best one for this vehicle first, present or not."""
        self.in_simulator: Final = in_simulator
        """True for a flight in ArduPilot's simulator, whose magnetic field is that of a table."""
        self.position: Final = position
        """The first position with a 3-D fix."""
        self.velocity_lack: Final = velocity_lack
        """The reason why the log has no receiver velocity, for people; "" if it has one."""
        self.settings: Final = settings
        """The settings of the vehicle, from firmware and parameters."""
        self.parameters: Final = parameters
        """The parameters in the log behind ``settings``, the last one of each setting."""
        self.opening: Final = opening
        """The vehicle as the log's first samples tell it: its first heartbeat, its firmware, the first value of each
        parameter."""
        self.first_settings: Final = first_settings
        """The settings that hold before the vehicle has told any; None for a format that tells all at its beginning."""
        self.date: Final = date
        """The date of the flight; None for that of the position's ``rx_ns``."""
        self.spans: Final[Mapping[str, float]] = {} if spans is None else spans
        """Share of the log from the first to the last attitude, by name; 1 where nothing is told."""
        self.unfit: Final[Mapping[str, str]] = {} if unfit is None else unfit
        """Attitudes that nothing can be compared with: the reason for people, by name."""

    def count(self, name: str) -> int:
        """Number of messages of that name."""
        return self.counts.get(name, 0)

    @property
    def has_velocity(self) -> bool:
        """True if a receiver's velocity is in the log."""
        return not self.velocity_lack


class LogSummary(Record):
    """The content of a log, from the first pass over it."""

    def __init__(
        self,
        log_format: str,
        roles: MessageRoles,
        messages: int,
        bad_bytes: int,
        duration_s: float,
        vehicles: Mapping[VehicleId, VehicleSummary],
    ) -> None:
        self.log_format: Final = log_format
        self.roles: Final = roles
        self.messages: Final = messages
        """Intact messages of all senders."""
        self.bad_bytes: Final = bad_bytes
        """Bytes that belong to no intact message."""
        self.duration_s: Final = duration_s
        """Time from the first to the last message, s."""
        self.vehicles: Final = vehicles
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

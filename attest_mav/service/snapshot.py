"""All that a person, a metric or a page may see of the service at one instant: immutable, and complete.

Nobody looks into the service itself. Counters count from the start of the service and never decrease, so that each
reader makes rates of its own from two snapshots, whatever other readers do.
"""

from dataclasses import dataclass

from attest_mav.mavlink.component.own_parameters import ParameterChange
from attest_mav.service.link_records import LinkSnapshot, Refusal, StreamSnapshot
from attest_mav.service.vehicle_records import AidSnapshot, ClockSnapshot, LaneSnapshot, VehicleSnapshot
from attest_mav.service.verdict_records import AutopilotAttitude, VerdictSpan, VerdictStanding


@dataclass(frozen=True)
class RecordingSnapshot:
    """The recording of our own work; its host makes it."""

    file: str
    """Name of the present file, "" before there is one."""
    written_bytes: int
    """Bytes written so far."""
    lost_frames: int
    """Frames that were not written, because the disk was full, slow or broken."""
    complaint: str
    """Why nothing is written at present, "" while all is well."""


@dataclass(frozen=True)
class NoteCounts:
    """Lines left for the log, by severity."""

    warnings: int
    """Something worth acting on."""
    errors: int
    """Something that prevents all work until someone acts on it."""
    dropped: int
    """Lines of any severity that the host did not fetch in time."""


@dataclass(frozen=True)
class Snapshot:
    """The whole service at one instant."""

    now_ns: int
    """The instant, ns of the host's clock."""
    state: int
    """MAV_STATE of the last heartbeat."""
    vehicle: VehicleSnapshot | None
    """None before one is found."""
    ambiguity: str
    """Why no vehicle is chosen although there are several; "" otherwise."""
    links: tuple[LinkSnapshot, ...]
    """In the order of the configuration."""
    streams: tuple[StreamSnapshot, ...]
    """The messages asked for."""
    inertial: str
    """The inertial message in use or being tried, "" before there is a vehicle."""
    single_imu: str
    """Why there is one inertial sensor alone, "" where there are more, or while that is not known yet."""
    not_independent: frozenset[str]
    """Inertial messages whose readings come out of the autopilot's own filter."""
    refusals: tuple[Refusal, ...]
    """Messages that gave no samples."""
    samples: int
    """Inertial samples taken from the message in use, of all vehicles and lanes so far."""
    clock: ClockSnapshot
    """The autopilot's clock."""
    late_by_s: float
    """The delay of the newest sample of the published lane where it is too large to be used, s; else 0."""
    lanes: tuple[LaneSnapshot, ...]
    """Empty before the first inertial sample."""
    aids: tuple[AidSnapshot, ...]
    """The newest measurement of each aid that the filter was offered, in the order in which the aids first came."""
    verdict: VerdictStanding | None
    """None before the first verdict."""
    spans: tuple[VerdictSpan, ...]
    """The last intervals of the verdict on this vehicle, oldest first; the last one goes on."""
    tilt_threshold: float | None
    """Difference in tilt from which the autopilot's attitude counts as wrong, rad; of heading, twice as much."""
    autopilot: AutopilotAttitude | None
    """None before the first attitude that could be compared."""
    withheld: str
    """Why the newest estimate is not sent as ATTITUDE_QUATERNION, "" where it is sent or there is none."""
    self_report: tuple[str, ...]
    """What is bad by the autopilot's own words, each to be read behind "the autopilot itself"."""
    frame_notes: tuple[str, ...]
    """The trims that are taken off the autopilot's attitudes, and the messages that cannot be compared."""
    link_remarks: tuple[str, ...]
    """What is wrong on the links: other senders, damage, requests that are not heard; each a sentence."""
    own_parameters: tuple[tuple[str, ParameterChange], ...]
    """Our parameters that stations have set, by name."""
    notes: NoteCounts
    """Lines left for the log."""
    recording: RecordingSnapshot | None
    """None where nothing is recorded."""

    @property
    def inertial_stream(self) -> StreamSnapshot | None:
        """The request for the inertial message, None before there is a vehicle."""
        return next((stream for stream in self.streams if stream.name == self.inertial), None)

    @property
    def inertial_refusal(self) -> str:
        """Why the inertial message gives no samples, "" where it does."""
        return next((one.reason for one in self.refusals if one.source == self.inertial), "")

    @property
    def published_lane(self) -> LaneSnapshot | None:
        """The lane with an estimate to publish, None while there is none."""
        return next((lane for lane in self.lanes if lane.estimate is not None), None)


@dataclass(frozen=True)
class Rates:
    """Rates between two snapshots, Hz."""

    samples: float
    """Inertial samples taken."""
    published: float
    """Attitudes sent on the link that carries most."""


def rates_between(before: Snapshot, now: Snapshot) -> Rates:
    """The rates from one snapshot to a later one."""
    span_s = max((now.now_ns - before.now_ns) / 1e9, 1e-9)
    return Rates((now.samples - before.samples) / span_s, (_attitudes(now) - _attitudes(before)) / span_s)


def _attitudes(snapshot: Snapshot) -> int:
    return max((link.attitudes_sent for link in snapshot.links), default=0)

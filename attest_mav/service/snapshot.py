"""All that a person, a metric or a page may see of the service at one instant: immutable, and complete.

Nobody looks into the service itself. Counters count from the start of the service and never decrease, so that each
reader makes rates of its own from two snapshots, whatever other readers do.
"""

from dataclasses import dataclass

from attest_mav.estimate import Estimate
from attest_mav.innovation import Innovation
from attest_mav.mavlink.component.own_parameters import ParameterChange
from attest_mav.service.signing_status import SigningSnapshot
from attest_mav.service.verdict_records import AutopilotAttitude, VerdictSpan, VerdictStanding
from attest_mav.types import EarthField, VehicleKind, Version
from attest_mav.vehicle_settings import VehicleSettings


@dataclass(frozen=True)
class Traffic:
    """Transport counters of one link; its host keeps them."""

    is_up: bool = False
    """Whether messages can be sent at all."""
    is_open: bool = False
    """Whether the device or socket is open: a link that listens is open before anyone speaks."""
    streams: int = 0
    """Byte streams begun: one more with every connection made again."""
    received_bytes: int = 0
    """Bytes received."""
    sent_bytes: int = 0
    """Bytes sent."""
    dropped_messages: int = 0
    """Messages not sent, because the link was down or its buffer full."""


NO_TRAFFIC = Traffic()
"""For a host that counts nothing."""


@dataclass(frozen=True)
class LinkSnapshot:
    """One link: its MAVLink frames, and its bytes."""

    name: str
    """The URL, with the port that the system chose."""
    frames: int
    """Intact frames received, wanted or not."""
    bad_bytes: int
    """Bytes received that belong to no frame."""
    bad_crc: int
    """Frames received whose checksum does not fit."""
    lost_frames: int
    """Frames missing in the sequence numbers of their senders."""
    attitudes_sent: int
    """Estimates published, each counted once in whichever messages; answers to requests are not counted."""
    held_back: bool
    """Whether ATTITUDE_QUATERNION is held back, because another onboard computer, or a ground station beside the
    vehicle, is heard on the link."""
    held_for: int
    """Component id of that program, 0 for none."""
    changes: tuple[str, ...]
    """What other stations have changed in our outputs: message, rate and station."""
    signing: SigningSnapshot | None
    """Its signatures, None where nothing is signed."""
    traffic: Traffic
    """Transport counters."""


@dataclass(frozen=True)
class VehicleSnapshot:
    """The vehicle that was found, and the contents of its messages."""

    system: int
    """MAVLink system id."""
    component: int
    """MAVLink component id of the autopilot."""
    autopilot: int
    """MAV_AUTOPILOT."""
    vehicle_type: int
    """MAV_TYPE."""
    link: int
    """Number of the link on which it was found last."""
    is_present: bool
    """Whether its heartbeats arrive."""
    kind: VehicleKind
    """How it can move."""
    armed: bool | None
    """None before its first heartbeat."""
    firmware: Version | None
    """Version of the autopilot's firmware, None while it is not known."""
    settings: VehicleSettings
    """The autopilot's settings that filters and the comparison use, as far as they are known."""
    field: EarthField
    """The Earth's field at its position."""
    speed_source: str
    """The source of the body velocity for the leveling filter."""


@dataclass(frozen=True)
class StreamSnapshot:
    """One message that the autopilot is asked for."""

    name: str
    """The message."""
    hz: float
    """Rate asked for, Hz."""
    answer: str
    """The autopilot's answer in a word or two, "" before there is one."""
    refused: bool
    """Whether the autopilot will not send it."""
    achieved_hz: float
    """Rate measured over the last window, Hz; 0 before the first one ends, and while the vehicle is away."""
    ceiling_hz: float
    """The most that the autopilot gives, Hz; 0 where no limit was found."""
    hindrance: str
    """Why it does not come at the rate asked for, "" where that is not known."""


@dataclass(frozen=True)
class Refusal:
    """Messages of one source that gave no samples."""

    source: str
    """The message; with `` magnetometer`` behind it, its magnetometer alone."""
    reason: str
    """Why it gives none at present, "" where it gives samples again."""
    messages: int
    """Messages refused so far."""


@dataclass(frozen=True)
class ClockSnapshot:
    """The autopilot's clock against ours, by exchanges of time with it (TIMESYNC)."""

    answers: int
    """Answers so far; without one delays are known only as far as they grow or shrink."""
    round_trip_s: float
    """Round trip of the exchange in use, s: ages of samples are uncertain by half of it. 0 before the first one."""
    skew: float
    """How much faster our clock runs than the autopilot's, s/s; 0 while it is not known."""
    jumps: int
    """How often the autopilot's clock was found stopped or set."""


@dataclass(frozen=True)
class AidSnapshot:
    """The newest measurement of one aid beside the published estimates."""

    innovation: Innovation
    """Its residual, and whether it was used."""
    rx_ns: int
    """Arrival of the inertial sample whose step took it, host clock."""


@dataclass(frozen=True)
class LaneSnapshot:
    """One inertial sensor with its filter. All counts are of samples, unless said otherwise."""

    source: str
    """The inertial message."""
    is_primary: bool
    """Whether this lane is the one published and compared."""
    estimate: Estimate | None
    """The newest valid estimate, else None; kept of the primary lane only."""
    fault: str
    """Why it is set aside: sensor, axis and size; "" while it is used."""
    rests_on: str
    """The aiding that holds the attitude, "" for a filter that always has the same."""
    field_lost_s: float
    """Time since its magnetometer could last be used, s; 0 where it never could."""
    samples: int
    """Taken."""
    repeats: int
    """Dropped: same timestamp as the one before."""
    late: int
    """Dropped: older than the one before."""
    strays: int
    """Dropped: with a timestamp that the next ones did not confirm."""
    delay_s: float
    """How late the newest sample came, s: measured with ``ClockSnapshot``, else more than the quickest one."""
    rejected: int
    """Dropped: not finite."""
    frozen: int
    """Dropped: the sensor repeats one reading."""
    gaps: int
    """Gaps between samples."""
    restarts: int
    """Alignments begun again."""


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

"""The configuration as frozen records.

The records are inert: they hold the words and numbers of a user, in a user's units. ``attest_mav.service.assembly``
makes settings of them. They are the reference: a field's name carries its unit, its type the range, and its default is
the default. configs/attest-mav.toml explains each key at length, and a test keeps the two alike.
"""

from typing import TYPE_CHECKING, Annotated, Literal, Self

import msgspec
from msgspec import Meta

from attest_mav.config.filters import FilterConfig
from attest_mav.mavlink.component.outputs import OUTPUT_NAMES
from attest_mav.mavlink.constants import INERTIAL_MESSAGES

SystemId = Annotated[int, Meta(ge=0, le=255)]
ComponentId = Annotated[int, Meta(ge=1, le=255)]
RateHz = Annotated[float, Meta(ge=0.01, le=1000.0)]
Seconds = Annotated[float, Meta(ge=0.1, le=3600.0)]
BytesPerSecond = Annotated[float, Meta(ge=0.0, le=1e8)]
Megabytes = Annotated[float, Meta(ge=1.0, le=1e7)]
Scale = Annotated[float, Meta(ge=0.0, le=1.0)]
Url = Annotated[str, Meta(examples=["udpin:0.0.0.0:14550"])]
Address = Annotated[str, Meta(examples=["127.0.0.1:8484"])]
KeyFile = Annotated[str, Meta(examples=["/etc/attest-mav/signing.key"])]
StateFolder = Annotated[str, Meta(examples=["/var/lib/attest-mav"])]
RecordFolder = Annotated[str, Meta(examples=["/var/log/attest-mav"])]
UnsignedMessages = Annotated[tuple[str, ...], Meta(examples=[["RADIO_STATUS"]])]
HostNames = Annotated[tuple[str, ...], Meta(examples=[["drone.local"]])]
SpeedSource = Literal[
    "auto", "airspeed", "groundspeed", "GPS_RAW_INT", "GLOBAL_POSITION_INT", "LOCAL_POSITION_NED", "none"
]
VelocitySource = Literal["GPS_RAW_INT", "GLOBAL_POSITION_INT", "LOCAL_POSITION_NED", "none"]
if TYPE_CHECKING:  # a type checker knows no choice among names that are listed elsewhere
    ImuMessage = str
    OutputName = str
else:
    ImuMessage = Literal[INERTIAL_MESSAGES]
    OutputName = Literal[OUTPUT_NAMES]


class _Record(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Base of all records: frozen, keyword-only, no unknown keys."""


class VehicleConfig(_Record, frozen=True):
    """The vehicle to listen to."""

    system_id: SystemId = 0
    """Its MAVLink system id; 0 takes the only one that is heard."""


class OutputConfig(_Record, frozen=True):
    """Our ids, and the rate of the attitude."""

    system_id: SystemId = 0
    """Our MAVLink system id; 0 takes the vehicle's."""
    component_id: ComponentId = 193
    """Our MAVLink component id."""
    rate_hz: RateHz = 20.0
    """Rate of ATTITUDE_QUATERNION, Hz."""
    max_sigma_deg: Annotated[float, Meta(gt=0.0, le=180.0)] = 3.0
    """Tilt sigma of our own above which ATTITUDE_QUATERNION is withheld, degrees."""


class LinkConfig(_Record, frozen=True):
    """One link, and its outputs."""

    url: Url
    """See ``parse_link``."""
    publish: tuple[OutputName, ...] = ("attitude_quaternion", "statustext")
    """The outputs on this link."""
    yield_to_onboard: bool = True
    """Hold ATTITUDE_QUATERNION back while another onboard computer of the vehicle is heard on the link."""
    yield_to_stations: bool = True
    """Hold it back likewise while a ground station is heard on a link that brings the vehicle too."""
    parameters: bool = False
    """Let ground stations read and set our parameters."""
    signing: Literal["off", "sign", "require"] = "off"
    """Sign what is sent and verify what is signed; "require" drops unsigned frames too."""
    key_file: KeyFile = ""
    """File of the key, 32 bytes or 64 hexadecimal digits, which nobody else may read."""
    accept_unsigned: UnsignedMessages = ()
    """Messages that are taken unsigned all the same."""
    wait: bool = True
    """Wait for a device or a server that is not there at the start, instead of ending with exit code 69."""


class StreamsConfig(_Record, frozen=True):
    """The messages that the autopilot is asked to send."""

    request: bool = True
    """Ask for messages at all."""
    restore: bool = False
    """Set the rates back to the autopilot's defaults at the end."""
    imu_messages: tuple[ImuMessage, ...] = ()
    """Inertial messages in order of preference; empty takes the order that suits the autopilot."""
    further_imu_messages: Literal["auto"] | tuple[ImuMessage, ...] = "auto"
    """Inertial messages of other sensors, each with a filter of its own beside the first: a lane. "auto" takes all."""
    imu_bytes_per_s: BytesPerSecond = 0.0
    """Limit of all inertial messages together; 0 is half of the slowest serial link, and none on networks."""
    imu_hz: RateHz = 50.0
    """Rate of each inertial message, Hz."""
    attitude_hz: RateHz = 10.0
    """Rate of the autopilot's attitude, Hz."""
    aiding_hz: RateHz = 5.0
    """Rate of the messages that aid the filters, Hz."""


class RawImuConfig(_Record, frozen=True):
    """The meaning of one count of RAW_IMU on an autopilot that sends raw values; zeros refuse them."""

    accel_mps2: Scale = 0.0
    """m/s^2 a count."""
    gyro_radps: Scale = 0.0
    """rad/s a count."""
    mag_gauss: Scale = 0.0
    """gauss a count; 0: the magnetometer is not used."""


class AidingConfig(_Record, frozen=True):
    """The sources of the velocities that aid filters."""

    forward_speed: SpeedSource = "auto"
    """Source of the body velocity for the leveling filter."""
    velocity: VelocitySource = "GPS_RAW_INT"
    """Source of the velocity for the flight filter."""


class EstimateConfig(_Record, frozen=True):
    """Age limit of an estimate, and the north of its heading."""

    stale_s: Annotated[float, Meta(ge=0.05, le=60.0)] = 0.5
    """Age above which an estimate is not published, s."""
    timesync: bool = True
    """Ask the autopilot for its time, so that ages are measured."""
    declination_deg: Literal["auto"] | Annotated[float, Meta(ge=-180.0, le=180.0)] = "auto"
    """Magnetic declination, degrees, east positive; auto looks it up at the vehicle's position."""


class VerdictConfig(_Record, frozen=True):
    """When the autopilot's attitude counts as wrong; the heading's threshold is twice the tilt's."""

    tilt_deg: Literal["auto"] | Annotated[float, Meta(gt=0.0, le=90.0)] = "auto"
    """Threshold of the tilt, degrees; auto goes by the filter, see ``VerdictSettings``."""
    hold_s: Annotated[float, Meta(ge=0.0, le=60.0)] = 0.6
    """Time that a difference must last, s."""
    release: Annotated[float, Meta(gt=0.0, le=1.0)] = 0.9
    """Share of the limits below which a difference is over while the verdict is bad."""
    max_sigma_deg: Annotated[float, Meta(gt=0.0, le=90.0)] = 5.0
    """Tilt sigma of our own above which there is no verdict, degrees."""
    stale_s: Seconds = 1.0
    """Age above which an attitude of the autopilot is not compared, s."""


class StateConfig(_Record, frozen=True):
    """The state that is kept over a restart."""

    folder: StateFolder = ""
    """Folder of the file; empty takes systemd's, else the user's own."""
    calibration: bool = True
    """Whether each flight begins with the sensors' errors that earlier ones have shown; kept where systemd or
    ``folder`` names a place."""


class LogConfig(_Record, frozen=True):
    """The lines on stderr."""

    level: Literal["debug", "info", "warning", "error"] = "info"
    """The least severe level that is written."""
    format: Literal["text", "json"] = "text"
    """Lines for people, or a JSON object each."""
    status_s: Seconds = 300.0
    """Longest time between two status lines, s; one whose words change comes after 10 s at the latest."""


class RecordConfig(_Record, frozen=True):
    """Recordings of the vehicle's messages, of our own, and of the lines of the log."""

    folder: RecordFolder = ""
    """Folder of the files; empty: nothing is recorded."""
    file_mb: Megabytes = 64.0
    """A file of this size ends, MB."""
    file_s: Annotated[float, Meta(ge=10.0, le=1e6)] = 3600.0
    """A file of this age ends, s."""
    total_mb: Megabytes = 2000.0
    """All files together, MB; the oldest ones are deleted."""
    reserve_mb: Megabytes = 500.0
    """Space that stays free on the disk, MB."""


class WebConfig(_Record, frozen=True):
    """The live page, and the documents for programs beside it."""

    listen: Address = ""
    """HOST:PORT; empty: nothing is served."""
    hosts: HostNames = ()
    """Names under which it may be asked for, besides addresses and localhost."""


class Config(_Record, frozen=True):
    """The whole configuration: a table of the file for each field."""

    vehicle: VehicleConfig = VehicleConfig()
    output: OutputConfig = OutputConfig()
    link: tuple[LinkConfig, ...] = ()
    streams: StreamsConfig = StreamsConfig()
    raw_imu: RawImuConfig = RawImuConfig()
    filter: FilterConfig = FilterConfig()
    aiding: AidingConfig = AidingConfig()
    estimate: EstimateConfig = EstimateConfig()
    verdict: VerdictConfig = VerdictConfig()
    state: StateConfig = StateConfig()
    record: RecordConfig = RecordConfig()
    web: WebConfig = WebConfig()
    log: LogConfig = LogConfig()

    @property
    def keeps_state(self) -> bool:
        """Whether anything must survive a restart."""
        return any(link.signing != "off" or link.parameters for link in self.link)

    @property
    def keeps_time(self) -> bool:
        """Whether the time of our signatures must survive a restart."""
        return any(link.signing != "off" for link in self.link)

    def with_links(self, urls: tuple[str, ...]) -> Self:
        """The same with other links, each with the default outputs, for ``--link``."""
        return msgspec.structs.replace(self, link=tuple(LinkConfig(url=url) for url in urls))

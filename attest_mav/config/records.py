"""The configuration: TOML text in, frozen and checked records out. Every error names the file and the key.

The records are the reference: each field's name carries its unit, its type carries its range, and its default is
the default. configs/attest-mav.toml says what each key means, and a test keeps the two alike. No file is read here.
"""

import tomllib
from typing import Annotated, Literal, Self

import msgspec
from msgspec import Meta

from attest_mav.config.filters import FilterConfig
from attest_mav.config.link_url import parse_link
from attest_mav.config.text import check_keys, check_no_nan, readable
from attest_mav.errors import ConfigError, UsageError

SystemId = Annotated[int, Meta(ge=0, le=255)]
ComponentId = Annotated[int, Meta(ge=1, le=255)]
RateHz = Annotated[float, Meta(ge=0.01, le=1000.0)]
Seconds = Annotated[float, Meta(ge=0.1, le=3600.0)]
Scale = Annotated[float, Meta(ge=0.0, le=1.0)]
ImuMessage = Literal["RAW_IMU", "SCALED_IMU", "SCALED_IMU2", "SCALED_IMU3", "HIGHRES_IMU"]
SpeedSource = Literal[
    "auto", "airspeed", "groundspeed", "GPS_RAW_INT", "GLOBAL_POSITION_INT", "LOCAL_POSITION_NED", "none"
]
VelocitySource = Literal["GPS_RAW_INT", "GLOBAL_POSITION_INT", "LOCAL_POSITION_NED", "none"]
Output = Literal["attitude_quaternion", "attitude_quaternion_cov", "named_values"]

TAKEN_COMPONENTS = {1: "the autopilot", 190: "ground stations"}
TAKEN_SYSTEMS = {255: "ground stations"}
"""Ids that are not ours to use: autopilots and their failsafes take whoever has them for their owner."""


class _Record(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What all records share: frozen, keyword-only, no unknown keys."""


class VehicleConfig(_Record, frozen=True):
    """Which vehicle: 0 takes the only one that is heard."""

    system_id: SystemId = 0


class OutputConfig(_Record, frozen=True):
    """Under which ids we speak (system 0: the vehicle's), and how often the attitude is sent."""

    system_id: SystemId = 0
    component_id: ComponentId = 193
    rate_hz: RateHz = 20.0


class LinkConfig(_Record, frozen=True):
    """One link, and what is sent on it."""

    url: str
    publish: tuple[Output, ...] = ("attitude_quaternion",)
    yield_to_onboard: bool = True
    wait: bool = True


class StreamsConfig(_Record, frozen=True):
    """What the autopilot is asked to send. ``imu_messages``: in order of preference; empty goes by the autopilot."""

    request: bool = True
    restore: bool = False
    imu_messages: tuple[ImuMessage, ...] = ()
    imu_hz: RateHz = 50.0
    attitude_hz: RateHz = 10.0
    aiding_hz: RateHz = 5.0


class RawImuConfig(_Record, frozen=True):
    """What one count of RAW_IMU means on an autopilot that sends true raw values; zeros refuse them."""

    accel_mps2: Scale = 0.0
    gyro_radps: Scale = 0.0
    mag_gauss: Scale = 0.0


class AidingConfig(_Record, frozen=True):
    """Where filters that need them take the forward speed and the velocity from."""

    forward_speed: SpeedSource = "auto"
    velocity: VelocitySource = "GPS_RAW_INT"


class EstimateConfig(_Record, frozen=True):
    """When an estimate is too old, and what north is. ``declination_deg``: east positive, or from the position."""

    stale_s: Annotated[float, Meta(ge=0.05, le=60.0)] = 0.5
    declination_deg: Literal["auto"] | Annotated[float, Meta(ge=-180.0, le=180.0)] = "auto"


class VerdictConfig(_Record, frozen=True):
    """When the autopilot's attitude counts as wrong; the heading's threshold is twice the tilt's.

    ``tilt_deg``: auto goes by what our own attitude rests on, see ``VerdictSettings``.
    """

    tilt_deg: Literal["auto"] | Annotated[float, Meta(gt=0.0, le=90.0)] = "auto"
    hold_s: Annotated[float, Meta(ge=0.0, le=60.0)] = 0.6
    release: Annotated[float, Meta(gt=0.0, le=1.0)] = 0.9
    max_sigma_deg: Annotated[float, Meta(gt=0.0, le=90.0)] = 5.0
    stale_s: Seconds = 1.0


class LogConfig(_Record, frozen=True):
    """What goes to stderr, and how often the status line does."""

    level: Literal["debug", "info", "warning", "error"] = "info"
    status_s: Seconds = 10.0


class Config(_Record, frozen=True):
    """Everything that can be configured."""

    vehicle: VehicleConfig = VehicleConfig()
    output: OutputConfig = OutputConfig()
    link: tuple[LinkConfig, ...] = ()
    streams: StreamsConfig = StreamsConfig()
    raw_imu: RawImuConfig = RawImuConfig()
    filter: FilterConfig = FilterConfig()
    aiding: AidingConfig = AidingConfig()
    estimate: EstimateConfig = EstimateConfig()
    verdict: VerdictConfig = VerdictConfig()
    log: LogConfig = LogConfig()

    def with_links(self, urls: tuple[str, ...]) -> Self:
        """The same with other links, each with the default outputs: what ``--link`` means."""
        return msgspec.structs.replace(self, link=tuple(LinkConfig(url=url) for url in urls))


def parse_config(text: str, name: str) -> Config:
    """Check the TOML ``text`` of the file ``name``; ConfigError says in one line what is wrong with which key."""
    try:
        config = _read(text, name)
    except RecursionError:
        raise ConfigError(f"{name}: nested too deeply; expected tables with values in them") from None
    _check_links(config, name)
    _check_ids(config.output, name)
    if (config.raw_imu.accel_mps2 == 0.0) != (config.raw_imu.gyro_radps == 0.0):
        raise ConfigError(f"{name}: raw_imu: accel_mps2 and gyro_radps go together; give both or neither")
    return config


def _read(text: str, name: str) -> Config:
    """Text to records; ConfigError. RecursionError when it is nested deeper than Python's stack."""
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{name}: not valid TOML: {error}") from None
    try:
        check_keys(data, Config, "")
        check_no_nan(data, "")
        return msgspec.convert(data, Config)
    except msgspec.ValidationError as error:
        raise ConfigError(f"{name}: {readable(str(error), data, Config)}") from None
    except ValueError as error:
        raise ConfigError(f"{name}: {error}") from None


def _check_links(config: Config, name: str) -> None:
    for index, link in enumerate(config.link):
        try:
            parse_link(link.url)
        except UsageError as error:
            raise ConfigError(f"{name}: link[{index}].url: {error}") from None


def _check_ids(output: OutputConfig, name: str) -> None:
    """ConfigError for ids under which we would be taken for somebody else."""
    for key, value, taken in (
        ("component_id", output.component_id, TAKEN_COMPONENTS),
        ("system_id", output.system_id, TAKEN_SYSTEMS),
    ):
        if value in taken:
            raise ConfigError(f"{name}: output.{key}: {value} belongs to {taken[value]}; choose another, such as 193")

"""The vehicle, its clock and its inertial sensors as records of a snapshot."""

from dataclasses import dataclass

from attest_mav.estimate import Estimate
from attest_mav.innovation import Innovation
from attest_mav.types import EarthField, VehicleKind, Version
from attest_mav.vehicle_settings import VehicleSettings


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
    is_calibrated: bool
    """Whether the filter goes on from sensor errors of earlier flights."""
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

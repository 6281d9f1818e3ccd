"""What is known besides the inertial samples: speed, velocity, airspeed, and whether the vehicle stands.

The leveling filter needs a forward speed. Which message gives it is a setting; ``auto`` takes what suits the vehicle:
airspeed for wings, groundspeed on ground and water, which go where they point; and for what can move sideways the GPS
velocity resolved in the body. The flight filter takes the velocity itself, from GPS_RAW_INT unless told otherwise:
GLOBAL_POSITION_INT comes out of the filter under judgement.
"""

from dataclasses import dataclass
from math import isfinite, nan, pi
from typing import Final

from attest_mav.algebra import rotate_back
from attest_mav.estimation.stillness import Stillness
from attest_mav.filters.base import Aids
from attest_mav.types import (
    AirDataSample,
    EarthField,
    HeartbeatSample,
    ImuSample,
    North,
    PositionSample,
    Quat,
    Sample,
    Vec3,
    VelocitySample,
)

STALE_NS: Final = 2_000_000_000
"""Speeds and velocities older than this, by the host's clock, are not used."""

FAST: Final = 6.0
"""m/s: neither a hand nor the wind on a parked wing does this for long."""

WINGS: Final = (1, 19, 20, 21, 22, 23, 24, 25)
"""MAV_TYPE of aeroplanes and of the VTOL kinds."""
SURFACE: Final = (10, 11)
"""MAV_TYPE of ground rovers and surface boats."""

SPEED_SOURCES: Final = (
    "auto",
    "airspeed",
    "groundspeed",
    "GPS_RAW_INT",
    "GLOBAL_POSITION_INT",
    "LOCAL_POSITION_NED",
    "none",
)
"""What ``AidSettings.forward_speed`` may be. airspeed and groundspeed are VFR_HUD's; the messages give a velocity."""


@dataclass(frozen=True)
class AidSettings:
    """forward_speed: one of ``SPEED_SOURCES``. velocity: the message whose velocity the flight filter gets, or none."""

    forward_speed: str = "auto"
    velocity: str = "GPS_RAW_INT"


class Aiding:
    """One lane's view of everything that aids its filters. ``field`` is that where the vehicle is."""

    def __init__(self, settings: AidSettings) -> None:
        self.field = EarthField()
        self._settings = settings
        self._vehicle_type = 0
        self._latitude = nan
        self._air: AirDataSample | None = None
        self._air_given: AirDataSample | None = None
        self._velocities: dict[str, VelocitySample] = {}
        self._velocity_given: VelocitySample | None = None
        self._speed_given: Sample | None = None
        self._stillness = Stillness()
        self._still = False

    @property
    def speed_source(self) -> str:
        """The source of the forward speed in use: what ``auto`` stands for on this vehicle."""
        if self._settings.forward_speed != "auto":
            return self._settings.forward_speed
        if self._vehicle_type in WINGS:
            return "airspeed"
        return "groundspeed" if self._vehicle_type in SURFACE else "GPS_RAW_INT"

    @property
    def stands(self) -> bool | None:
        """What the vehicle says of itself, see ``Stillness.stands``."""
        return self._stillness.stands

    def take(self, sample: Sample) -> None:
        """Remember a sample that is not inertial."""
        self._stillness.take(sample)
        if isinstance(sample, HeartbeatSample):
            self._vehicle_type = sample.vehicle_type
        elif isinstance(sample, AirDataSample):
            self._air = sample
        elif isinstance(sample, VelocitySample):
            self._velocities[sample.source] = sample
        elif isinstance(sample, PositionSample):
            self._latitude = sample.latitude_deg * pi / 180.0

    def advance(self, sample: ImuSample, dt_s: float) -> None:
        """Go on to the next inertial sample."""
        self._still = self._stillness.still(sample, dt_s)

    def aids(self, sample: ImuSample, q_nb: Quat, north: North) -> Aids:
        """The aids at this sample for a filter that holds this attitude."""
        velocity = self._fresh_enough(self._velocities.get(self._settings.velocity), sample)
        air = self._air if self._air is not None and sample.rx_ns - self._air.rx_ns <= STALE_NS else None
        source, (forward, side, down) = self._body_velocity(air, sample, q_nb, north)
        return Aids(
            forward,
            source is not None and isfinite(forward) and source is not self._speed_given,
            self._still,
            self._latitude,
            self.field.declination,
            velocity,
            velocity is not None and velocity is not self._velocity_given,
            air.airspeed if air is not None else nan,
            air is not None and isfinite(air.airspeed) and air is not self._air_given,
            side_speed=side,
            down_speed=down,
            inclination=self.field.inclination,
            in_place=self._in_place(air),
        )

    def _in_place(self, air: AirDataSample | None) -> bool:
        """False where the vehicle seems to be under way: it is armed, or says nothing of that and is fast."""
        armed = self._stillness.armed
        fast = air is not None and max(air.airspeed, air.groundspeed) > FAST
        return not fast if armed is None else not armed

    def given(self) -> None:
        """All filters of the lane have had this sample's aids: they are fresh no longer."""
        self._air_given = self._air
        self._velocity_given = self._velocities.get(self._settings.velocity)
        source = self.speed_source
        self._speed_given = self._air if source in ("airspeed", "groundspeed") else self._velocities.get(source)

    def _body_velocity(
        self, air: AirDataSample | None, sample: ImuSample, q_nb: Quat, north: North
    ) -> tuple[Sample | None, Vec3]:
        """The message behind the forward speed, and the velocity in the body, m/s; NaN where it is not known."""
        source = self.speed_source
        if source in ("airspeed", "groundspeed"):
            if air is None:
                return (None, (nan, nan, nan))
            across = 0.0 if self._vehicle_type in WINGS or self._vehicle_type in SURFACE else nan
            return (air, (air.airspeed if source == "airspeed" else air.groundspeed, across, across))
        velocity = self._fresh_enough(self._velocities.get(source), sample)
        if velocity is None or north == North.RELATIVE:
            return (None, (nan, nan, nan))
        v_north, v_east, _ = velocity.v_ned
        if velocity.vertical_known or air is None or not isfinite(air.climb):
            return (velocity, rotate_back(q_nb, velocity.v_ned))
        return (velocity, rotate_back(q_nb, (v_north, v_east, -air.climb)))

    def _fresh_enough(self, velocity: VelocitySample | None, sample: ImuSample) -> VelocitySample | None:
        return velocity if velocity is not None and sample.rx_ns - velocity.rx_ns <= STALE_NS else None

"""The vehicle as its messages describe it, held once for all lanes: kind, state, speeds, field and settings.

The leveling filter needs a velocity in the body. Its source is a setting; ``auto`` takes what suits the vehicle:
airspeed for wings, groundspeed on ground and water, which go where they point; and for what can move sideways the
receiver's velocity resolved in the body. The flight filter takes the velocity itself, from the receiver unless told
otherwise: GLOBAL_POSITION_INT comes out of the estimator under judgement, and so does VFR_HUD's groundspeed.
"""

from dataclasses import dataclass
from math import nan, pi
from typing import Final

from attest_mav.algebra import is_finite_number, norm, rotate_back
from attest_mav.estimation.clock_offset import ClockOffset
from attest_mav.estimation.self_report import SelfReport
from attest_mav.filters.base import Airspeed, BodyVelocity
from attest_mav.filters.calibration import SensorCalibration
from attest_mav.samples import AirDataSample, PositionSample, Sample, VelocitySample
from attest_mav.types import EarthField, North, Quat, VehicleKind, VelocityOrigin, Version
from attest_mav.vehicle_reports import EstimatorSample, FirmwareSample, HeartbeatSample, LandedSample, ParameterSample
from attest_mav.vehicle_settings import Estimator, Setting, VehicleSettings

STALE_NS: Final = 2_000_000_000
"""Speeds and velocities older than this, by the host's clock, are not used."""

FAST: Final = 6.0
"""m/s: neither a hand nor the wind on a parked wing does this for long."""

STANDING_SPEED: Final = 0.5
"""m/s: a vehicle that moves faster does not stand, however quiet its sensors: a plane in smooth cruise is as quiet as
a desk."""

CARRIED_SPEED: Final = 12.0
"""m/s: a vehicle that is not under way itself and is faster is carried (a car, a ship)."""

RECEIVER: Final = "GPS_RAW_INT"
"""The name under which users choose the receiver's own velocity, whichever message or log record carries it."""

SPEED_SOURCES: Final = (
    "auto",
    "airspeed",
    "groundspeed",
    RECEIVER,
    "GLOBAL_POSITION_INT",
    "LOCAL_POSITION_NED",
    "none",
)
"""Values of ``AidSettings.forward_speed``. airspeed and groundspeed are VFR_HUD's; the messages give a velocity."""


@dataclass(frozen=True)
class AidSettings:
    """forward_speed: one of ``SPEED_SOURCES``. velocity: the message whose velocity the flight filter gets, or none."""

    forward_speed: str = "auto"
    velocity: str = RECEIVER


class MovingBody:
    """A velocity in the body, m/s, and the sample that it was made of."""

    def __init__(self, sample: Sample, velocity: BodyVelocity) -> None:
        self.sample: Final = sample
        self.velocity: Final = velocity


class Vehicle:
    """Everything that the vehicle's other messages tell the filters. Instants are the host's, ns."""

    def __init__(self, settings: AidSettings) -> None:
        self.field = EarthField()
        """The Earth's field where the vehicle is."""
        self.settings = VehicleSettings()
        """The autopilot's settings as far as they are known."""
        self.parameters: Final[dict[Setting, str]] = {}
        """Names of the parameters that told them."""
        self.calibrations: dict[str, SensorCalibration] = {}
        """Errors of its inertial sensors by earlier flights, by the name of the sensor's message."""
        self.refuted: set[str] = set()
        """The sensors whose errors this flight has refuted."""
        self.kind = VehicleKind.UNKNOWN
        self.vehicle_type = -1
        """MAV_TYPE, -1 before the first heartbeat."""
        self.autopilot = -1
        """MAV_AUTOPILOT, -1 before the first heartbeat."""
        self.mode = 0
        """The autopilot's own number of its flight mode."""
        self.firmware: Version | None = None
        """Version of the autopilot's firmware, None while it is not known."""
        self.estimator: Estimator | None = None
        """The estimator that the autopilot said it went over to, None while it said nothing."""
        self.armed: bool | None = None
        """None while the vehicle does not say. Armed, it may be under way, whatever else is known."""
        self.landed: bool | None = None
        """The word of the autopilot's landing detector; None while it gives none."""
        self.self_report = SelfReport()
        """What the autopilot says of itself."""
        self.clock: Final = ClockOffset()
        """Its clock against the host's."""
        self.latitude = nan
        """rad, NaN while there was no position."""
        self._settings = settings
        self._air: AirDataSample | None = None
        self._airspeed: Airspeed | None = None
        """The airspeed of ``_air``, None where that does not tell it."""
        self._receiver: VelocitySample | None = None
        self._estimated: dict[str, VelocitySample] = {}
        self._speed = nan

    def refute_calibration(self, source: str) -> None:
        """The errors of this sensor by earlier flights do not hold any more."""
        self.calibrations.pop(source, None)
        self.refuted.add(source)

    def take(self, sample: Sample) -> None:
        """Remember a sample that is neither inertial nor an attitude."""
        if isinstance(sample, HeartbeatSample):
            self._take_heartbeat(sample)
        elif isinstance(sample, LandedSample):
            self.landed = sample.on_ground
        elif isinstance(sample, AirDataSample):
            self._air = sample
            known = is_finite_number(sample.airspeed)
            self._airspeed = Airspeed(sample.airspeed, sample.airspeed_source) if known else None
        elif isinstance(sample, VelocitySample):
            self._speed = norm(sample.v_ned)
            if sample.origin == VelocityOrigin.RECEIVER:
                self._receiver = sample
            else:
                self._estimated[sample.source] = sample
        elif isinstance(sample, PositionSample):
            self.latitude = sample.latitude_deg * pi / 180.0
        elif isinstance(sample, ParameterSample):
            self.settings = self.settings.updated(sample.setting, sample.value)
            self.parameters[sample.setting] = sample.name
        elif isinstance(sample, FirmwareSample):
            self.firmware = sample.version
        elif isinstance(sample, EstimatorSample):
            self.estimator = sample.estimator
        else:
            self.self_report.take(sample)

    def forget_trims(self) -> None:
        """The autopilot has booted: its trims may be others, and it began with its usual estimator and no reports."""
        self.self_report = SelfReport()
        for setting in (Setting.TRIM_X, Setting.TRIM_Y, Setting.TRIM_Z, Setting.PITCH_TRIM, Setting.HOVER_PITCH_TRIM):
            self.settings = self.settings.updated(setting, nan)
        self.estimator = None

    def forget_motion(self) -> None:
        """Whether it is armed or landed is not known: another sender may have said it."""
        self.armed = self.landed = None

    def _take_heartbeat(self, sample: HeartbeatSample) -> None:
        self.kind, self.armed, self.mode = sample.kind, sample.armed, sample.mode
        self.autopilot, self.vehicle_type = sample.autopilot, sample.vehicle_type

    @property
    def on_ground(self) -> bool:
        """True where the vehicle says that it is not under way: disarmed, or landed by its own detector.

        A receiver indoors wanders by metres per second; one that shows the speed of a car or a ship is believed.
        """
        at_rest = self.armed is False or self.landed is True
        return at_rest and not self._speed > CARRIED_SPEED

    @property
    def stands(self) -> bool | None:
        """The vehicle's own word: True when it stands, False when it moves or may move, None when it says nothing."""
        if self.on_ground:
            return True
        if is_finite_number(self._speed):
            return self._speed <= STANDING_SPEED
        return None if self.armed is None else not self.armed

    @property
    def goes_where_it_points(self) -> bool:
        """True of a wing: through the air it moves along its nose."""
        return self.kind == VehicleKind.WING

    @property
    def speed_source(self) -> str:
        """The source of the body velocity in use: on this vehicle ``auto`` stands for it."""
        if self._settings.forward_speed != "auto":
            return self._settings.forward_speed
        if self.kind == VehicleKind.WING:
            return "airspeed"
        return "groundspeed" if self.kind == VehicleKind.SURFACE else RECEIVER

    def velocity(self, now_ns: int) -> VelocitySample | None:
        """The velocity for the flight filter, None while none is fresh."""
        return self._velocity_from(self._settings.velocity, now_ns)

    def airspeed(self, now_ns: int) -> Airspeed | None:
        """The airspeed, None while none is fresh or known."""
        return None if self._air_data(now_ns) is None else self._airspeed

    def zero_mean_velocity(self, now_ns: int) -> bool:
        """False where the vehicle seems to be under way: it is armed, or says nothing of that and is fast."""
        if self.armed is not None:
            return not self.armed
        air = self._air_data(now_ns)
        return air is None or not max(air.airspeed, air.groundspeed) > FAST

    def body_velocity(self, now_ns: int, q_nb: Quat, north: North) -> MovingBody | None:
        """The velocity in the body for a filter that holds this attitude, None while none is fresh or known."""
        source = self.speed_source
        if source in ("airspeed", "groundspeed"):
            return self._body_speed(source == "airspeed", now_ns)
        velocity = self._velocity_from(source, now_ns)
        if velocity is None or north == North.RELATIVE:
            return None
        air = self._air_data(now_ns)
        v_ned = velocity.v_ned
        if not velocity.vertical_known and air is not None and is_finite_number(air.climb):
            v_ned = (v_ned[0], v_ned[1], -air.climb)
        forward, side, down = rotate_back(q_nb, v_ned)
        return MovingBody(velocity, BodyVelocity(forward, side, down))

    def _body_speed(self, through_air: bool, now_ns: int) -> MovingBody | None:
        """A speed along the nose; what can move sideways has no known motion across it."""
        air = self._air_data(now_ns)
        if air is None:
            return None
        speed = air.airspeed if through_air else air.groundspeed
        if not is_finite_number(speed):
            return None
        known = self.kind in (VehicleKind.WING, VehicleKind.SURFACE)
        return MovingBody(air, BodyVelocity(speed, lateral_known=known))

    def _velocity_from(self, source: str, now_ns: int) -> VelocitySample | None:
        """The newest velocity of a source, None while none is fresh."""
        newest = self._receiver if source == RECEIVER else self._estimated.get(source)
        return newest if newest is not None and now_ns - newest.rx_ns <= STALE_NS else None

    def _air_data(self, now_ns: int) -> AirDataSample | None:
        air = self._air
        return air if air is not None and now_ns - air.rx_ns <= STALE_NS else None

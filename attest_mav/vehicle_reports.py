"""The records of the vehicle's own reports: presence, landing, clock, parameters, firmware, estimator, health."""

from enum import IntEnum
from math import nan
from typing import Final

from mypy_extensions import mypyc_attr

from attest_mav.samples import Sample
from attest_mav.types import NO_TIME, VehicleKind, Version
from attest_mav.vehicle_settings import Estimator, Setting


@mypyc_attr(acyclic=True)  # as Sample
class HeartbeatSample(Sample):
    """HEARTBEAT: who is there.

    ``vehicle_type`` is MAV_TYPE, ``kind`` how such a vehicle moves, ``autopilot`` MAV_AUTOPILOT, ``status`` MAV_STATE,
    ``mode`` the autopilot's own number of its flight mode.
    """

    def __init__(
        self,
        source: str,
        system: int,
        component: int,
        rx_ns: int,
        vehicle_type: int,
        autopilot: int,
        armed: bool,
        status: int,
        kind: VehicleKind = VehicleKind.UNKNOWN,
        mode: int = 0,
    ) -> None:
        super().__init__(source, system, component, NO_TIME, rx_ns)
        self.vehicle_type: Final = vehicle_type
        self.kind: Final = kind
        self.autopilot: Final = autopilot
        self.armed: Final = armed
        self.status: Final = status
        self.mode: Final = mode


@mypyc_attr(acyclic=True)  # as Sample
class LandedSample(Sample):
    """EXTENDED_SYS_STATE: whether the vehicle is on the ground, by the autopilot's own landing detector."""

    def __init__(self, source: str, system: int, component: int, rx_ns: int, on_ground: bool) -> None:
        super().__init__(source, system, component, NO_TIME, rx_ns)
        self.on_ground: Final = on_ground


@mypyc_attr(acyclic=True)  # as Sample
class ClockSample(Sample):
    """SYSTEM_TIME: ``t_ns`` is time since boot, ``unix_us`` the wall clock in microseconds (0 when unknown)."""

    def __init__(self, source: str, system: int, component: int, t_ns: int, rx_ns: int, unix_us: int) -> None:
        super().__init__(source, system, component, t_ns, rx_ns)
        self.unix_us: Final = unix_us


class TimeExchange:
    """One question for the autopilot's time with its answer (TIMESYNC).

    sent_ns, rx_ns: the host's clock when the question was sent and when the answer came. autopilot_ns: the autopilot's
    in between.
    """

    def __init__(self, sent_ns: int, autopilot_ns: int, rx_ns: int) -> None:
        self.round_trip_ns: Final = rx_ns - sent_ns
        self.offset_ns: Final = (sent_ns + rx_ns) // 2 - autopilot_ns
        """Host minus autopilot, in the middle of what is possible."""
        self.rx_ns: Final = rx_ns


@mypyc_attr(acyclic=True)  # as Sample
class ParameterSample(Sample):
    """PARAM_VALUE of a parameter that tells a setting. ``name`` is the autopilot's; PARAM_VALUE carries no time.

    value: in the unit of the setting, NaN where the autopilot leaves the setting to a default that it does not tell.
    is_listed: it is part of a list of all parameters, and so no news; False for an answer and for a change.
    """

    def __init__(
        self,
        source: str,
        system: int,
        component: int,
        rx_ns: int,
        name: str,
        setting: Setting,
        value: float,
        is_listed: bool = False,
    ) -> None:
        super().__init__(source, system, component, NO_TIME, rx_ns)
        self.name: Final = name
        self.setting: Final = setting
        self.value: Final = value
        self.is_listed: Final = is_listed


@mypyc_attr(acyclic=True)  # as Sample
class FirmwareSample(Sample):
    """The version of the autopilot's firmware, as AUTOPILOT_VERSION or its first words tell it."""

    def __init__(self, source: str, system: int, component: int, rx_ns: int, version: Version) -> None:
        super().__init__(source, system, component, NO_TIME, rx_ns)
        self.version: Final = version


@mypyc_attr(acyclic=True)  # as Sample
class EstimatorSample(Sample):
    """The autopilot's word that from now on this estimator makes the attitude that it reports."""

    def __init__(self, source: str, system: int, component: int, rx_ns: int, estimator: Estimator) -> None:
        super().__init__(source, system, component, NO_TIME, rx_ns)
        self.estimator: Final = estimator


class EstimatorStatusSample(Sample):
    """The autopilot's estimator on itself: EKF_STATUS_REPORT or ESTIMATOR_STATUS.

    attitude_valid: it has an attitude. receiver_glitch, accel_error: it noticed a glitch of the receiver, or bad
    vertical accelerations. velocity, position, height, compass, airspeed: innovation test ratios, NaN where not told.
    limit: a ratio above this is bad by the autopilot's own measure.
    """

    def __init__(
        self,
        source: str,
        system: int,
        component: int,
        rx_ns: int,
        attitude_valid: bool,
        receiver_glitch: bool,
        accel_error: bool,
        velocity: float = nan,
        position: float = nan,
        height: float = nan,
        compass: float = nan,
        airspeed: float = nan,
        limit: float = 1.0,
    ) -> None:
        super().__init__(source, system, component, NO_TIME, rx_ns)
        self.attitude_valid: Final = attitude_valid
        self.receiver_glitch: Final = receiver_glitch
        self.accel_error: Final = accel_error
        self.velocity: Final = velocity
        self.position: Final = position
        self.height: Final = height
        self.compass: Final = compass
        self.airspeed: Final = airspeed
        self.limit: Final = limit


class SensorHealthSample(Sample):
    """SYS_STATUS: the parts that are present, enabled and not healthy by the autopilot's own word, in its words."""

    def __init__(self, source: str, system: int, component: int, rx_ns: int, unhealthy: tuple[str, ...]) -> None:
        super().__init__(source, system, component, NO_TIME, rx_ns)
        self.unhealthy: Final = unhealthy


class EstimatorNews(IntEnum):
    """What an autopilot's text tells of its estimator or its inertial sensors."""

    LANE_SWITCH = 0
    """Another lane of the estimator, or another estimator, makes the attitude."""
    VARIANCE = 1
    """Measurements do not fit."""
    AIDING_LOST = 2
    """A lane has no velocity or position any more."""
    RESET = 3
    """The heading was set anew."""
    SENSOR_FAILED = 4
    """A sensor was given up."""


class EstimatorNewsSample(Sample):
    """A text of the autopilot about its estimator. text: as it was sent."""

    def __init__(self, source: str, system: int, component: int, rx_ns: int, news: EstimatorNews, text: str) -> None:
        super().__init__(source, system, component, NO_TIME, rx_ns)
        self.news: Final = news
        self.text: Final = text


class TextSample(Sample):
    """A text of the autopilot for people, or an error of its log in words."""

    def __init__(self, source: str, system: int, component: int, rx_ns: int, text: str) -> None:
        super().__init__(source, system, component, NO_TIME, rx_ns)
        self.text: Final = text

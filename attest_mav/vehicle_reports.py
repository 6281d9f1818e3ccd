"""The records of the vehicle's own reports: presence, landing, clock, parameters, firmware, estimator."""

from typing import Final

from attest_mav.samples import Sample
from attest_mav.types import NO_TIME, VehicleKind, Version
from attest_mav.vehicle_settings import Estimator, Setting


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


class LandedSample(Sample):
    """EXTENDED_SYS_STATE: whether the vehicle is on the ground, by the autopilot's own landing detector."""

    def __init__(self, source: str, system: int, component: int, rx_ns: int, on_ground: bool) -> None:
        super().__init__(source, system, component, NO_TIME, rx_ns)
        self.on_ground: Final = on_ground


class ClockSample(Sample):
    """SYSTEM_TIME: ``t_ns`` is time since boot, ``unix_us`` the wall clock in microseconds (0 when unknown)."""

    def __init__(self, source: str, system: int, component: int, t_ns: int, rx_ns: int, unix_us: int) -> None:
        super().__init__(source, system, component, t_ns, rx_ns)
        self.unix_us: Final = unix_us


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


class FirmwareSample(Sample):
    """The version of the autopilot's firmware, as AUTOPILOT_VERSION or its first words tell it."""

    def __init__(self, source: str, system: int, component: int, rx_ns: int, version: Version) -> None:
        super().__init__(source, system, component, NO_TIME, rx_ns)
        self.version: Final = version


class EstimatorSample(Sample):
    """The autopilot's word that from now on this estimator makes the attitude that it reports."""

    def __init__(self, source: str, system: int, component: int, rx_ns: int, estimator: Estimator) -> None:
        super().__init__(source, system, component, NO_TIME, rx_ns)
        self.estimator: Final = estimator

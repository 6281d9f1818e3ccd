"""The readers of the vehicle's state and of its words: MODE, ARM, EV, STAT; PARM, MSG, VER, XKF4."""

from math import isfinite
from typing import Final

from attest_mav.logs.dataflash.reader import COMPONENT, SYSTEM, RecordReader
from attest_mav.logs.dataflash.units import Column
from attest_mav.mavlink.constants import (
    MAV_AUTOPILOT_ARDUPILOTMEGA,
    MAV_STATE_ACTIVE,
    MAV_STATE_STANDBY,
)
from attest_mav.mavlink.decode.autopilot_parameters import parameters_of
from attest_mav.mavlink.decode.firmware import banner_type, text_samples
from attest_mav.mavlink.decode.self_report_readers import ARDUPILOT_LIMIT
from attest_mav.mavlink.decode.vehicle_kinds import vehicle_kind
from attest_mav.samples import Sample
from attest_mav.vehicle_reports import (
    EstimatorStatusSample,
    FirmwareSample,
    HeartbeatSample,
    LandedSample,
    ParameterSample,
)

ARMED_EVENT: Final = 10
DISARMED_EVENT: Final = 11
LANDED_EVENT: Final = 18
FLYING_EVENT: Final = 28
"""Numbers of EV (AP_Logger.h, LogEvent)."""

ATTITUDE_FLAG: Final = 1
GLITCH_FLAG: Final = 1 << 14
"""Bits of SS (AP_Nav_Common.h, nav_filter_status): there is an attitude, the receiver glitches."""


class VehicleState:
    """What heartbeats would tell: the kind of vehicle, whether it is armed, its mode.

    vehicle_type: MAV_TYPE. armed: at the begin.
    """

    def __init__(self, vehicle_type: int, armed: bool) -> None:
        self.vehicle_type: Final = vehicle_type
        self.armed = armed
        self.mode = 0
        self.armed_at_first: bool | None = None
        """Whether it was armed before the first word on that; None without any."""

    def tell_armed(self, armed: bool, before: bool) -> bool:
        """The vehicle says whether it is armed, and with that whether it was before; True where this is news."""
        is_news = self.armed_at_first is None or armed != self.armed
        if self.armed_at_first is None:
            self.armed_at_first = before
        self.armed = armed
        return is_news

    def heartbeat(self, source: str, t_ns: int) -> HeartbeatSample:
        """The state as a heartbeat."""
        return HeartbeatSample(
            source,
            SYSTEM,
            COMPONENT,
            t_ns,
            self.vehicle_type,
            MAV_AUTOPILOT_ARDUPILOTMEGA,
            self.armed,
            MAV_STATE_ACTIVE if self.armed else MAV_STATE_STANDBY,
            vehicle_kind(self.vehicle_type),
            self.mode,
        )


class ModeReader(RecordReader):
    """MODE: the flight mode, by its number."""

    def __init__(self, state: VehicleState) -> None:
        super().__init__([Column("ModeNum"), Column("Mode")])
        self._state: Final = state

    def read(self, t_ns: int, numbers: list[float], texts: list[str]) -> list[Sample]:
        """One HeartbeatSample."""
        number = numbers[1] if isfinite(numbers[1]) else numbers[2]
        if not isfinite(number):
            return []
        self._state.mode = int(number)
        return [self._state.heartbeat("MODE", t_ns)]


class ArmReader(RecordReader):
    """ARM, and planes' STAT: whether the vehicle is armed."""

    def __init__(self, source: str, column: str, state: VehicleState) -> None:
        super().__init__([Column(column)])
        self._source: Final = source
        self._state: Final = state

    def read(self, t_ns: int, numbers: list[float], texts: list[str]) -> list[Sample]:
        """One HeartbeatSample where this is news. ARM is written at a change, STAT always."""
        armed = numbers[1] != 0.0
        before = armed if self._source == "STAT" else not armed
        if not isfinite(numbers[1]) or not self._state.tell_armed(armed, before):
            return []
        return [self._state.heartbeat(self._source, t_ns)]


class EventReader(RecordReader):
    """EV: arming, and the landing detector of copters."""

    def __init__(self, state: VehicleState) -> None:
        super().__init__([Column("Id")])
        self._state: Final = state

    def read(self, t_ns: int, numbers: list[float], texts: list[str]) -> list[Sample]:
        """A HeartbeatSample or a LandedSample."""
        event = numbers[1]
        if event in {ARMED_EVENT, DISARMED_EVENT}:
            self._state.tell_armed(event == ARMED_EVENT, event != ARMED_EVENT)
            return [self._state.heartbeat("EV", t_ns)]
        if event in {LANDED_EVENT, FLYING_EVENT}:
            return [LandedSample("EV", SYSTEM, COMPONENT, t_ns, event == LANDED_EVENT)]
        return []


class ParameterReader(RecordReader):
    """PARM of the parameters that tell a setting. All are written at the begin, again when arming, and at a change."""

    def __init__(self) -> None:
        super().__init__([Column("Value")], ["Name"])
        self._known: Final = {one.name: one for one in parameters_of(MAV_AUTOPILOT_ARDUPILOTMEGA)}
        self._told: Final[dict[str, float]] = {}

    def read(self, t_ns: int, numbers: list[float], texts: list[str]) -> list[Sample]:
        """One ParameterSample; a change is the second value of a parameter, and not the same again."""
        parameter = self._known.get(texts[0])
        value = None if parameter is None else parameter.value(numbers[1])
        if parameter is None or value is None:
            return []
        name = parameter.name
        is_listed = self._told.get(name, numbers[1]) == numbers[1]
        self._told[name] = numbers[1]
        return [ParameterSample("PARM", SYSTEM, COMPONENT, t_ns, name, parameter.setting, value, is_listed)]


class TextReader(RecordReader):
    """MSG: the texts that ground stations get as STATUSTEXT."""

    def __init__(self) -> None:
        super().__init__((), ["Message"])
        self.vehicle_type: int | None = None
        """MAV_TYPE by the firmware's first words, None before them."""

    def read(self, t_ns: int, numbers: list[float], texts: list[str]) -> list[Sample]:
        """The samples of ``text_samples``."""
        text = texts[0].strip()
        if self.vehicle_type is None:
            self.vehicle_type = banner_type(text)
        return text_samples("MSG", SYSTEM, COMPONENT, t_ns, text)


class VersionReader(RecordReader):
    """VER, the firmware's version, since 4.2."""

    def __init__(self) -> None:
        super().__init__([Column("Maj"), Column("Min"), Column("Pat")])

    def read(self, t_ns: int, numbers: list[float], texts: list[str]) -> list[Sample]:
        """One FirmwareSample."""
        if not isfinite(numbers[1] + numbers[2] + numbers[3]):
            return []
        version = (int(numbers[1]), int(numbers[2]), int(numbers[3]))
        return [FirmwareSample("VER", SYSTEM, COMPONENT, t_ns, version)]


class EstimatorReader(RecordReader):
    """XKF4, NKF4: the estimator on itself, of the core that flies.

    Its ratios are the variances of EKF_STATUS_REPORT; its flags (SS) have an order of their own.
    """

    def __init__(self, source: str) -> None:
        super().__init__([Column(name) for name in ("C", "SV", "SP", "SH", "SM", "SVT", "SS", "PI")])
        self._source: Final = source

    def read(self, t_ns: int, numbers: list[float], texts: list[str]) -> list[Sample]:
        """One EstimatorStatusSample; before 3.5 there is no number of the core, and the record is the primary's."""
        core, flags, primary = numbers[1], numbers[7], numbers[8]
        if not isfinite(flags) or (isfinite(core) and core != primary):
            return []
        is_valid, is_glitch = int(flags) & ATTITUDE_FLAG != 0, int(flags) & GLITCH_FLAG != 0
        return [
            EstimatorStatusSample(
                self._source,
                SYSTEM,
                COMPONENT,
                t_ns,
                is_valid,
                is_glitch,
                False,
                numbers[2],
                numbers[3],
                numbers[4],
                numbers[5],
                numbers[6],
                ARDUPILOT_LIMIT,
            )
        ]

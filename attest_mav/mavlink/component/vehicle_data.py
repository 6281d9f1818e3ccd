"""The data requested of the vehicle: inertial messages, the autopilot's attitude, aiding messages, and settings.

One inertial message is primary: the best candidate that gives samples. Those of other sensors are requested beside it.
Every other inertial message is dropped before it is decoded.
"""

from dataclasses import dataclass, field
from typing import Final

from attest_mav.mavlink.component.autopilot_settings import AutopilotSettings
from attest_mav.mavlink.component.further_imu import FurtherImu
from attest_mav.mavlink.component.imu_choice import ImuChoice, preferred_messages
from attest_mav.mavlink.component.messages_read import OTHER_MESSAGES, SELF_REPORTS
from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.component.stream import Stream, StreamRequest
from attest_mav.mavlink.component.streams import StreamManager
from attest_mav.mavlink.constants import (
    INERTIAL_MESSAGES,
    MAV_AUTOPILOT_ARDUPILOTMEGA,
    MAV_AUTOPILOT_INVALID,
    MAV_DATA_STREAM_EXTENDED_STATUS,
    MAV_DATA_STREAM_EXTRA1,
    MAV_DATA_STREAM_EXTRA2,
    MAV_DATA_STREAM_POSITION,
    MAV_DATA_STREAM_RAW_SENSORS,
    NO_DATA_STREAM,
)
from attest_mav.mavlink.decode.vehicle_kinds import vehicle_kind
from attest_mav.mavlink.dialect import Dialect
from attest_mav.types import VehicleKind
from attest_mav.vehicle_reports import ParameterSample
from attest_mav.vehicle_settings import VehicleSettings

SELF_REPORT_HZ: Final = 1.0
POSITION_MESSAGES: Final = ("GLOBAL_POSITION_INT", "LOCAL_POSITION_NED")
"""Results of the autopilot's own filter: requested only where the configuration names them."""


@dataclass(frozen=True)
class DataSettings:
    """The messages and settings requested of the vehicle, and their rates."""

    asks: bool = True
    """Whether anything is requested at all."""
    restores: bool = False
    """Whether the rates are set back to the autopilot's defaults at the end."""
    imu_messages: tuple[str, ...] = ()
    """Candidates for the primary inertial message, in order of preference; empty goes by the autopilot."""
    further_imu_messages: tuple[str, ...] | None = None
    """Inertial messages of other sensors, requested and passed on besides the primary one; None goes by the primary."""
    imu_bytes_per_s: float = 0.0
    """Limit of all inertial messages together, bytes/s; 0 for none."""
    imu_hz: float = 50.0
    """Rate of each inertial message, Hz."""
    attitude_hz: float = 10.0
    """Rate of ATTITUDE, Hz."""
    aiding_hz: float = 5.0
    """Rate of GPS_RAW_INT, VFR_HUD and the positions, Hz."""
    positions: tuple[str, ...] = ()
    """Those of ``POSITION_MESSAGES`` that are requested."""
    default_settings: VehicleSettings = field(default_factory=VehicleSettings)
    """The filter's own values of the vehicle's settings; those that are not NaN are requested."""
    identifies: bool = False
    """Whether the settings that tell a sensor from others are requested."""


class VehicleData:
    """Requests the messages, chooses the primary inertial one, and says which frames are worth decoding."""

    def __init__(self, dialect: Dialect, settings: DataSettings, notebook: Notebook) -> None:
        self.stream_manager: Final = StreamManager(settings.asks, notebook)
        self.autopilot_settings: Final = AutopilotSettings(settings.asks, settings.default_settings, notebook)
        self._dialect: Final = dialect
        self._settings: Final = settings
        self._notebook: Final = notebook
        self._imu_ids: Final = frozenset([dialect.id_of(name) for name in INERTIAL_MESSAGES])
        self._further: Final = FurtherImu(settings.further_imu_messages, settings.imu_bytes_per_s, settings.imu_hz)
        self._further_ids: frozenset[int] = frozenset()
        others = [*OTHER_MESSAGES, *settings.positions]
        self.wanted: Final = self._imu_ids | frozenset([dialect.id_of(name) for name in others])
        """Ids of all messages that can be of use."""
        self._choice: ImuChoice | None = None
        self._candidate_id = -1
        self._autopilot = MAV_AUTOPILOT_INVALID
        self._is_plane = False
        self._version_due = False

    @property
    def imu(self) -> Stream | None:
        """The stream of the primary inertial message, in use or being tried; None before there is a vehicle."""
        for stream in self.stream_manager.streams:
            if stream.message_id == self._candidate_id:
                return stream
        return None

    def vehicle_found(self, autopilot: int, vehicle_type: int, now_ns: int) -> None:
        """Request everything of a vehicle that was found, for the first time or again."""
        if self._choice is None:
            messages = list(self._settings.imu_messages) or preferred_messages(autopilot)
            self._choice = ImuChoice(messages, now_ns)
        self._autopilot = autopilot
        self._is_plane = vehicle_kind(vehicle_type) == VehicleKind.WING
        self.begin(now_ns)

    def forget(self) -> None:
        """Drop all requests: the vehicle is another one, or there is none."""
        self._choice = None
        self._candidate_id = -1
        self.stream_manager.forget()
        self.autopilot_settings.forget()

    def begin(self, now_ns: int) -> None:
        """Request everything from the beginning."""
        choice = self._choice
        if choice is None:
            return
        settings = self._settings
        streams = [
            self._primary_stream(choice.candidate),
            self._stream("ATTITUDE", settings.attitude_hz, MAV_DATA_STREAM_EXTRA1),
            self._stream("GPS_RAW_INT", settings.aiding_hz, MAV_DATA_STREAM_EXTENDED_STATUS),
            self._stream("VFR_HUD", settings.aiding_hz, MAV_DATA_STREAM_EXTRA2),
        ]
        streams += [self._stream(name, settings.aiding_hz, MAV_DATA_STREAM_POSITION) for name in settings.positions]
        streams += self._further_streams()
        streams += [
            self._stream(name, SELF_REPORT_HZ, NO_DATA_STREAM, is_optional=True)
            for name in SELF_REPORTS.get(self._autopilot, ())
        ]
        self.stream_manager.begin(streams, now_ns)
        self.autopilot_settings.begin(self._autopilot, self._is_plane, now_ns)
        self._version_due = settings.asks and self._autopilot == MAV_AUTOPILOT_ARDUPILOTMEGA

    def parameter_taken(self, sample: ParameterSample) -> bool:
        """Take note of a decoded parameter; True when it counts.

        Of a plane that hovers ATTITUDE_QUATERNION is requested too.

        In the hover its ATTITUDE shows another view of the aircraft, and not every message tells when.
        """
        hovered = self.autopilot_settings.hovers
        counts = self.autopilot_settings.received(sample)
        if self.autopilot_settings.hovers and not hovered:
            stream = self._stream("ATTITUDE_QUATERNION", self._settings.attitude_hz, NO_DATA_STREAM)
            self.stream_manager.want(stream, sample.rx_ns)
        return counts

    def take_version_request(self) -> bool:
        """True once for each vehicle, or boot of it, whose firmware decides on the form of its attitudes."""
        is_due = self._version_due
        self._version_due = False
        return is_due

    def arrived(self, message_id: int) -> bool:
        """Count a message of the vehicle; True when it is worth decoding."""
        self.stream_manager.arrived(message_id)
        if message_id == self._candidate_id or message_id not in self._imu_ids:
            return True
        return message_id in self._further_ids

    def imu_taken(self, source: str, now_ns: int) -> bool:
        """Take note of a decoded sample from this source (``RAW_IMU``, ``RAW_IMU#1``); True when it is in use."""
        is_used = (self._choice is not None and self._choice.take(source, now_ns)) or self._further.take(source)
        if is_used and self._settings.identifies:
            self.autopilot_settings.identify(source, now_ns)
        return is_used

    @property
    def further_imu(self) -> tuple[str, ...]:
        """The messages of the other sensors that are used where they come."""
        return self._further.names

    @property
    def single_imu(self) -> str:
        """Why there is one inertial sensor alone, "" where there are more, or while that is not known yet."""
        return self._further.lack(self.stream_manager.streams)

    @property
    def failed_rounds(self) -> int:
        """How often all candidates for the primary inertial message have failed in a row."""
        return 0 if self._choice is None else self._choice.rounds

    def begin_on_other_link(self, now_ns: int) -> None:
        """Request everything from the beginning, on another link."""
        choice = self._choice
        if choice is not None and not choice.chosen:
            choice.begin_round(now_ns)
        self.begin(now_ns)

    @property
    def primary_imu(self) -> str:
        """Source of the primary inertial samples, "" while there are none."""
        return "" if self._choice is None else self._choice.chosen

    def poll(self, now_ns: int) -> list[StreamRequest]:
        """The requests that are due; to be called only while the vehicle is there to answer them."""
        self._choose_imu(now_ns)
        return self.stream_manager.poll(now_ns)

    @property
    def next_deadline_ns(self) -> int | None:
        """When ``poll``, here or of the parameters, is due: 0 is at once, None never."""
        choice_ns = None if self._choice is None else self._choice.next_deadline_ns
        deadlines = [choice_ns, self.stream_manager.next_deadline_ns, self.autopilot_settings.next_deadline_ns]
        return min([due_ns for due_ns in deadlines if due_ns is not None], default=None)

    def _choose_imu(self, now_ns: int) -> None:
        """Go on to the next candidate when this one is refused, does not arrive, or has stopped."""
        choice, stream = self._choice, self.imu
        if choice is None:
            return
        before, used = choice.candidate, choice.chosen
        if not choice.poll(stream is not None and stream.refused, now_ns):
            return
        if used:
            self._notebook.warning(f"{used} has stopped; choosing an inertial message again")
        elif choice.candidate != before:
            self._notebook.info(f"{before} does not come; trying {choice.candidate}")
        self._request_imu(before, choice.candidate, now_ns)

    def _request_imu(self, before: str, primary: str, now_ns: int) -> None:
        """Request another primary message, and those of the other sensors that are not requested yet."""
        streams = [self._primary_stream(primary), *self._further_streams()]
        if before not in self._further.names:
            self.stream_manager.drop(self._dialect.id_of(before))
        self.stream_manager.drop(self._candidate_id)
        known = [stream.message_id for stream in self.stream_manager.streams]
        for stream in reversed(streams):
            if stream.message_id not in known:
                self.stream_manager.want(stream, now_ns)

    def _primary_stream(self, primary: str) -> Stream:
        """The stream of the primary inertial message; the messages of the other sensors are chosen beside it."""
        self._candidate_id = self._dialect.id_of(primary)
        self._further.begin(primary, {name: self._dialect.layout(name).size for name in INERTIAL_MESSAGES})
        self._further_ids = frozenset([self._dialect.id_of(name) for name in self._further.names])
        return self._imu_stream(primary)

    def _further_streams(self) -> list[Stream]:
        return [self._imu_stream(message, is_optional=True) for message in self._further.requested]

    def _imu_stream(self, message: str, *, is_optional: bool = False) -> Stream:
        return self._stream(message, self._settings.imu_hz, MAV_DATA_STREAM_RAW_SENSORS, is_optional=is_optional)

    def _stream(self, message: str, hz: float, group: int, *, is_optional: bool = False) -> Stream:
        return Stream(self._dialect.id_of(message), message, hz, group, is_optional)

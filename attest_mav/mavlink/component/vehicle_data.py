"""What we want from the vehicle: one inertial message, the autopilot's own attitude, and what aids a filter.

What aids a filter are messages, and settings that are parameters of the autopilot.
"""

from dataclasses import dataclass, field
from typing import Final

from attest_mav.mavlink.component.autopilot_settings import AutopilotSettings
from attest_mav.mavlink.component.imu_choice import ImuChoice, preferred_messages
from attest_mav.mavlink.component.notes import Notebook
from attest_mav.mavlink.component.stream import Stream, StreamRequest
from attest_mav.mavlink.component.streams import StreamManager
from attest_mav.mavlink.constants import (
    INERTIAL_MESSAGES,
    MAV_AUTOPILOT_INVALID,
    MAV_DATA_STREAM_EXTENDED_STATUS,
    MAV_DATA_STREAM_EXTRA1,
    MAV_DATA_STREAM_EXTRA2,
    MAV_DATA_STREAM_POSITION,
    MAV_DATA_STREAM_RAW_SENSORS,
)
from attest_mav.mavlink.dialect import Dialect
from attest_mav.types import VehicleSettings

OTHER_MESSAGES: Final = ("ATTITUDE", "ATTITUDE_QUATERNION", "GPS_RAW_INT", "VFR_HUD", "SYSTEM_TIME")
POSITION_MESSAGES: Final = ("GLOBAL_POSITION_INT", "LOCAL_POSITION_NED")
"""Come out of the autopilot's own filter: asked for only where the configuration wants them."""


@dataclass(frozen=True)
class DataSettings:
    """What is asked for.

    asks: whether anything is asked for at all; restores: whether they are set back to the autopilot's defaults at the
    end. imu_messages: in order of preference; empty goes by the autopilot. imu_hz, attitude_hz, aiding_hz: rates of
    the inertial message, of ATTITUDE, and of GPS_RAW_INT and VFR_HUD. positions: which of ``POSITION_MESSAGES`` are
    wanted besides, at the rate of the aiding ones. assumed: the vehicle's settings, of which those that are not NaN are
    asked for.
    """

    asks: bool = True
    restores: bool = False
    imu_messages: tuple[str, ...] = ()
    imu_hz: float = 50.0
    attitude_hz: float = 10.0
    aiding_hz: float = 5.0
    positions: tuple[str, ...] = ()
    default_settings: VehicleSettings = field(default_factory=VehicleSettings)


class VehicleData:
    """Asks for the messages, chooses among the inertial ones, and says which frames are worth decoding."""

    def __init__(self, dialect: Dialect, settings: DataSettings, notebook: Notebook) -> None:
        self.stream_manager: Final = StreamManager(settings.asks, notebook)
        self.autopilot_settings: Final = AutopilotSettings(settings.asks, settings.default_settings, notebook)
        self._dialect: Final = dialect
        self._settings: Final = settings
        self._notebook: Final = notebook
        self._imu_ids: Final = frozenset([dialect.id_of(name) for name in INERTIAL_MESSAGES])
        others = [*OTHER_MESSAGES, *settings.positions]
        if self.autopilot_settings.wanted:
            others.append("PARAM_VALUE")
        self.wanted: Final = self._imu_ids | frozenset([dialect.id_of(name) for name in others])
        """Ids of all that can be of use."""
        self._choice: ImuChoice | None = None
        self._candidate_id = -1
        self._autopilot = MAV_AUTOPILOT_INVALID

    @property
    def imu(self) -> Stream | None:
        """The inertial message in use or being tried, None before there is a vehicle."""
        for stream in self.stream_manager.streams:
            if stream.message_id == self._candidate_id:
                return stream
        return None

    def vehicle_found(self, autopilot: int, now_ns: int) -> None:
        """There is a vehicle, for the first time or again: ask it for everything."""
        if self._choice is None:
            messages = list(self._settings.imu_messages) or preferred_messages(autopilot)
            self._choice = ImuChoice(messages, now_ns)
        self._autopilot = autopilot
        self.begin(now_ns)

    def forget(self) -> None:
        """The vehicle is no longer the one that was asked, or there is none."""
        self._choice = None
        self._candidate_id = -1
        self.stream_manager.forget()
        self.autopilot_settings.forget()

    def begin(self, now_ns: int) -> None:
        """Ask for everything from the beginning."""
        choice = self._choice
        if choice is None:
            return
        settings = self._settings
        streams = [
            self._imu_stream(choice.candidate),
            self._stream("ATTITUDE", settings.attitude_hz, MAV_DATA_STREAM_EXTRA1),
            self._stream("GPS_RAW_INT", settings.aiding_hz, MAV_DATA_STREAM_EXTENDED_STATUS),
            self._stream("VFR_HUD", settings.aiding_hz, MAV_DATA_STREAM_EXTRA2),
        ]
        streams += [self._stream(name, settings.aiding_hz, MAV_DATA_STREAM_POSITION) for name in settings.positions]
        self.stream_manager.begin(streams, now_ns)
        self.autopilot_settings.begin(self._autopilot, now_ns)

    def arrived(self, message_id: int) -> bool:
        """Count a message of the vehicle; True when it is worth decoding."""
        self.stream_manager.arrived(message_id)
        return message_id == self._candidate_id or message_id not in self._imu_ids

    def imu_taken(self, message: str, now_ns: int) -> bool:
        """A sample of this inertial message was decoded; True when it is the one in use."""
        return self._choice is not None and self._choice.take(message, now_ns)

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
        """Go on to the next inertial message when this one is refused, does not come, or has stopped."""
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
        self.stream_manager.drop(self._candidate_id)
        self.stream_manager.want(self._imu_stream(choice.candidate), now_ns)

    def _imu_stream(self, message: str) -> Stream:
        self._candidate_id = self._dialect.id_of(message)
        return self._stream(message, self._settings.imu_hz, MAV_DATA_STREAM_RAW_SENSORS)

    def _stream(self, message: str, hz: float, group: int) -> Stream:
        return Stream(self._dialect.id_of(message), message, hz, group)

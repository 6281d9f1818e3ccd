"""The readers of the vehicle itself: HEARTBEAT, EXTENDED_SYS_STATE, SYSTEM_TIME."""

from typing import Final

from attest_mav.mavlink.constants import (
    MAV_AUTOPILOT_INVALID,
    MAV_COMP_ID_AUTOPILOT1,
    MAV_LANDED_STATE_IN_AIR,
    MAV_LANDED_STATE_LANDING,
    MAV_LANDED_STATE_ON_GROUND,
    MAV_LANDED_STATE_TAKEOFF,
    MAV_MODE_FLAG_SAFETY_ARMED,
)
from attest_mav.mavlink.decode.boot_clock import BootClock
from attest_mav.mavlink.decode.reader import Reader
from attest_mav.mavlink.decode.vehicle_kinds import vehicle_kind
from attest_mav.mavlink.dialect import Dialect
from attest_mav.mavlink.wire.frame import Frame
from attest_mav.samples import Sample
from attest_mav.vehicle_reports import ClockSample, HeartbeatSample, LandedSample

LANDED_IN_AIR: Final = (MAV_LANDED_STATE_IN_AIR, MAV_LANDED_STATE_TAKEOFF, MAV_LANDED_STATE_LANDING)


class HeartbeatReader(Reader):
    """HEARTBEAT; keeps the MAV_AUTOPILOT of every system that has one.

    The autopilot component's own word counts most: other components of a system may claim another autopilot.
    """

    def __init__(self, dialect: Dialect) -> None:
        super().__init__("HEARTBEAT")
        self.autopilots: Final[dict[int, int]] = {}
        self._fields: Final = dialect.layout(self.name).pick(
            "custom_mode", "type", "autopilot", "base_mode", "system_status"
        )

    def read(self, frame: Frame) -> list[Sample]:
        """One HeartbeatSample."""
        mode, vehicle_type, autopilot, base_mode, status = self._fields.unpack(frame.payload)
        if autopilot != MAV_AUTOPILOT_INVALID and (
            frame.component == MAV_COMP_ID_AUTOPILOT1 or frame.system not in self.autopilots
        ):
            self.autopilots[frame.system] = autopilot
        armed = base_mode & MAV_MODE_FLAG_SAFETY_ARMED != 0
        return [
            HeartbeatSample(
                self.name,
                frame.system,
                frame.component,
                frame.rx_ns,
                vehicle_type,
                autopilot,
                armed,
                status,
                vehicle_kind(vehicle_type),
                mode,
            )
        ]


class LandedReader(Reader):
    """EXTENDED_SYS_STATE: on the ground, or not; an undefined state tells nothing."""

    def __init__(self, dialect: Dialect) -> None:
        super().__init__("EXTENDED_SYS_STATE")
        self._fields: Final = dialect.layout(self.name).pick("landed_state")

    def read(self, frame: Frame) -> list[Sample]:
        """One LandedSample."""
        (state,) = self._fields.unpack(frame.payload)
        on_ground = state == MAV_LANDED_STATE_ON_GROUND
        if not (on_ground or state in LANDED_IN_AIR):
            return []
        return [LandedSample(self.name, frame.system, frame.component, frame.rx_ns, on_ground)]


class ClockReader(Reader):
    """SYSTEM_TIME, from which the boot clock learns."""

    def __init__(self, dialect: Dialect, boot_clock: BootClock) -> None:
        super().__init__("SYSTEM_TIME")
        self._boot_clock: Final = boot_clock
        self._fields: Final = dialect.layout(self.name).pick("time_unix_usec", "time_boot_ms")

    def read(self, frame: Frame) -> list[Sample]:
        """One ClockSample."""
        unix_us, boot_ms = self._fields.unpack(frame.payload)
        self._boot_clock.learn(frame.system, unix_us, boot_ms)
        t_ns: int = boot_ms * 1_000_000
        return [ClockSample(self.name, frame.system, frame.component, t_ns, frame.rx_ns, unix_us)]

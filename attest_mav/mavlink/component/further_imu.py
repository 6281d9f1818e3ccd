"""Chooses the inertial messages of the other sensors: each of them is a lane of its own beside the primary one."""

from typing import Final

from attest_mav.mavlink.component.stream import Stream
from attest_mav.mavlink.constants import OTHER_SENSORS

FRAME_OVERHEAD: Final = 12
"""Bytes of a MAVLink 2 frame around its payload."""


class FurtherImu:
    """The messages beside the primary one.

    configured: their names, None takes those of ``OTHER_SENSORS``. bytes_per_s: limit of all inertial messages
    together, 0 for none. imu_hz: the rate of each.
    """

    def __init__(self, configured: tuple[str, ...] | None, bytes_per_s: float, imu_hz: float) -> None:
        self.names: tuple[str, ...] = ()
        """The messages that are used where they come."""
        self.requested: tuple[str, ...] = ()
        """Those of them that the limit allows to request."""
        self._configured: Final = configured
        self._bytes_per_s: Final = bytes_per_s
        self._imu_hz: Final = imu_hz
        self._primary = ""
        self._heard = False

    def take(self, source: str) -> bool:
        """Take note of a decoded sample of this source; True when it is in use."""
        is_used = source.split("#", 1)[0] in self.names
        self._heard = self._heard or is_used
        return is_used

    def begin(self, primary: str, sizes: dict[str, int]) -> None:
        """Choose beside this primary message. sizes: payload of each inertial message, bytes."""
        self._primary = primary
        self._heard = False
        configured = OTHER_SENSORS.get(primary, ()) if self._configured is None else self._configured
        self.names = tuple(name for name in configured if name != primary)
        requested: list[str] = []
        total = self._imu_hz * (sizes[primary] + FRAME_OVERHEAD)
        for name in self.names:
            total += self._imu_hz * (sizes[name] + FRAME_OVERHEAD)
            if self._bytes_per_s <= 0.0 or total <= self._bytes_per_s:
                requested.append(name)
        self.requested = tuple(requested)

    def lack(self, streams: list[Stream]) -> str:
        """Why there is one inertial sensor alone, "" where there are more, or while that is not known yet."""
        if not self._primary:
            return ""
        if not self.names:
            if self._configured is None:
                return f"{self._primary} does not tell its sensor"
            return "no further_imu_messages are configured"
        if not self.requested:
            return f"imu_bytes_per_s allows {self._bytes_per_s:g}"
        asked = [stream for stream in streams if stream.name in self.requested]
        waits = any(stream.achieved_hz == 0.0 and not (stream.refused or stream.absent) for stream in asked)
        return "" if self._heard or waits else f"no {' or '.join(self.requested)} comes with readings"

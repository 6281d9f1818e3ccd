"""Which inertial message of the vehicle is used: the best one of a list that arrives and can be understood."""

from typing import Final

from attest_mav.mavlink.constants import MAV_AUTOPILOT_ARDUPILOTMEGA, MAV_AUTOPILOT_PX4

PATIENCE_NS: Final = 3_000_000_000
"""A message that was asked for and has given no sample by then gives way to the next. Five readings of a slow stream
are needed to check its units."""
LONG_PATIENCE_NS: Final = 10_000_000_000
"""The same once all have been tried in vain: nobody is asked in a hurry for ever."""
SILENCE_NS: Final = 3_000_000_000
"""The chosen message has stopped: choose again."""


def preferred_messages(autopilot: int) -> list[str]:
    """The messages to try, best first, by MAV_AUTOPILOT.

    ArduPilot's RAW_IMU is calibrated and has been there in every release. PX4's SCALED_IMU is free of PX4's own bias
    estimates, which HIGHRES_IMU has subtracted. Of the others, HIGHRES_IMU leaves the least doubt about its units.
    """
    if autopilot == MAV_AUTOPILOT_ARDUPILOTMEGA:
        return ["RAW_IMU", "SCALED_IMU", "SCALED_IMU2", "HIGHRES_IMU"]
    if autopilot == MAV_AUTOPILOT_PX4:
        return ["SCALED_IMU", "HIGHRES_IMU", "SCALED_IMU2"]
    return ["HIGHRES_IMU", "SCALED_IMU", "SCALED_IMU2", "RAW_IMU"]


class ImuChoice:
    """Tries the messages in order, round and round, until one gives samples; begins again when it stops."""

    def __init__(self, messages: list[str], now_ns: int) -> None:
        self.chosen = ""
        """The message in use, "" while there is none."""
        self._messages: Final = messages
        self._index = 0
        self._due_ns = now_ns + PATIENCE_NS
        self._patience_ns = PATIENCE_NS

    @property
    def candidate(self) -> str:
        """The message to ask for: the chosen one, or the one being tried."""
        return self._messages[self._index]

    def take(self, message: str, now_ns: int) -> bool:
        """A sample of this message was decoded; True when it is to be used."""
        if message != self.candidate:
            return False
        self.chosen = message
        self._due_ns = now_ns + SILENCE_NS
        return True

    def poll(self, refused: bool, now_ns: int) -> bool:
        """Try the next message when this one is ``refused`` or does not come; True when it is time to ask again."""
        if self.chosen:
            if now_ns < self._due_ns:
                return False
            self.chosen = ""
            self._index = 0
            self._patience_ns = PATIENCE_NS
        elif not refused and now_ns < self._due_ns:
            return False
        else:
            self._index += 1
            if self._index == len(self._messages):
                self._index = 0
                self._patience_ns = LONG_PATIENCE_NS
        self._due_ns = now_ns + self._patience_ns
        return True

    @property
    def next_deadline_ns(self) -> int:
        """When ``poll`` is due."""
        return self._due_ns

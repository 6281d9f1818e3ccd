"""Chooses the primary inertial message: the best of a list of candidates that arrives and can be decoded."""

from typing import Final

from attest_mav.mavlink.constants import MAV_AUTOPILOT_ARDUPILOTMEGA, MAV_AUTOPILOT_PX4

PATIENCE_NS: Final = 3_000_000_000
"""A candidate that has given no sample after this time is replaced by the next. Checking its units takes five readings,
also of a slow stream."""
LONG_PATIENCE_NS: Final = 10_000_000_000
"""The same time once all candidates have failed."""
SILENCE_NS: Final = 3_000_000_000
"""The chosen message has stopped after this time, and the choice begins again."""


def preferred_messages(autopilot: int) -> list[str]:
    """The candidates, best first, by MAV_AUTOPILOT.

    ArduPilot's RAW_IMU is calibrated and exists in every release. PX4's SCALED_IMU is free of PX4's own bias estimates,
    which are subtracted in HIGHRES_IMU. On other autopilots the units of HIGHRES_IMU are the most certain ones.
    """
    if autopilot == MAV_AUTOPILOT_ARDUPILOTMEGA:
        return ["RAW_IMU", "SCALED_IMU", "SCALED_IMU2", "HIGHRES_IMU"]
    if autopilot == MAV_AUTOPILOT_PX4:
        return ["SCALED_IMU", "HIGHRES_IMU", "SCALED_IMU2"]
    return ["HIGHRES_IMU", "SCALED_IMU", "SCALED_IMU2", "RAW_IMU"]


class ImuChoice:
    """Tries the candidates in order, repeatedly, until one gives samples; begins again when that one stops."""

    def __init__(self, messages: list[str], now_ns: int) -> None:
        self.chosen = ""
        """The candidate in use, "" while there is none."""
        self.rounds = 0
        """How often all candidates have failed since one was chosen last."""
        self._messages: Final = messages
        self._index = 0
        self._due_ns = now_ns + PATIENCE_NS
        self._patience_ns = PATIENCE_NS

    def begin_round(self, now_ns: int) -> None:
        """Try all candidates again from the first one, on another link."""
        self._index = 0
        self._due_ns = now_ns + PATIENCE_NS
        self._patience_ns = PATIENCE_NS

    @property
    def candidate(self) -> str:
        """The message to request: the chosen one, or the one being tried."""
        return self._messages[self._index]

    def take(self, message: str, now_ns: int) -> bool:
        """Take note of a decoded sample of this message; True when it is the candidate, which is then chosen."""
        if message != self.candidate:
            return False
        self.chosen = message
        self.rounds = 0
        self._due_ns = now_ns + SILENCE_NS
        return True

    def poll(self, refused: bool, now_ns: int) -> bool:
        """Try the next candidate when this one is ``refused`` or does not arrive; True when a request is due.

        A refused one is waited for too once all have failed: it may come without a request.
        """
        if self.chosen:
            if now_ns < self._due_ns:
                return False
            self.chosen = ""
            self._index = 0
            self._patience_ns = PATIENCE_NS
        elif now_ns < self._due_ns and not (refused and self.rounds == 0):
            return False
        else:
            self._index += 1
            if self._index == len(self._messages):
                self._index = 0
                self.rounds += 1
                self._patience_ns = LONG_PATIENCE_NS
        self._due_ns = now_ns + self._patience_ns
        return True

    @property
    def next_deadline_ns(self) -> int:
        """When ``poll`` is due."""
        return self._due_ns

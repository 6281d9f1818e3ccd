"""Another onboard computer of the vehicle, which may take our attitude for the autopilot's.

Its heartbeats are all that is known of it, and anybody can forge those. They can therefore do one thing only: replace
the output that misleads by ``ATTITUDE_QUATERNION_COV``, which no program takes for the autopilot's, at a rate of at
most ``SUBSTITUTE_NS``. Verdict, texts and heartbeat go on.
"""

from typing import Final

SILENCE_NS: Final = 5_000_000_000
"""An onboard computer that has not been heard for this long is gone."""
SUBSTITUTE_NS: Final = 200_000_000
"""Shortest period of the message that is sent in the place of the one held back."""


class OnboardWatch:
    """The onboard computer, or ground station, heard last on one link. component: its id, 0 while none is heard."""

    def __init__(self) -> None:
        self.component = 0
        self._heard_ns = 0

    def heard(self, component: int, now_ns: int) -> bool:
        """Take a heartbeat; True where no onboard computer was there before."""
        is_new = self.component == 0
        self.component = component
        self._heard_ns = now_ns
        return is_new

    def left(self, now_ns: int) -> bool:
        """True once when the last one has gone."""
        if self.component == 0 or now_ns - self._heard_ns < SILENCE_NS:
            return False
        self.component = 0
        return True

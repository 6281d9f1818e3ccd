"""Converts times that a message may give as UNIX time or as time since boot to time since boot.

RAW_IMU, HIGHRES_IMU and GPS_RAW_INT may carry either, by the definition of the message set; the size of the number
tells them apart. SYSTEM_TIME carries both, and so gives the UNIX time of the boot.
"""

from typing import Final

UNIX_US: Final = 10**15
"""From here on microseconds are UNIX time (it was 2001): no vehicle has been up for 31 years."""
LATEST_US: Final = 1 << 53
"""Microseconds that no clock reaches (the year 2255); less keeps nanoseconds within 64 bits."""
MOVED_US: Final = 1_000_000
"""SYSTEM_TIME has milliseconds only: a boot that seems to move by less than this has not moved."""

IMPOSSIBLE: Final = -1
UNKNOWN: Final = -2


class BootClock:
    """The UNIX time at which each system booted, us, from its SYSTEM_TIME."""

    def __init__(self) -> None:
        self._booted_us: Final[dict[int, int]] = {}

    def learn(self, system: int, unix_us: int, boot_ms: int) -> None:
        """Take one SYSTEM_TIME. A wall clock that is not set (before 2001) is ignored."""
        if not UNIX_US <= unix_us < LATEST_US:
            return
        booted_us = unix_us - 1000 * boot_ms
        known_us = self._booted_us.get(system)
        if known_us is None or abs(booted_us - known_us) >= MOVED_US:
            self._booted_us[system] = booted_us

    def since_boot_ns(self, system: int, time_us: int) -> int:
        """A message's time since boot, ns; IMPOSSIBLE, or UNKNOWN while the time of the boot is not known."""
        if time_us >= LATEST_US:
            return IMPOSSIBLE
        if time_us < UNIX_US:
            return 1000 * time_us
        booted_us = self._booted_us.get(system)
        if booted_us is None:
            return UNKNOWN
        return 1000 * (time_us - booted_us) if time_us >= booted_us else IMPOSSIBLE


def time_refusal(t_ns: int, time_us: int) -> str:
    """Why ``since_boot_ns`` gave no time."""
    if t_ns == UNKNOWN:
        return "it carries UNIX time, and no SYSTEM_TIME has told yet when the vehicle booted"
    return f"its time is impossible ({time_us} us)"

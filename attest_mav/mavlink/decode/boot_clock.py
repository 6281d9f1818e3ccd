"""Converts times that a message may give as UNIX time or as time since boot to time since boot.

RAW_IMU, HIGHRES_IMU and GPS_RAW_INT may carry either, by the definition of the message set; the size of the number
tells them apart. SYSTEM_TIME carries both, and so gives the UNIX time of the boot. Some simulators have no boot but
1970: their time since boot is the UNIX time in milliseconds, cut to 32 bits, which SYSTEM_TIME shows even while its own
UNIX time is zero.
"""

from typing import Final

UNIX_US: Final = 10**15
"""From here on microseconds are UNIX time (it was 2001): no vehicle has been up for 31 years."""
LATEST_US: Final = 1 << 53
"""Microseconds that no clock reaches (the year 2255); less keeps nanoseconds within 64 bits."""
MOVED_US: Final = 1_000_000
"""SYSTEM_TIME has milliseconds only: a boot that seems to move by less than this has not moved."""

FOLD_US: Final = 1000 << 32
"""Microseconds after which a clock of 32 bits in milliseconds begins again."""
NEAR_US: Final = 10_000_000
"""A folded UNIX time this near to the last time since boot is that clock; by chance 1 in 200 000 would be."""

IMPOSSIBLE: Final = -1
UNKNOWN: Final = -2


class BootClock:
    """The UNIX time at which each system booted, us, from its SYSTEM_TIME."""

    def __init__(self) -> None:
        self._booted_us: Final[dict[int, int]] = {}
        self._boot_us: Final[dict[int, int]] = {}
        self._folded: Final[set[int]] = set()

    def learn(self, system: int, unix_us: int, boot_ms: int) -> None:
        """Take one SYSTEM_TIME. A wall clock that is not set (before 2001) gives the time since boot alone."""
        if not UNIX_US <= unix_us < LATEST_US:
            self._boot_us[system] = 1000 * boot_ms
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
            return self._folded_ns(system, time_us)
        return 1000 * (time_us - booted_us) if time_us >= booted_us else IMPOSSIBLE

    def _folded_ns(self, system: int, time_us: int) -> int:
        """The last 32 bits of a UNIX time in milliseconds, ns, if these are the time since boot; else UNKNOWN."""
        boot_us = self._boot_us.get(system)
        if system not in self._folded:
            if boot_us is None or abs((time_us - boot_us + FOLD_US // 2) % FOLD_US - FOLD_US // 2) >= NEAR_US:
                return UNKNOWN
            self._folded.add(system)
        return 1000 * (time_us % FOLD_US)


def time_refusal(t_ns: int, time_us: int) -> str:
    """Why ``since_boot_ns`` gave no time."""
    if t_ns == UNKNOWN:
        return "it carries UNIX time, and no SYSTEM_TIME has told yet when the vehicle booted"
    return f"its time is impossible ({time_us} us)"

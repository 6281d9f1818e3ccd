"""The largest error of a flight with its instant, and the time of day of an instant."""

from typing import Final

from attest_mav.replay.log_time import LogTime
from attest_mav.samples import Sample
from attest_mav.vehicle_reports import ClockSample

FIRST_UNIX_US: Final = 1_000_000_000_000_000
"""An earlier UNIX time (2001) is that of a clock that was not set."""


class Peak:
    """The largest absolute value so far, and its log time."""

    def __init__(self) -> None:
        self.size = -1.0
        """rad; negative before the first."""
        self.at_s = 0.0
        """Log time, s."""

    def take(self, value: float, elapsed_s: float) -> None:
        """Take the next error, rad."""
        size = abs(value)
        if size > self.size:
            self.size = size
            self.at_s = elapsed_s


class WallClock:
    """UTC over log time, by the first time that the vehicle tells."""

    def __init__(self) -> None:
        self._told: ClockSample | None = None
        self._offset_s: float | None = None

    def take(self, sample: Sample) -> None:
        """Take a sample of the vehicle."""
        if self._told is None and isinstance(sample, ClockSample) and sample.unix_us > FIRST_UNIX_US:
            self._told = sample

    def settle(self, time: LogTime) -> None:
        """Relate the time that was told to log time, once that has begun."""
        told = self._told
        if self._offset_s is None and told is not None:
            self._offset_s = told.unix_us * 1e-6 - time.at(told.t_ns)

    def unix_s(self, elapsed_s: float) -> float | None:
        """Seconds since 1970 at this log time; None where the log does not tell them."""
        return None if self._offset_s is None else self._offset_s + elapsed_s


def time_of_day(unix_s: float) -> str:
    """The time of day, UTC, for people."""
    tenths = round(unix_s * 10.0) % 864_000
    return f"{tenths // 36_000:02d}:{tenths // 600 % 60:02d}:{tenths // 10 % 60:02d}.{tenths % 10}"

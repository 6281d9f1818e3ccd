"""The date by the time of the Global Positioning System."""

from typing import Final

EPOCH_S: Final = 315_964_800
"""1980-01-06 in UNIX time, s."""
WEEK_S: Final = 604_800
LEAP_S: Final = 18
"""By which GPS time is ahead of UTC since 2017, s; 15 to 17 in the ten years before."""


def unix_us_of_week(week: int, milliseconds: int) -> int:
    """UNIX time of a week's number and the milliseconds since it began, us; right to some seconds."""
    return ((EPOCH_S + WEEK_S * week - LEAP_S) * 1000 + milliseconds) * 1000

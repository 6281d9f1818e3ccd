"""The columns of the table of compared attitudes: names, kinds and units, one row an attitude.

A row has a value for each column, None for none. New columns stand at the end, so that programs find the others where
they were.
"""

from dataclasses import dataclass
from enum import Enum
from typing import Final

from attest_mav.innovation import Aid

Value = str | float | int | None
Row = list[Value]

SCALARS: Final = (Aid.HEADING, Aid.UNIT_LENGTH)
"""Aids whose measurement is one number; others have up to three."""


class Kind(Enum):
    """The type of the values of a column."""

    TEXT = "text"
    REAL = "real"
    FLAG = "flag"


@dataclass(frozen=True)
class Column:
    """One column. decimals: of its values in text. unit: "" for none."""

    name: str
    kind: Kind
    unit: str = ""
    decimals: int = 6


def _texts(*names: str) -> tuple[Column, ...]:
    return tuple([Column(name, Kind.TEXT) for name in names])


def _reals(unit: str, *names: str) -> tuple[Column, ...]:
    return tuple([Column(name, Kind.REAL, unit) for name in names])


def _quaternion(prefix: str) -> tuple[Column, ...]:
    return tuple([Column(f"{prefix}q_{part}", Kind.REAL, "", 9) for part in "wxyz"])


def _axes(unit: str, prefix: str, suffix: str) -> tuple[Column, ...]:
    return _reals(unit, *[f"{prefix}_{axis}_{suffix}" for axis in "xyz"])


def _aid(aid: Aid) -> tuple[Column, ...]:
    name = aid.name.lower()
    return *_texts(f"{name}_fusion"), *_reals("", f"{name}_nis")


def _unit_of(aid: Aid) -> str:
    """The unit of an aid's residual, "" for a share or a unit vector."""
    if aid in (Aid.MAGNETOMETER, Aid.UNIT_LENGTH):
        return ""
    special = {Aid.ZERO_RATE: "rad/s", Aid.HEADING: "rad", Aid.GRAVITY: "m/s^2 or none"}
    return special.get(aid, "m/s")


def residual_names(aid: Aid) -> tuple[str, ...]:
    """The columns of an aid's residual; a velocity over ground has north, east, down in this order."""
    name = f"{aid.name.lower()}_residual"
    return (name,) if aid in SCALARS else (f"{name}_1", f"{name}_2", f"{name}_3")


COLUMNS: Final[tuple[Column, ...]] = (
    *_texts("log", "filter"),
    *_reals("s", "t_s", "time_boot_s"),
    *_reals("deg", "roll_deg", "pitch_deg", "yaw_deg"),
    *_quaternion(""),
    *_texts("north"),
    *_reals("deg", "tilt_error_deg", "heading_error_deg", "tilt_sigma_deg", "heading_sigma_deg"),
    Column("counted", Kind.FLAG),
    *[column for aid in Aid for column in _aid(aid)],
    *_reals("deg", "reference_roll_deg", "reference_pitch_deg", "reference_yaw_deg"),
    *_quaternion("reference_"),
    *_texts("lane"),
    *_axes("deg/s", "rate", "deg_s"),
    *_axes("deg/s", "gyro_bias", "deg_s"),
    *_axes("m/s^2", "accel", "m_s2"),
    *_axes("gauss", "mag", "gauss"),
    *_reals("m/s", "gnss_velocity_north_m_s", "gnss_velocity_east_m_s", "gnss_velocity_down_m_s"),
    *[column for aid in Aid for column in _reals(_unit_of(aid), *residual_names(aid))],
    *_texts("verdict", "verdict_reason"),
    *_reals("deg", "verdict_tilt_deg", "verdict_heading_deg"),
    Column("utc_s", Kind.REAL, "s", 3),
)
"""t_s counts from the first inertial sample, on the sensor's clock; counted is 1 for rows that enter the figures.

Each aid has two columns, filled in the steps in which it had something to say: the use of its measurement, and the
normalised innovation squared; its residual stands further behind. reference: the reference at the time of the row.
lane: the inertial message of the estimate, whose readings accel and mag are; rate: the body rates less the gyro bias.
gnss_velocity: filled in the first row after a fix has come. verdict: the newest one beside the filter when the estimate
was made. utc_s: UTC in seconds since 1970, empty before the log tells the date. The autopilot's own rows have attitude,
errors, reference and utc_s alone.
"""

"""Streams and rates of an autopilot's firmware, and its answers to requests for others.

Taken from ArduPilot's ``GCS_MAVLink/GCS_Common.cpp`` (set_ap_message_interval, set_message_interval) and PX4's
``mavlink_receiver.cpp`` and ``mavlink_main.cpp`` (onboard mode). Two liberties: both send SIM_STATE, the truth, beside
ATTITUDE without being asked, so that whoever listens can judge an estimate; and stream groups hold only what the
package has a use for.
"""

from dataclasses import dataclass, replace
from typing import Final

from attest_mav.errors import UsageError
from attest_mav.mavlink.constants import (
    MAV_AUTOPILOT_ARDUPILOTMEGA,
    MAV_AUTOPILOT_PX4,
    MAV_DATA_STREAM_EXTENDED_STATUS,
    MAV_DATA_STREAM_EXTRA1,
    MAV_DATA_STREAM_EXTRA2,
    MAV_DATA_STREAM_EXTRA3,
    MAV_DATA_STREAM_POSITION,
    MAV_DATA_STREAM_RAW_SENSORS,
    MAV_PARAM_TYPE_INT8,
    MAV_PARAM_TYPE_INT16,
    MAV_PARAM_TYPE_REAL32,
    MAV_RESULT_DENIED,
    MAV_RESULT_FAILED,
    MAV_SEVERITY_CRITICAL,
    MAV_SEVERITY_WARNING,
    MAV_TYPE_GROUND_ROVER,
    NO_DATA_STREAM,
)
from attest_mav.sim.receiver import GPS_DELAY_S


@dataclass(frozen=True)
class Stream:
    """A message that can be streamed: its rate after boot, its group, and whether it is one of the fast ones.

    The fast ones are inertial readings, attitudes and truth: what ``SimSettings.fast_rate_hz`` sets.
    """

    message: str
    rate_hz: float
    group: int = NO_DATA_STREAM
    fast: bool = False


@dataclass(frozen=True)
class Parameter:
    """A parameter that can be read. ``kind``: MAV_PARAM_TYPE."""

    name: str
    value: float
    kind: int


@dataclass(frozen=True)
class Personality:
    """One firmware. ``streams`` are in the order in which it sends what is due at the same time."""

    name: str
    autopilot: int
    """MAV_AUTOPILOT."""
    copter_loop_hz: int
    plane_loop_hz: int
    lowpass_hz: float | None
    """Cut-off of the filter that its inertial messages have passed; None for none."""
    mag_period_ns: int
    mag_per_mean: int
    whole_milliseconds: bool
    """Intervals are whole milliseconds, and at most 80 % of the loop rate."""
    takes_groups: bool
    """REQUEST_DATA_STREAM has an effect."""
    unknown_stream: int
    """MAV_RESULT of SET_MESSAGE_INTERVAL for a message it does not have."""
    unknown_message: int
    """MAV_RESULT of REQUEST_MESSAGE for such a message."""
    streams: tuple[Stream, ...]
    parameters: tuple[Parameter, ...]
    """Settings that are true of the simulated sensors."""
    version: int
    """flight_sw_version of AUTOPILOT_VERSION: major, minor and patch number, and the kind of release, a byte each."""
    lane_texts: tuple[tuple[int, str], ...]
    """Messages sent when another lane is selected: MAV_SEVERITY, and text in which {} stands for the lane's index."""


ARDUPILOT_LOWPASS_HZ: Final = 20.0
ROVER_LOWPASS_HZ: Final = 4.0
"""ArduPilot's default on rovers and boats."""
LOWPASS_NAME: Final = "INS_GYRO_FILTER"

ARDUPILOT: Final = Personality(
    name="ardupilot",
    autopilot=MAV_AUTOPILOT_ARDUPILOTMEGA,
    copter_loop_hz=400,
    plane_loop_hz=50,
    lowpass_hz=ARDUPILOT_LOWPASS_HZ,
    mag_period_ns=100_000_000,
    mag_per_mean=10,
    whole_milliseconds=True,
    takes_groups=True,
    unknown_stream=MAV_RESULT_DENIED,
    unknown_message=MAV_RESULT_FAILED,
    streams=(
        Stream("HEARTBEAT", 1.0),
        Stream("ATTITUDE", 4.0, MAV_DATA_STREAM_EXTRA1, fast=True),
        Stream("ATTITUDE_QUATERNION", 0.0),
        Stream("GLOBAL_POSITION_INT", 4.0, MAV_DATA_STREAM_POSITION),
        Stream("VFR_HUD", 4.0, MAV_DATA_STREAM_EXTRA2),
        Stream("RAW_IMU", 4.0, MAV_DATA_STREAM_RAW_SENSORS, fast=True),
        Stream("SCALED_IMU", 0.0),
        Stream("SCALED_IMU2", 4.0, MAV_DATA_STREAM_RAW_SENSORS, fast=True),
        Stream("SCALED_IMU3", 4.0, MAV_DATA_STREAM_RAW_SENSORS),
        Stream("GPS_RAW_INT", 4.0, MAV_DATA_STREAM_EXTENDED_STATUS),
        Stream("SIM_STATE", 4.0, MAV_DATA_STREAM_EXTRA1, fast=True),
        Stream("SYSTEM_TIME", 4.0, MAV_DATA_STREAM_EXTRA3),
        Stream("AHRS2", 0.0),
        Stream("SYS_STATUS", 0.0),
        Stream("EKF_STATUS_REPORT", 0.0),
        Stream("AUTOPILOT_VERSION", 0.0),
    ),
    parameters=(
        Parameter(LOWPASS_NAME, ARDUPILOT_LOWPASS_HZ, MAV_PARAM_TYPE_INT16),
        Parameter("GPS1_DELAY_MS", 1e3 * GPS_DELAY_S, MAV_PARAM_TYPE_INT16),
        Parameter("AHRS_EKF_TYPE", 3.0, MAV_PARAM_TYPE_INT8),
        Parameter("COMPASS_AUTODEC", 1.0, MAV_PARAM_TYPE_INT8),
    ),
    version=0x040600FF,
    lane_texts=((MAV_SEVERITY_CRITICAL, "EKF3 lane switch {}"), (MAV_SEVERITY_WARNING, "EKF primary changed:{}")),
)

PX4: Final = Personality(
    name="px4",
    autopilot=MAV_AUTOPILOT_PX4,
    copter_loop_hz=250,
    plane_loop_hz=250,
    lowpass_hz=None,
    mag_period_ns=20_000_000,
    mag_per_mean=1,
    whole_milliseconds=False,
    takes_groups=False,
    unknown_stream=MAV_RESULT_FAILED,
    unknown_message=MAV_RESULT_DENIED,
    streams=(
        Stream("HEARTBEAT", 1.0),
        Stream("ATTITUDE", 50.0, fast=True),
        Stream("ATTITUDE_QUATERNION", 50.0, fast=True),
        Stream("GLOBAL_POSITION_INT", 10.0),
        Stream("VFR_HUD", 10.0),
        Stream("HIGHRES_IMU", 50.0, fast=True),
        Stream("SCALED_IMU", 50.0, fast=True),
        Stream("SCALED_IMU2", 50.0, fast=True),
        Stream("GPS_RAW_INT", 5.0),
        Stream("SIM_STATE", 50.0, fast=True),
        Stream("SYSTEM_TIME", 1.0),
        Stream("SYS_STATUS", 0.0),
        Stream("ESTIMATOR_STATUS", 0.0),
        Stream("AUTOPILOT_VERSION", 0.0),
    ),
    parameters=(Parameter("EKF2_GPS_DELAY", 1e3 * GPS_DELAY_S, MAV_PARAM_TYPE_REAL32),),
    version=0x010F00FF,
    lane_texts=(),
)

PERSONALITIES: Final = ("ardupilot", "px4")


def personality_of(name: str) -> Personality:
    """The firmware of that name; UsageError lists the names there are."""
    if name == "ardupilot":
        return ARDUPILOT
    if name == "px4":
        return PX4
    raise UsageError(f"unknown personality {name[:40]!r}: expected one of {', '.join(PERSONALITIES)}")


def with_low_pass(firmware: Personality, low_pass_hz: float) -> Personality:
    """The firmware with another low-pass on its inertial messages; the parameter that tells the corner follows."""
    told = tuple(replace(one, value=low_pass_hz) if one.name == LOWPASS_NAME else one for one in firmware.parameters)
    return replace(firmware, lowpass_hz=low_pass_hz, parameters=told)


def fitted(firmware: Personality, vehicle_type: int, low_pass_hz: float | None) -> Personality:
    """The firmware on a vehicle of this MAV_TYPE. low_pass_hz: the corner that the user chose, None for the default."""
    if low_pass_hz is not None:
        return with_low_pass(firmware, low_pass_hz)
    is_rover = firmware is ARDUPILOT and vehicle_type == MAV_TYPE_GROUND_ROVER
    return with_low_pass(firmware, ROVER_LOWPASS_HZ) if is_rover else firmware

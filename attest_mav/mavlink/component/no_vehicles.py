"""The values of MAV_TYPE in heartbeats that come from no vehicle, whatever autopilot they name."""

from typing import Final

from attest_mav.mavlink.constants import (
    MAV_TYPE_ADSB,
    MAV_TYPE_ANTENNA_TRACKER,
    MAV_TYPE_BATTERY,
    MAV_TYPE_CAMERA,
    MAV_TYPE_CHARGING_STATION,
    MAV_TYPE_FLARM,
    MAV_TYPE_GCS,
    MAV_TYPE_GIMBAL,
    MAV_TYPE_GPS,
    MAV_TYPE_GRIPPER,
    MAV_TYPE_ILLUMINATOR,
    MAV_TYPE_IMU,
    MAV_TYPE_LOG,
    MAV_TYPE_ODID,
    MAV_TYPE_ONBOARD_CONTROLLER,
    MAV_TYPE_OSD,
    MAV_TYPE_PARACHUTE,
    MAV_TYPE_SERVO,
    MAV_TYPE_WINCH,
)

NO_VEHICLES: Final = frozenset(
    [
        MAV_TYPE_ANTENNA_TRACKER,
        MAV_TYPE_GCS,
        MAV_TYPE_ONBOARD_CONTROLLER,
        MAV_TYPE_GIMBAL,
        MAV_TYPE_ADSB,
        MAV_TYPE_CAMERA,
        MAV_TYPE_CHARGING_STATION,
        MAV_TYPE_FLARM,
        MAV_TYPE_SERVO,
        MAV_TYPE_ODID,
        MAV_TYPE_BATTERY,
        MAV_TYPE_PARACHUTE,
        MAV_TYPE_LOG,
        MAV_TYPE_OSD,
        MAV_TYPE_IMU,
        MAV_TYPE_GPS,
        MAV_TYPE_WINCH,
        MAV_TYPE_ILLUMINATOR,
        MAV_TYPE_GRIPPER,
    ]
)
"""Values of MAV_TYPE that are no vehicles."""

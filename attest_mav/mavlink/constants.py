"""The numbers of MAVLink's enums that the package uses, each once, under MAVLink's own names.

A test compares every one of them with pymavlink's. They are written out because the compiler folds literals; message
ids, layouts and checksum extras come from the dialect.
"""

from typing import Final

INERTIAL_MESSAGES: Final = ("RAW_IMU", "SCALED_IMU", "HIGHRES_IMU", "SCALED_IMU2", "SCALED_IMU3")
"""The messages with gyro and accelerometer, in the order in which they are listed, and chosen from where nothing is
known of the autopilot: the three of the first sensor, then those of the second and the third."""
OTHER_SENSORS: Final = {
    "RAW_IMU": ("SCALED_IMU2", "SCALED_IMU3"),
    "SCALED_IMU": ("SCALED_IMU2", "SCALED_IMU3"),
    "SCALED_IMU2": ("RAW_IMU", "SCALED_IMU3"),
}
"""The messages of the other sensors, by the primary message. HIGHRES_IMU does not tell which sensor it reads.

RAW_IMU and SCALED_IMU are of one sensor, so that only one of them stands beside another."""

UINT8_MAX: Final = 255
UINT16_MAX: Final = 65535
"""Values of the fields of GPS_RAW_INT that the sender does not know, and of PARAM_VALUE.param_index for a parameter
that is no part of a list."""
MAVLINK_VERSION: Final = 3
"""Value of HEARTBEAT.mavlink_version."""

MAVLINK_MSG_ID_HEARTBEAT: Final = 0

MAV_COMP_ID_AUTOPILOT1: Final = 1
MAV_COMP_ID_MISSIONPLANNER: Final = 190

MAV_AUTOPILOT_ARDUPILOTMEGA: Final = 3
MAV_AUTOPILOT_INVALID: Final = 8
"""A component that is no flight controller: camera, gimbal, ground station, and this one."""
MAV_AUTOPILOT_PX4: Final = 12

MAV_TYPE_GENERIC: Final = 0
MAV_TYPE_FIXED_WING: Final = 1
MAV_TYPE_QUADROTOR: Final = 2
MAV_TYPE_COAXIAL: Final = 3
MAV_TYPE_HELICOPTER: Final = 4
MAV_TYPE_ANTENNA_TRACKER: Final = 5
MAV_TYPE_GCS: Final = 6
MAV_TYPE_GROUND_ROVER: Final = 10
MAV_TYPE_SURFACE_BOAT: Final = 11
MAV_TYPE_HEXAROTOR: Final = 13
MAV_TYPE_OCTOROTOR: Final = 14
MAV_TYPE_TRICOPTER: Final = 15
MAV_TYPE_ONBOARD_CONTROLLER: Final = 18
MAV_TYPE_VTOL_DUOROTOR: Final = 19
MAV_TYPE_VTOL_QUADROTOR: Final = 20
MAV_TYPE_VTOL_TILTROTOR: Final = 21
MAV_TYPE_VTOL_RESERVED2: Final = 22
MAV_TYPE_VTOL_RESERVED3: Final = 23
MAV_TYPE_VTOL_RESERVED4: Final = 24
MAV_TYPE_VTOL_RESERVED5: Final = 25
MAV_TYPE_GIMBAL: Final = 26
MAV_TYPE_ADSB: Final = 27
MAV_TYPE_DODECAROTOR: Final = 29
MAV_TYPE_CAMERA: Final = 30
MAV_TYPE_CHARGING_STATION: Final = 31
MAV_TYPE_FLARM: Final = 32
MAV_TYPE_SERVO: Final = 33
MAV_TYPE_ODID: Final = 34
MAV_TYPE_DECAROTOR: Final = 35
MAV_TYPE_BATTERY: Final = 36
MAV_TYPE_PARACHUTE: Final = 37
MAV_TYPE_LOG: Final = 38
MAV_TYPE_OSD: Final = 39
MAV_TYPE_IMU: Final = 40
MAV_TYPE_GPS: Final = 41
MAV_TYPE_WINCH: Final = 42
MAV_TYPE_GENERIC_MULTIROTOR: Final = 43
MAV_TYPE_ILLUMINATOR: Final = 44
MAV_TYPE_GRIPPER: Final = 48

MAV_MODE_FLAG_CUSTOM_MODE_ENABLED: Final = 1
MAV_MODE_FLAG_SAFETY_ARMED: Final = 128

MAV_STATE_BOOT: Final = 1
MAV_STATE_CALIBRATING: Final = 2
MAV_STATE_STANDBY: Final = 3
MAV_STATE_ACTIVE: Final = 4
MAV_STATE_CRITICAL: Final = 5
MAV_STATE_POWEROFF: Final = 7

MAV_FRAME_LOCAL_NED: Final = 1
MAV_FRAME_BODY_FRD: Final = 12
MAV_FRAME_LOCAL_FRD: Final = 20

MAV_ESTIMATOR_TYPE_UNKNOWN: Final = 0

MAV_LANDED_STATE_ON_GROUND: Final = 1
MAV_LANDED_STATE_IN_AIR: Final = 2
MAV_LANDED_STATE_TAKEOFF: Final = 3
MAV_LANDED_STATE_LANDING: Final = 4

MAV_CMD_SET_MESSAGE_INTERVAL: Final = 511
MAV_CMD_REQUEST_MESSAGE: Final = 512

MAV_RESULT_ACCEPTED: Final = 0
MAV_RESULT_TEMPORARILY_REJECTED: Final = 1
MAV_RESULT_DENIED: Final = 2
MAV_RESULT_UNSUPPORTED: Final = 3
MAV_RESULT_FAILED: Final = 4

MAV_RESULT_IN_PROGRESS: Final = 5

MAV_SEVERITY_CRITICAL: Final = 2
MAV_SEVERITY_ERROR: Final = 3
MAV_SEVERITY_WARNING: Final = 4
MAV_SEVERITY_NOTICE: Final = 5
MAV_SEVERITY_INFO: Final = 6

MAV_DATA_STREAM_RAW_SENSORS: Final = 1
MAV_DATA_STREAM_EXTENDED_STATUS: Final = 2
MAV_DATA_STREAM_POSITION: Final = 6
MAV_DATA_STREAM_EXTRA1: Final = 10
MAV_DATA_STREAM_EXTRA2: Final = 11
MAV_DATA_STREAM_EXTRA3: Final = 12
NO_DATA_STREAM: Final = -1
"""In none of REQUEST_DATA_STREAM's groups."""

MAV_PARAM_TYPE_INT8: Final = 2
MAV_PARAM_TYPE_INT16: Final = 4
MAV_PARAM_TYPE_INT32: Final = 6
MAV_PARAM_TYPE_REAL32: Final = 9

GPS_FIX_TYPE_NO_FIX: Final = 1
GPS_FIX_TYPE_3D_FIX: Final = 3

MAV_SYS_STATUS_SENSOR_3D_GYRO: Final = 0x1
MAV_SYS_STATUS_SENSOR_3D_ACCEL: Final = 0x2
MAV_SYS_STATUS_SENSOR_3D_MAG: Final = 0x4
MAV_SYS_STATUS_SENSOR_GPS: Final = 0x20
MAV_SYS_STATUS_SENSOR_3D_GYRO2: Final = 0x20000
MAV_SYS_STATUS_SENSOR_3D_ACCEL2: Final = 0x40000
MAV_SYS_STATUS_SENSOR_3D_MAG2: Final = 0x80000
MAV_SYS_STATUS_AHRS: Final = 0x200000

EKF_ATTITUDE: Final = 0x1
EKF_GPS_GLITCHING: Final = 0x8000
ESTIMATOR_ATTITUDE: Final = 0x1
ESTIMATOR_GPS_GLITCH: Final = 0x400
ESTIMATOR_ACCEL_ERROR: Final = 0x800

HIGHRES_IMU_UPDATED_ACCEL: Final = 0x007
HIGHRES_IMU_UPDATED_GYRO: Final = 0x038
HIGHRES_IMU_UPDATED_MAG: Final = 0x1C0
"""Bits of HIGHRES_IMU.fields_updated, three axes each."""

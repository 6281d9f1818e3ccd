"""Every number against pymavlink's."""

import pytest
from pymavlink.dialects.v20 import all as pymav

from attest_mav.mavlink import constants
from attest_mav.mavlink.wire import frame

OWN = {"INERTIAL_MESSAGES", "OTHER_SENSORS", "UINT8_MAX", "UINT16_MAX", "MAVLINK_VERSION", "NO_DATA_STREAM"}
"""Names that stand for no entry of an enum; tested below."""
GROUPS = {f"HIGHRES_IMU_UPDATED_{sensor}": sensor for sensor in ("ACCEL", "GYRO", "MAG")}
ENUM_NAMES = sorted(name for name in vars(constants) if name.isupper() and name not in OWN | set(GROUPS))


def test_there_are_enum_entries_to_compare():
    assert len(ENUM_NAMES) > 40


@pytest.mark.parametrize("name", ENUM_NAMES)
def test_an_enum_entry_has_mavlinks_number(name):
    assert getattr(constants, name) == getattr(pymav, name)


@pytest.mark.parametrize("name", GROUPS)
def test_a_group_of_updated_bits_is_its_three_axes(name):
    sensor = {"ACCEL": "ACC"}.get(GROUPS[name], GROUPS[name])
    bits = [getattr(pymav, f"HIGHRES_IMU_UPDATED_{axis}{sensor}") for axis in "XYZ"]
    assert getattr(constants, name) == sum(bits)


@pytest.mark.parametrize(
    ("field", "marker", "bits"),
    [("vel", "UINT16_MAX", 16), ("cog", "UINT16_MAX", 16), ("satellites_visible", "UINT8_MAX", 8)],
)
def test_a_field_of_gps_raw_int_that_is_not_known_holds_its_largest_number(field, marker, bits):
    said = pymav.MAVLink.gps_raw_int_encode.__doc__
    (line,) = [line for line in said.splitlines() if line.strip().startswith(f"{field} ")]
    assert marker in line
    assert getattr(constants, marker) == 2**bits - 1


def test_the_version_in_the_heartbeat_is_pymavlinks():
    assert pymav.MAVLink(None).heartbeat_encode(2, 3, 0, 0, 4).mavlink_version == constants.MAVLINK_VERSION


def test_no_data_stream_is_none_of_mavlinks():
    assert constants.NO_DATA_STREAM not in pymav.enums["MAV_DATA_STREAM"]


def test_the_inertial_messages_are_all_that_carry_gyro_and_accelerometer_of_a_sensor():
    axes = {f"{axis}{sensor}" for axis in "xyz" for sensor in ("acc", "gyro", "mag")}
    carriers = {message.msgname for message in pymav.mavlink_map.values() if axes <= set(message.fieldnames)}
    assert set(constants.INERTIAL_MESSAGES) == carriers - {"HIL_SENSOR"}, "HIL_SENSOR goes to an autopilot"
    assert len(set(constants.INERTIAL_MESSAGES)) == len(constants.INERTIAL_MESSAGES)


def test_a_frame_is_marked_and_measured_as_pymavlinks():
    assert (frame.MAGIC_V1, frame.MAGIC_V2) == (pymav.PROTOCOL_MARKER_V1, pymav.PROTOCOL_MARKER_V2)
    assert (frame.HEADER_V1, frame.HEADER_V2) == (pymav.HEADER_LEN_V1, pymav.HEADER_LEN_V2)
    assert (frame.SIGNATURE_BYTES, frame.SIGNED) == (pymav.MAVLINK_SIGNATURE_BLOCK_LEN, pymav.MAVLINK_IFLAG_SIGNED)

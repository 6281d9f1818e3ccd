"""PARAM_VALUE to settings: names as autopilots write them, values as they mean them, and damage."""

import math
import struct

import pytest
from pymavlink.dialects.v20 import all as pymav

from attest_mav.mavlink.decode.decoder import Decoder
from attest_mav.mavlink.wire.framer import Framer
from attest_mav.types import NO_TIME
from attest_mav.vehicle_settings import Setting

REAL32, INT32, INT16 = pymav.MAV_PARAM_TYPE_REAL32, pymav.MAV_PARAM_TYPE_INT32, pymav.MAV_PARAM_TYPE_INT16


@pytest.fixture
def hear(dialect, sender):
    """hear(name, value): the samples in a PARAM_VALUE; the name's bytes go out as they are."""
    framer, decoder = Framer(dialect, None), Decoder(dialect)

    def decode(name, value, kind=REAL32):
        (frame,) = framer.feed(sender.pack(pymav.MAVLink_param_value_message(name, value, kind, 1000, 7)), 77)
        return decoder.decode(frame)

    decode.decoder = decoder
    return decode


def as_float(number):
    """An int32 in the place of a float, as PX4 sends it."""
    return struct.unpack("<f", struct.pack("<i", number))[0]


@pytest.mark.parametrize(
    ("name", "value", "kind", "setting", "expected"),
    [
        (b"INS_GYRO_FILTER", 40.0, INT16, Setting.LOW_PASS_HZ, 40.0),
        (b"INS_GYRO_FILTER", 0.0, INT16, Setting.LOW_PASS_HZ, 0.0),
        (b"GPS_DELAY_MS", 120.0, INT16, Setting.FIX_DELAY_S, 0.12),
        (b"GPS1_DELAY_MS", 220.0, INT16, Setting.FIX_DELAY_S, 0.22),
        (b"EKF2_GPS_DELAY", 110.5, REAL32, Setting.FIX_DELAY_S, 0.1105),
        (b"EKF2_GPS_DELAY", 0.0, REAL32, Setting.FIX_DELAY_S, 0.0),
        (b"SENS_GPS0_DELAY", as_float(110), INT32, Setting.FIX_DELAY_S, 0.11),
        (b"INS_ACCEL_FILTER", 10.0, INT16, Setting.ACCEL_LOW_PASS_HZ, 10.0),
        (b"AHRS_TRIM_X", 0.0625, REAL32, Setting.TRIM_X, 0.0625),
        (b"AHRS_TRIM_Y", -0.5, REAL32, Setting.TRIM_Y, -0.5),  # set by hand, beyond the limit of the calibration
        (b"AHRS_TRIM_Z", 0.0, REAL32, Setting.TRIM_Z, 0.0),
        (b"AHRS_EKF_TYPE", 10.0, INT16, Setting.ESTIMATOR, 10.0),
        (b"PTCH_TRIM_DEG", -2.0, REAL32, Setting.PITCH_TRIM, math.radians(-2.0)),
        (b"TRIM_PITCH_CD", 250.0, INT16, Setting.PITCH_TRIM, math.radians(2.5)),
        (b"FLIGHT_OPTIONS", 264.0, INT32, Setting.FLIGHT_OPTIONS, 264.0),
        (b"Q_TRIM_PITCH", 3.0, REAL32, Setting.HOVER_PITCH_TRIM, math.radians(3.0)),
        (b"Q_ENABLE", 1.0, INT16, Setting.HOVERS, 1.0),
        (b"Q_TAILSIT_ENABLE", 1.0, INT16, Setting.TAILSITTER, 1.0),
        (b"Q_FRAME_CLASS", 10.0, INT16, Setting.HOVER_FRAME, 10.0),
        (b"COMPASS_DEC", -0.35, REAL32, Setting.DECLINATION, -0.35),
        (b"COMPASS_AUTODEC", 1.0, INT16, Setting.AUTO_DECLINATION, 1.0),
        (b"EKF2_MAG_DECL", -20.0, REAL32, Setting.DECLINATION, math.radians(-20.0)),
        (b"AHRS_ORIENTATION", 4.0, INT16, Setting.BOARD_ORIENTATION, 4.0),
        (b"SENS_BOARD_ROT", as_float(4), INT32, Setting.BOARD_ORIENTATION, 4.0),
        (b"INS_ACC_ID", 2753028.0, INT32, Setting.ACCEL_1_DEVICE, 2753028.0),
        (b"INS_ACC3OFFS_Z", -0.25, REAL32, Setting.ACCEL_3_OFFSET_Z, -0.25),
        (b"COMPASS_DEV_ID2", 97539.0, INT32, Setting.MAG_2_DEVICE, 97539.0),
        (b"COMPASS_OFS_Y", 120.0, REAL32, Setting.MAG_1_OFFSET_Y, -0.12),  # ArduPilot adds it
        (b"CAL_ACC1_ID", as_float(2753036), INT32, Setting.ACCEL_2_DEVICE, 2753036.0),
        (b"CAL_ACC0_XOFF", 0.1, REAL32, Setting.ACCEL_1_OFFSET_X, 0.1),
        (b"CAL_MAG0_ID", as_float(396809), INT32, Setting.MAG_1_DEVICE, 396809.0),
        (b"CAL_MAG2_YOFF", 0.12, REAL32, Setting.MAG_3_OFFSET_Y, 0.12),  # PX4 subtracts it
    ],
)
def test_what_autopilots_tell(hear, name, value, kind, setting, expected):
    (sample,) = hear(name, value, kind)
    assert (sample.source, sample.system, sample.component) == ("PARAM_VALUE", 1, 1)
    assert (sample.t_ns, sample.rx_ns) == (NO_TIME, 77)
    assert (sample.name, sample.setting) == (name.decode(), setting)
    assert sample.value == pytest.approx(expected, rel=1e-7, abs=1e-9)


@pytest.mark.parametrize("name", [b"GPS_DELAY_MS", b"GPS1_DELAY_MS"])
def test_ardupilots_zero_is_a_drivers_own_delay(hear, name):
    (sample,) = hear(name, 0.0, INT16)
    assert sample.setting == Setting.FIX_DELAY_S
    assert math.isnan(sample.value)


@pytest.mark.parametrize(
    ("name", "value", "kind"),
    [
        (b"INS_GYRO_FILTER", math.nan, REAL32),
        (b"INS_GYRO_FILTER", -20.0, REAL32),
        (b"INS_GYRO_FILTER", 0.5, REAL32),
        (b"INS_GYRO_FILTER", 1001.0, REAL32),
        (b"GPS_DELAY_MS", math.inf, REAL32),
        (b"GPS_DELAY_MS", -1.0, REAL32),
        (b"EKF2_GPS_DELAY", 3e38, REAL32),
        (b"SENS_GPS0_DELAY", as_float(-110), INT32),
        (b"SENS_GPS0_DELAY", as_float(5000), INT32),
        (b"AHRS_TRIM_X", math.nan, REAL32),
        (b"AHRS_TRIM_X", 4.0, REAL32),
        (b"PTCH_TRIM_DEG", 200.0, REAL32),
        (b"COMPASS_DEC", -20.0, REAL32),
        (b"INS_ACC_ID", math.nan, REAL32),
        (b"COMPASS_OFS_X", 1e6, REAL32),
    ],
)
def test_a_value_that_cannot_be_meant_is_refused(hear, name, value, kind):
    assert hear(name, value, kind) == []
    assert hear.decoder.refused == {"PARAM_VALUE": 1}
    assert name.decode() in hear.decoder.refusals["PARAM_VALUE"]


@pytest.mark.parametrize(
    "name",
    [
        b"",
        b"INS_GYRO_FILTEX",
        b"INS_GYRO_FILTERS",  # sixteen characters, and so no zero behind them
        b"INS_GYRO_FILTE",
        b"ins_gyro_filter",
        b"GPS_DELAY_MS2",
        b"GPS_DELAY_MS \0",
        b"\0GPS_DELAY_MS",
        b"\xff\xfe\x80GPS\xf0\x9f\x92",
        b"\xff" * 16,
    ],
)
def test_other_and_damaged_names_give_nothing_and_are_no_refusal(hear, name):
    assert hear(name, 50.0) == []
    assert hear.decoder.refused == {}


def test_what_stands_behind_the_zero_of_a_name_is_no_part_of_it(hear):
    (sample,) = hear(b"GPS_DELAY_MS\0\xffx\0", 150.0)
    assert sample.name == "GPS_DELAY_MS"

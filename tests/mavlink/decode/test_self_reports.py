"""What an autopilot says of itself, in frames made by pymavlink."""

import pytest
from pymavlink.dialects.v20 import all as pymav

from attest_mav.mavlink.decode.decoder import Decoder
from attest_mav.mavlink.wire.framer import Framer
from attest_mav.samples import AttitudeSample
from attest_mav.types import NO_TIME, AttitudeRole
from attest_mav.vehicle_reports import (
    EstimatorNews,
    EstimatorNewsSample,
    EstimatorSample,
    EstimatorStatusSample,
    SensorHealthSample,
    TextSample,
)

EKF_HEALTHY = pymav.EKF_ATTITUDE | pymav.EKF_VELOCITY_HORIZ | pymav.EKF_POS_HORIZ_ABS | pymav.EKF_PRED_POS_HORIZ_ABS


@pytest.fixture
def hear(dialect, sender):
    framer, decoder = Framer(dialect, None), Decoder(dialect)

    def decode(message):
        (frame,) = framer.feed(sender.pack(message), 77)
        return decoder.decode(frame)

    return decode


def test_ekf_status_report(hear):
    (sample,) = hear(pymav.MAVLink_ekf_status_report_message(EKF_HEALTHY, 0.1, 0.2, 0.3, 1.25, 0.0, 0.4))
    assert isinstance(sample, EstimatorStatusSample)
    assert (sample.source, sample.rx_ns, sample.t_ns) == ("EKF_STATUS_REPORT", 77, NO_TIME)
    assert (sample.attitude_valid, sample.receiver_glitch, sample.accel_error) == (True, False, False)
    values = (sample.velocity, sample.position, sample.height, sample.compass, sample.airspeed)
    assert values == pytest.approx((0.1, 0.2, 0.3, 1.25, 0.4))
    assert sample.limit == 0.8


@pytest.mark.parametrize(
    ("flags", "valid", "glitch"),
    [(0, False, False), (pymav.EKF_ATTITUDE, True, False), (pymav.EKF_GPS_GLITCHING | 1, True, True)],
)
def test_the_flags_of_ekf_status_report(hear, flags, valid, glitch):
    (sample,) = hear(pymav.MAVLink_ekf_status_report_message(flags, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert (sample.attitude_valid, sample.receiver_glitch) == (valid, glitch)


@pytest.mark.parametrize(
    ("flags", "valid", "glitch", "accel"),
    [
        (0, False, False, False),
        (pymav.ESTIMATOR_ATTITUDE | pymav.ESTIMATOR_GPS_GLITCH, True, True, False),
        (pymav.ESTIMATOR_ATTITUDE | pymav.ESTIMATOR_ACCEL_ERROR, True, False, True),
    ],
)
def test_estimator_status(hear, flags, valid, glitch, accel):
    message = pymav.MAVLink_estimator_status_message(5_000_000, flags, 0.1, 0.2, 0.3, 1.5, 0.5, 0.6, 1.0, 2.0)
    (sample,) = hear(message)
    assert isinstance(sample, EstimatorStatusSample)
    assert (sample.attitude_valid, sample.receiver_glitch, sample.accel_error) == (valid, glitch, accel)
    values = (sample.velocity, sample.position, sample.height, sample.compass, sample.airspeed)
    assert values == pytest.approx((0.1, 0.2, 0.3, 1.5, 0.6))
    assert sample.limit == 1.0


GYRO, ACCEL, GPS = (
    pymav.MAV_SYS_STATUS_SENSOR_3D_GYRO,
    pymav.MAV_SYS_STATUS_SENSOR_3D_ACCEL2,
    pymav.MAV_SYS_STATUS_SENSOR_GPS,
)


@pytest.mark.parametrize(
    ("present", "enabled", "health", "unhealthy"),
    [
        (GYRO | GPS, GYRO | GPS, GYRO | GPS, ()),
        (GYRO | GPS, GYRO | GPS, GPS, ("gyro",)),
        (GYRO | ACCEL, GYRO | ACCEL, 0, ("gyro", "second accelerometer")),
        (GPS, 0, 0, ()),
        (0, GPS, 0, ()),
        (pymav.MAV_SYS_STATUS_AHRS, pymav.MAV_SYS_STATUS_AHRS, 0, ("AHRS",)),
        (pymav.MAV_SYS_STATUS_SENSOR_BATTERY, pymav.MAV_SYS_STATUS_SENSOR_BATTERY, 0, ()),
    ],
)
def test_sys_status(hear, present, enabled, health, unhealthy):
    message = pymav.MAVLink_sys_status_message(present, enabled, health, 0, 12000, -1, -1, 0, 0, 0, 0, 0, 0)
    (sample,) = hear(message)
    assert isinstance(sample, SensorHealthSample)
    assert sample.unhealthy == unhealthy


@pytest.mark.parametrize(
    "message",
    [
        pymav.MAVLink_ahrs2_message(0.1, -0.2, 3.0, 0.0, 0, 0),
        pymav.MAVLink_ahrs3_message(0.1, -0.2, 3.0, 0.0, 0, 0, 0.0, 0.0, 0.0, 0.0),
    ],
)
def test_other_attitudes_of_the_autopilot_are_secondary(hear, message):
    (sample,) = hear(message)
    assert isinstance(sample, AttitudeSample)
    assert sample.role == AttitudeRole.SECONDARY
    assert sample.euler == pytest.approx((0.1, -0.2, 3.0))


@pytest.mark.parametrize(
    ("text", "news"),
    [
        (b"EKF3 lane switch 1", EstimatorNews.LANE_SWITCH),
        (b"EKF2 lane switch 0", EstimatorNews.LANE_SWITCH),
        (b"EKF primary changed:1", EstimatorNews.LANE_SWITCH),
        (b"EKF variance", EstimatorNews.VARIANCE),
        (b"EKF Failsafe: changed to LAND Mode", EstimatorNews.VARIANCE),
        (b"EKF3 IMU0 stopped aiding", EstimatorNews.AIDING_LOST),
        (b"EKF3 IMU1 emergency yaw reset", EstimatorNews.RESET),
        (b"Gyro #0 fail:  STALE!", EstimatorNews.SENSOR_FAILED),
        (b"Accel #1 fail: TIMEOUT!", EstimatorNews.SENSOR_FAILED),
        (b"MAG #0 failed:  OFF!", EstimatorNews.SENSOR_FAILED),
    ],
)
def test_a_text_about_the_estimator(hear, text, news):
    (sample,) = hear(pymav.MAVLink_statustext_message(pymav.MAV_SEVERITY_CRITICAL, text))
    assert isinstance(sample, EstimatorNewsSample)
    assert (sample.news, sample.text) == (news, text.decode())


def test_another_estimator_in_use_is_news_too(hear):
    estimator, news = hear(pymav.MAVLink_statustext_message(pymav.MAV_SEVERITY_WARNING, b"AHRS: DCM active"))
    assert isinstance(estimator, EstimatorSample)
    assert news.news == EstimatorNews.LANE_SWITCH


@pytest.mark.parametrize(
    "text", [b"EKF3 IMU0 is using GPS", b"EKF3 IMU0 initialised", b"PreArm: EKF3 not started", b"GPS 1: detected"]
)
def test_texts_about_other_matters_are_no_news(hear, text):
    (sample,) = hear(pymav.MAVLink_statustext_message(pymav.MAV_SEVERITY_INFO, text))
    assert isinstance(sample, TextSample)
    assert sample.text == text.decode()

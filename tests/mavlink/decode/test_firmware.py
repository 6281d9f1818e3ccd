"""AUTOPILOT_VERSION and STATUSTEXT: the firmware's version, and the estimator in use."""

import pytest
from pymavlink.dialects.v20 import all as pymav

from attest_mav.mavlink.decode.decoder import Decoder
from attest_mav.mavlink.wire.framer import Framer
from attest_mav.vehicle_reports import EstimatorSample, FirmwareSample, TextSample
from attest_mav.vehicle_settings import Estimator


@pytest.fixture
def hear(dialect, sender):
    framer, decoder = Framer(dialect, None), Decoder(dialect)

    def decode(message):
        (frame,) = framer.feed(sender.pack(message), 77)
        return decoder.decode(frame)

    return decode


def version_message(number):
    return pymav.MAVLink_autopilot_version_message(0, number, 0, 0, 0, [0] * 8, [0] * 8, [0] * 8, 0, 0, 0)


def text_message(text):
    return pymav.MAVLink_statustext_message(pymav.MAV_SEVERITY_INFO, text)


def test_the_version_is_in_the_upper_three_bytes(hear):
    (sample,) = hear(version_message(0x040602FF))
    assert isinstance(sample, FirmwareSample)
    assert (sample.version, sample.rx_ns) == ((4, 6, 2), 77)
    assert hear(version_message(0)) == []


@pytest.mark.parametrize(
    ("text", "version"),
    [
        (b"ArduCopter V4.1.1 (0a1b2c3d)", (4, 1, 1)),
        (b"ArduPlane V4.5.7", (4, 5, 7)),
        (b"ArduCopter V4.7.0-dev (12345678)", (4, 7, 0)),
        (b"ArduSub V4.1.2 (aabbccdd)", (4, 1, 2)),
        (b"ArduRover V4.5.0-beta3", (4, 5, 0)),
        (b"APM:Copter V3.3 (acf2e10c)", (3, 3, 0)),
        (b"Blimp V4.6.0", (4, 6, 0)),
    ],
)
def test_the_first_words_of_ardupilot(hear, text, version):
    (sample,) = hear(text_message(text))
    assert isinstance(sample, FirmwareSample)
    assert sample.version == version


@pytest.mark.parametrize(
    ("text", "estimator"),
    [
        (b"AHRS: DCM active", Estimator.DCM),
        (b"AHRS: EKF3 active", Estimator.EKF3),
        (b"AHRS: External active", Estimator.EXTERNAL),
    ],
)
def test_the_words_when_the_estimator_changes(hear, text, estimator):
    sample = hear(text_message(text))[0]
    assert isinstance(sample, EstimatorSample)
    assert sample.estimator == estimator


@pytest.mark.parametrize(
    "text", [b"ArduCopter V", b"ChibiOS: V4.1.1", b"EKF3 IMU0 is using GPS", b"AHRS: DCM", b"\xff\xfe V4.1.1"]
)
def test_other_words_tell_no_version_and_no_estimator(hear, text):
    (sample,) = hear(text_message(text))
    assert isinstance(sample, TextSample)
    assert sample.text == text.decode("ascii", "replace")


def test_an_empty_text_gives_nothing(hear):
    assert hear(text_message(b"")) == []

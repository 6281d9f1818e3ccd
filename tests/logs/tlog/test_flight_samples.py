"""Whole flights through reader and decoder: as many samples as pymavlink finds messages."""

import collections

from attest_mav.logs.tlog.reader import TlogReader
from attest_mav.mavlink.decode.decoder import Decoder
from attest_mav.vehicle_reports import EstimatorNewsSample, EstimatorSample
from attest_mav.vehicle_settings import Estimator

COPTER = {
    "HEARTBEAT": 319,
    "ATTITUDE": 15580,
    "ATTITUDE_QUATERNION": 15580,
    "GLOBAL_POSITION_INT": 15580,
    "RAW_IMU": 15580,
    "SCALED_IMU2": 15580,
    "SIMSTATE": 15580,
    "SIM_STATE": 15580,
    "VFR_HUD": 15572,
    "AHRS2": 3096,
    "LOCAL_POSITION_NED": 2726,
    "SYSTEM_TIME": 621,
    "EKF_STATUS_REPORT": 1553,
    "SYS_STATUS": 621,
    "PARAM_VALUE": 2,
}
"""Messages by type, counted once with pymavlink 2.4.50. GPS_RAW_INT apart: without a fix it gives no samples."""


def decoded(dialect, log):
    decoder = Decoder(dialect)
    return decoder, [sample for frame in TlogReader(log, dialect, decoder.wanted) for sample in decoder.decode(frame)]


def test_every_message_of_the_copter_flight_gives_its_sample(dialect, data_folder):
    decoder, samples = decoded(dialect, (data_folder / "sitl" / "copter_square.tlog").read_bytes())
    counts = collections.Counter(sample.source for sample in samples)
    gps = counts.pop("GPS_RAW_INT")
    texts = [sample for sample in samples if sample.source == "STATUSTEXT"]
    counts.pop("STATUSTEXT")
    assert counts == COPTER
    active = [text.estimator for text in texts if isinstance(text, EstimatorSample)]
    assert active == [Estimator.DCM, Estimator.EKF3]
    assert [text.text for text in texts if isinstance(text, EstimatorNewsSample)] == ["AHRS: DCM active"]
    assert gps == 2 * (15578 - decoder.refused["GPS_RAW_INT"])
    assert set(decoder.refused) == {"GPS_RAW_INT"}
    assert decoder.refusals == {}


def test_the_third_imu_of_the_plane_is_no_lane(dialect, data_folder):
    decoder, samples = decoded(dialect, (data_folder / "sitl" / "plane_circles.tlog").read_bytes())
    assert "SCALED_IMU3" not in {sample.source for sample in samples}
    assert "no accelerometer and no gyro" in decoder.refusals["SCALED_IMU3"]


def test_both_imus_of_the_cut_agree_while_the_copter_stands(dialect, copter_start):
    _, samples = decoded(dialect, copter_start)
    for source in ("RAW_IMU", "SCALED_IMU2"):
        lane = [sample for sample in samples if sample.source == source]
        assert len(lane) > 50
        for sample in lane:
            assert sample.accel[2] < -9.5
            assert max(map(abs, sample.gyro)) < 0.01
        assert lane[-1].mag is not None

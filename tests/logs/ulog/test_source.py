"""ULogs from a writer of the test's own: what a replay and the samples make of them."""

import random
import struct
from dataclasses import replace
from math import cos, isnan, radians, sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from attest_mav.errors import UnreadableDataError
from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.logs.formats import open_source
from attest_mav.logs.source import Plan
from attest_mav.logs.ulog.source import UlogSource
from attest_mav.replay.engine import replay
from attest_mav.replay.plan import make_plan
from attest_mav.replay.report import as_json
from attest_mav.replay.request import Outputs, Request, Window
from attest_mav.samples import AirDataSample, AttitudeSample, ImuSample, PositionSample, VelocitySample
from attest_mav.types import AirspeedSource, AttitudeRole, VehicleKind
from attest_mav.vehicle_reports import (
    EstimatorNewsSample,
    EstimatorStatusSample,
    FirmwareSample,
    HeartbeatSample,
    LandedSample,
    ParameterSample,
)
from attest_mav.vehicle_settings import Setting

G = 9.80665
PLAN = Plan((1, 1), "sensor_combined", "vehicle_attitude_groundtruth", "vehicle_attitude", None)
WHOLE = Request((GradientDescent(),), window=Window(skip_s=0.0))


def samples_of(data, kind=object, plan=PLAN):
    source = UlogSource(data)
    source.summary()
    return [sample for batch in source.samples(plan) for sample in batch.samples if isinstance(sample, kind)]


def times_of(data):
    """The times of the inertial samples, ms."""
    return [sample.rx_ns // 1_000_000 for sample in samples_of(data, ImuSample)]


@pytest.fixture
def log(writer):
    """A second of inertial samples, one every 4 ms from 1000 ms on."""
    writer.flags()
    for k in range(250):
        writer.add("sensor_combined", timestamp=1_000_000 + 4000 * k, accelerometer_m_s2=[0.0, 0.0, -G])
    return writer


ALL = [1000 + 4 * k for k in range(250)]


def test_an_autopilot_is_off_by_the_roll_that_the_test_wrote(writer):
    writer.flags()
    for k in range(500):
        writer.instant(1_000_000 + 4000 * k, (cos(radians(2.0)), sin(radians(2.0)), 0.0, 0.0))
    result = as_json("flight", replay(open_source(writer.data, "flight.ulg"), WHOLE, Outputs()))
    assert (result["format"], result["bad_bytes"], result["frames"]) == ("ulog", 0, len(writer.starts))
    assert result["duration_s"] == pytest.approx(499 * 0.004, abs=1e-3)
    assert result["imu"] == {"message": "sensor_combined", "samples": 500, "rate_hz": pytest.approx(250.0), "gaps": 0}
    assert result["reference"] == {"message": "vehicle_attitude_groundtruth", "samples": 500, "sigma": None}
    assert result["filters"][0]["tilt_deg"]["rms"] == pytest.approx(0.0, abs=0.01)
    assert result["autopilot"]["message"] == "vehicle_attitude"
    assert result["autopilot"]["tilt_deg"]["rms"] == pytest.approx(4.0, abs=1e-4)


def test_a_mean_is_that_of_the_middle_of_its_interval(writer):
    writer.flags()
    for k in range(6):
        turn = {"delta_angle": [0.01, 0.0, 0.0], "delta_angle_dt": 5000}
        change = {"delta_velocity": [0.0, 0.0, -0.04], "delta_velocity_dt": 4000}
        writer.add("vehicle_imu", 1, timestamp=9, timestamp_sample=20_000 + 5000 * k, **turn, **change)
    plan = Plan((1, 1), "vehicle_imu_1", None, None, None)
    sample = samples_of(writer.data, ImuSample, plan)[-1]
    assert (sample.source, sample.t_ns) == ("vehicle_imu_1", 42_500_000)
    assert sample.gyro == pytest.approx((2.0, 0.0, 0.0))
    assert sample.accel == pytest.approx((0.0, 0.0, -10.0))


def test_a_sensor_at_the_end_of_its_range_says_so(writer):
    writer.flags()
    for k in range(6):
        still = {"accelerometer_m_s2": [0.0, 0.0, -G], "accelerometer_clipping": 4 * (k == 5)}
        writer.add("sensor_combined", timestamp=4000 * k, **still)
    assert [sample.saturated for sample in samples_of(writer.data, ImuSample)] == [False] * 5 + [True]


def test_attitudes_have_the_role_of_their_topic_and_the_time_of_their_sample(writer):
    writer.flags()
    writer.instant(5000)
    own, truth = samples_of(writer.data, AttitudeSample)
    assert (own.t_ns, own.role, own.rates) == (5_000_000, AttitudeRole.AUTOPILOT, None)
    assert (truth.t_ns, truth.role) == (5_000_000, AttitudeRole.TRUTH)


def test_a_fix_of_the_blended_receiver(writer):
    writer.flags()
    place = {"lat": 473_979_000, "lon": 85_455_000, "alt": 488_000, "time_utc_usec": 1_600_000_000_000_000}
    motion = {"vel_n_m_s": 3.0, "vel_e_m_s": -4.0, "vel_d_m_s": 0.5, "vel_ned_valid": True, "s_variance_m_s": 0.25}
    writer.add("vehicle_gps_position", timestamp=1000, fix_type=2, **place, **motion)
    writer.add("vehicle_gps_position", timestamp=2000, fix_type=3, satellites_used=12, **place, **motion)
    (fix,) = samples_of(writer.data, VelocitySample)
    assert (fix.t_ns, fix.v_ned, fix.vertical_known, fix.sigma) == (2_000_000, (3.0, -4.0, 0.5), True, 0.25)
    (position,) = samples_of(writer.data, PositionSample)
    assert (position.latitude_deg, position.longitude_deg) == pytest.approx((47.3979, 8.5455))
    assert (position.satellites, position.dilution) == (12, None)
    vehicle = UlogSource(writer.data).summary().vehicles[1, 1]
    assert (vehicle.date.unix_s, vehicle.velocity_lack) == (1.6e9, "")


def test_without_a_blended_one_the_first_receiver_is_used(writer):
    writer.flags()
    place = {"latitude_deg": 47.4, "longitude_deg": 8.5, "altitude_msl_m": 400.0}
    writer.add("sensor_gps", 1, timestamp=2000, fix_type=3, vel_ned_valid=True, vel_n_m_s=1.0, **place)
    writer.add("sensor_gps", timestamp=2000, fix_type=3, vel_ned_valid=True, vel_n_m_s=2.0, **place)
    (fix,) = samples_of(writer.data, VelocitySample)
    assert (fix.source, fix.v_ned[0]) == ("sensor_gps", 2.0)
    assert samples_of(writer.data, PositionSample)[0].altitude_m == 400.0


def test_the_vehicle(writer):
    writer.flags()
    writer.keyed("I", "uint32_t ver_sw_release", struct.pack("<I", 0x010E03FF))
    writer.keyed("I", "char[3] sys_name", b"PX4")
    for t_us, arming in ((1000, 1), (2000, 1), (3000, 2)):
        writer.add("vehicle_status", timestamp=t_us, system_type=22, arming_state=arming, nav_state=4)
    for t_us, landed in ((4000, True), (5000, True), (6000, False)):
        writer.add("vehicle_land_detected", timestamp=t_us, landed=landed)
    writer.add("airspeed", timestamp=7000, indicated_airspeed_m_s=18.0, true_airspeed_m_s=20.0)
    writer.text(8000, "[sensors] Accel #1 fail:  TIMEOUT!")
    beats = samples_of(writer.data, HeartbeatSample)
    assert [(beat.armed, beat.kind, beat.mode) for beat in beats] == [
        (False, VehicleKind.WING, 4),
        (True, VehicleKind.WING, 4),
    ]
    assert [one.on_ground for one in samples_of(writer.data, LandedSample)] == [True, False]
    (air,) = samples_of(writer.data, AirDataSample)
    assert (air.airspeed, air.airspeed_source) == (20.0, AirspeedSource.SENSOR)
    (news,) = samples_of(writer.data, EstimatorNewsSample)
    assert (news.rx_ns, news.text) == (8_000_000, "Accel #1 fail:  TIMEOUT!")
    assert [one.version for one in samples_of(writer.data, FirmwareSample)] == [(1, 14, 3)]


def test_the_estimator_on_itself(writer):
    writer.flags()
    flags = 1 | 1 << 10 | 1 << 11
    writer.add("estimator_status", timestamp=9, vel_test_ratio=0.5, mag_test_ratio=2.0, solution_status_flags=flags)
    (status,) = samples_of(writer.data, EstimatorStatusSample)
    assert (status.attitude_valid, status.receiver_glitch, status.accel_error) == (True, True, True)
    assert (status.velocity, status.compass, isnan(status.height), status.limit) == (0.5, 2.0, True, 1.0)


def test_parameters_and_their_changes(writer):
    writer.flags()
    writer.parameter("EKF2_GPS_DELAY", 110.0)
    writer.parameter("SYS_AUTOSTART", 4001)
    writer.add("vehicle_status", timestamp=1000)
    writer.parameter("EKF2_GPS_DELAY", 60.0)
    told = samples_of(writer.data, ParameterSample)
    assert [(one.value, one.is_listed) for one in told] == [(pytest.approx(0.11), True), (pytest.approx(0.06), False)]
    vehicle = UlogSource(writer.data).summary().vehicles[1, 1]
    assert vehicle.settings.get(Setting.FIX_DELAY_S) == pytest.approx(0.06)
    assert vehicle.settings.get(Setting.LOW_PASS_HZ) == 0.0
    informed = VelocityAided().with_vehicle_settings(vehicle.settings).parameters
    assert (informed.fix_delay_s, informed.low_pass_hz) == (pytest.approx(0.06), 0.0)
    assert informed.mag_delay_s < VelocityAided().parameters.mag_delay_s
    chosen = VelocityAided(replace(VelocityAided().parameters, mag_delay_s=0.1))
    assert chosen.with_vehicle_settings(vehicle.settings).parameters.mag_delay_s == 0.1


def test_a_vehicle_that_says_nothing_may_be_under_way(log):
    (heartbeat,) = UlogSource(log.data).summary().vehicles[1, 1].opening
    assert (heartbeat.armed, heartbeat.autopilot) == (True, 12)


def test_nested_topics_are_passed_over(writer):
    writer.flags()
    writer.message("F", b"esc_report:uint64_t timestamp;float rpm;")
    writer.message("F", b"esc_status:uint64_t timestamp;esc_report[2] esc;uint8_t count;")
    writer.message("A", struct.pack("<BH", 0, 7) + b"esc_status")
    writer.message("D", struct.pack("<H", 7) + bytes(8 + 2 * 12 + 1))
    writer.add("sensor_combined", timestamp=4000)
    summary = UlogSource(writer.data).summary()
    assert summary.vehicles[1, 1].counts == {"esc_status": 1, "sensor_combined": 1}
    assert summary.bad_bytes == 0


def test_a_subscription_may_follow_its_own_format_at_once(log):
    log.add("vehicle_status", timestamp=1_500_000)
    summary = UlogSource(log.data).summary()
    assert (summary.messages, summary.bad_bytes) == (len(log.starts), 0)


@pytest.mark.parametrize("junk", [b"\0" * 9, b"\xff" * 700, b"boot: ok\r\n"])
def test_bytes_between_messages_cost_none(log, junk):
    at = log.starts[100]
    data = log.data[:at] + junk + log.data[at:]
    assert times_of(data) == ALL
    assert UlogSource(data).summary().bad_bytes == len(junk)


@pytest.mark.parametrize("lost", [1, 2, 3, 10, 30])
def test_bytes_lost_inside_a_message_cost_that_one(log, lost):
    at, end = log.starts[100], log.starts[101]
    data = log.data[: at + 5] + log.data[at + 5 + lost :]
    assert times_of(data) == [t for t in ALL if t != 1000 + 4 * 97]
    assert UlogSource(data).summary().bad_bytes == end - at - lost


@pytest.mark.parametrize("text", [b"\xad\x40\x31\x08\xec\xbe\x2d\xb2ready", bytes(8) + b"!A\xc0\x87\xc0$"])
def test_a_last_byte_that_seems_to_begin_a_text_belongs_to_its_message(log, text):
    """The text would end where the next message begins, but has no time, or is none."""
    at = log.starts[121]
    data = log.data[: at - 1] + bytes((1 + len(text), 0)) + b"L7" + text + log.data[at:]
    assert times_of(data) == ALL
    assert UlogSource(data).summary().bad_bytes == 3 + len(text)


def test_a_last_byte_that_seems_to_begin_data_belongs_to_its_message(log):
    """The next message lacks its first byte, and this last byte tells a length that its padding allows."""
    at, end = log.starts[121], log.starts[122]
    assert log.data[at] == 47
    data = log.data[: at - 1] + bytes((44,)) + log.data[at + 1 :]
    assert times_of(data) == [t for t in ALL if t != 1000 + 4 * 118]
    assert UlogSource(data).summary().bad_bytes == end - at - 1


def test_a_log_that_is_cut_short_is_read_to_its_last_message(log):
    data = log.data[:-7]
    assert times_of(data) == ALL[:-1]
    assert UlogSource(data).summary().bad_bytes == len(log.data) - log.starts[-1] - 7


def test_appended_data_begin_where_the_log_says(log):
    """The recorder was cut off inside a message; the rest was appended behind it."""
    whole = log.data
    cut = log.starts[150] + 8
    place = whole.index(struct.pack("<HB", 40, ord("B"))) + 3 + 16
    rest = b"".join(whole[a:b] for a, b in zip(log.starts[200:], [*log.starts[201:], len(whole)], strict=True))
    flagged = whole[: place - 8] + b"\x01" + whole[place - 7 : place] + struct.pack("<Q", cut) + whole[place + 8 : cut]
    assert times_of(flagged + rest) == [t for k, t in enumerate(ALL) if k < 147 or k >= 197]
    assert UlogSource(flagged + rest).summary().bad_bytes == 8


def test_times_that_stand_still_are_said_to(writer):
    writer.flags()
    for _ in range(100):
        writer.add("sensor_combined", timestamp=5000, accelerometer_m_s2=[0.0, 0.0, -G])
    notes = as_json("flight", replay(open_source(writer.data, "flight.ulg"), WHOLE, Outputs()))["notes"]
    assert "the times of its messages stand still: no filter can go by them" in notes


def test_what_the_recorder_has_lost_is_a_note(log):
    log.message("O", struct.pack("<H", 250))
    log.message("O", struct.pack("<H", 50))
    source = UlogSource(log.data)
    source.summary()
    assert "the recorder could not keep up 2 times, for 300 ms in all" in source.notes(PLAN)


def test_a_log_longer_than_a_window_is_read_as_one(log, monkeypatch):
    monkeypatch.setattr("attest_mav.logs.windows.WINDOW_BYTES", 777)
    assert times_of(log.data) == ALL


def test_a_log_of_a_header_alone_has_nothing():
    for data in (b"ULog\x01\x12\x35\x01", b"ULog\x01\x12\x35\x01" + bytes(8)):
        with pytest.raises(UnreadableDataError, match="no message"):
            UlogSource(data).summary()


def test_formats_that_nest_in_themselves_or_are_too_large_are_none(writer):
    writer.flags()
    writer.message("F", b"a:a x;")
    writer.message("F", b"big:uint64_t[65000] x;")
    writer.message("F", b"deep:missing x;")
    for number, topic in enumerate((b"a", b"big", b"deep", b"unheard")):
        writer.message("A", struct.pack("<BH", 0, number) + topic)
    writer.add("sensor_combined", timestamp=1000)
    assert UlogSource(writer.data).summary().vehicles[1, 1].counts == {"sensor_combined": 1}


@settings(deadline=None, max_examples=60)
@given(st.binary(max_size=2000))
def test_no_bytes_raise_anything_but_an_error_for_the_user(data):
    try:
        summary = UlogSource(b"ULog\x01\x12\x35\x01" + bytes(8) + data).summary()
    except UnreadableDataError:
        return
    assert summary.bad_bytes <= len(data)


@pytest.mark.parametrize("seed", range(20))
def test_no_damage_raises(log, seed):
    generator = random.Random(seed)
    data = bytearray(log.data)
    for _ in range(30):
        data[generator.randrange(16, len(data))] = generator.randrange(256)
    source = UlogSource(bytes(data))
    assert source.summary().bad_bytes <= len(data)
    assert sum(len(batch.samples) for batch in source.samples(PLAN)) <= 250


def test_every_sensor_of_the_vehicle_is_a_lane_unless_the_topic_does_not_tell_which_it_is(writer):
    writer.flags()
    for k in range(20):
        for number in range(2):
            mean = {"delta_velocity": [0.0, 0.0, -0.04], "delta_angle_dt": 4000, "delta_velocity_dt": 4000}
            writer.add("vehicle_imu", number, timestamp=4000 * k, timestamp_sample=4000 * k, **mean)
    plan = make_plan(UlogSource(writer.data).summary(), None, None)
    assert (plan.imu, plan.other_sensors) == ("vehicle_imu", ("vehicle_imu_1",))
    assert {one.source for one in samples_of(writer.data, ImuSample, plan)} == {"vehicle_imu", "vehicle_imu_1"}
    for k in range(40):
        writer.add("sensor_combined", timestamp=2000 * k)
    assert make_plan(UlogSource(writer.data).summary(), None, None).other_sensors == ()

"""Disturbance, limits, virtual time, real code: each test is a flight."""

import logging
import math
import re

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from attest_mav.estimation.events import Agreement
from attest_mav.mavlink.component.encoder import Encoder
from attest_mav.sim.fault_text import parse_faults
from attest_mav.sim.settings import PERFECT, SimSettings

SECOND = 1_000_000_000
BOOT, CALIBRATING, ACTIVE, CRITICAL, POWEROFF = 1, 2, 4, 5, 7

FOR_THE_FILTER = ["INS_GYRO_FILTER", "GPS1_DELAY_MS"]
FOR_THE_FRAME = ["AHRS_TRIM_X", "AHRS_TRIM_Y", "AHRS_TRIM_Z", "AHRS_EKF_TYPE", "COMPASS_DEC", "COMPASS_AUTODEC"]


def of_sensor(device, offset):
    return [device, *(offset.format(axis) for axis in "XYZ")]


FOR_THE_SENSORS = [
    "AHRS_ORIENTATION",
    *of_sensor("INS_ACC_ID", "INS_ACCOFFS_{}"),
    *of_sensor("COMPASS_DEV_ID", "COMPASS_OFS_{}"),
    *of_sensor("INS_ACC2_ID", "INS_ACC2OFFS_{}"),
    *of_sensor("COMPASS_DEV_ID2", "COMPASS_OFS2_{}"),
]
FOR_PX4S_SENSORS = [
    "SENS_BOARD_ROT",
    *of_sensor("CAL_ACC0_ID", "CAL_ACC0_{}OFF"),
    *of_sensor("CAL_MAG0_ID", "CAL_MAG0_{}OFF"),
    *of_sensor("CAL_ACC1_ID", "CAL_ACC1_{}OFF"),
    *of_sensor("CAL_MAG1_ID", "CAL_MAG1_{}OFF"),
]


def sim(scenario="still", faults=(), **settings):
    return SimSettings(scenario=scenario, fast_rate_hz=50.0, faults=parse_faults(faults), **settings)


def test_inertial_messages_in_attitude_out(flight):
    f = flight()
    f.run_until(12.0)
    f.stop()
    assert len(f.of_type("ATTITUDE_QUATERNION", 5.0, 10.0)) == pytest.approx(100, abs=2)
    tilt, heading = f.errors_deg(5.0)
    assert tilt < 1.0
    assert heading < 2.5
    assert f.states() in ([BOOT, ACTIVE, POWEROFF], [BOOT, CALIBRATING, ACTIVE, POWEROFF])


def test_the_first_attitude_comes_soon(flight):
    """The vehicle's first heartbeat is at zero."""
    f = flight()
    f.run_until(3.0)
    first_s = next(t_s for t_s, one in f.heard if one.get_type() == "ATTITUDE_QUATERNION")
    assert first_s < 0.7, "half a second of alignment, and the first checks of the units"


def test_what_is_sent_is_the_newest_sample_at_its_own_time(flight):
    f = flight("[output]\nrate_hz = 50")
    f.run_until(6.0)
    delays_ms = [
        t_s * 1000 - one.time_boot_ms for t_s, one in f.heard if one.get_type() == "ATTITUDE_QUATERNION" and t_s > 2.0
    ]
    assert max(delays_ms) <= 4.0
    assert min(delays_ms) > -0.001


def test_quaternions_are_unit_and_sign_continuous_through_turns(flight):
    f = flight("[output]\nrate_hz = 50", sim(scenario="tumbling"))
    f.run_until(20.0)
    before = None
    for message in f.of_type("ATTITUDE_QUATERNION"):
        q = (message.q1, message.q2, message.q3, message.q4)
        assert math.hypot(*q) == pytest.approx(1.0, abs=1e-5)
        if before is not None:
            assert sum(a * b for a, b in zip(q, before, strict=True)) > 0.5
        before = q
    assert before is not None


@pytest.mark.parametrize("name", ["gradient-descent", "robust-adaptive", "leveling", "velocity-aided"])
def test_every_filter_flies(flight, name):
    f = flight(f"[filter]\nname = '{name}'", sim("hover"))
    f.run_until(20.0)
    tilt, heading = f.errors_deg(5.0)
    assert len(f.of_type("ATTITUDE_QUATERNION", 15.0)) == pytest.approx(100, abs=2)
    # In a gust a copter leans and accelerates at once: a filter that takes the accelerometer for gravity sees it level.
    assert tilt < {"gradient-descent": 8.0, "velocity-aided": 1.0}.get(name, 2.5)
    assert heading < 5.0


@pytest.mark.parametrize(("personality", "message"), [("ardupilot", "RAW_IMU"), ("px4", "SCALED_IMU")])
def test_the_autopilot_decides_what_is_asked_for(flight, personality, message):
    f = flight("", sim(personality=personality))
    f.run_until(5.0)
    assert [lane.source for lane in f.snapshot().lanes] == [message, "SCALED_IMU2"]
    stream = f.snapshot().inertial_stream
    assert (stream.name, stream.answer) == (message, "accepted")
    assert stream.achieved_hz == pytest.approx(50.0, abs=1.0)


TWO_LANES = "[streams]\nfurther_imu_messages = ['SCALED_IMU2']\n"


def test_a_further_inertial_message_leaves_the_primary_one_alone(flight):
    f = flight(TWO_LANES, sim("hover"))
    f.run_until(10.0)
    seen = f.snapshot()
    rates = {stream.name: stream.achieved_hz for stream in seen.streams}
    assert rates["RAW_IMU"] == pytest.approx(50.0, abs=1.0)
    assert rates["SCALED_IMU2"] == pytest.approx(50.0, abs=1.0)
    assert seen.published_lane.source == "RAW_IMU"
    assert seen.published_lane.estimate is not None
    assert seen.samples == pytest.approx(500, abs=30), "the primary ones are counted"


@pytest.mark.parametrize("scenario", ["hover", "coordinated-turns"])
def test_without_a_usable_field_the_heading_of_px4_is_found_in_flight(flight, scenario):
    """SCALED_IMU's magnetometer is in axes of its own. Until motion has told the heading nobody is judged by it."""
    f = flight("", sim(scenario, personality="px4"))
    f.run_until(30.0)
    tilt, heading = f.errors_deg(20.0)
    assert tilt < 0.8
    assert heading < 3.0
    assert f.snapshot().verdict.verdict.agreement == Agreement.AGREE
    assert not [text for text in f.texts if "DISAGREES" in text]


def test_what_is_not_independent_is_said(flight):
    f = flight("[streams]\nimu_messages = ['HIGHRES_IMU']", sim(personality="px4"))
    f.run_until(4.0)
    line = f.status()
    assert line.split(" | ")[1].endswith("not independent of the autopilot's filter")


@pytest.mark.parametrize(("scenario", "source"), [("coordinated-turns", "airspeed"), ("hover", "GPS_RAW_INT")])
def test_the_speed_that_leveling_uses_is_said(flight, scenario, source):
    f = flight("[filter]\nname = 'leveling'", sim(scenario=scenario))
    f.run_until(4.0)
    assert f"speed from {source}" in f.status().split(" | ")


def test_an_attitude_that_is_held_back_is_said(flight):
    f = flight()
    f.run_until(3.0)
    f.service.receive(0, Encoder(f.vehicle.dialect, 1, 191).heartbeat(18, 8, 0, 4), f.now_ns)
    f.run_until(4.0)
    assert f.of_type("ATTITUDE_QUATERNION", 3.1) == []
    assert f.status().endswith("held back on udpin::0 for component 191")


def test_a_message_that_is_denied_gives_way_to_one_that_is_not(flight):
    f = flight("[streams]\nimu_messages = ['HIGHRES_IMU', 'RAW_IMU']")
    f.run_until(4.0)
    assert [lane.source for lane in f.snapshot().lanes] == ["RAW_IMU", "SCALED_IMU2"]
    assert f.of_type("ATTITUDE_QUATERNION")


def test_without_requests_what_comes_is_used(flight):
    f = flight("[streams]\nrequest = false\nimu_messages = ['SCALED_IMU3', 'SCALED_IMU2', 'RAW_IMU']")
    f.run_until(10.0)
    assert f.of_type("COMMAND_LONG") == []
    assert f.of_type("REQUEST_DATA_STREAM") == []
    assert f.of_type("ATTITUDE_QUATERNION", 9.0)


def test_when_the_imu_stops_publishing_stops_and_the_state_says_so(flight):
    f = flight("", sim(faults=["imu-silent@5+5"]))
    f.run_until(5.0)
    assert f.service.fresh(f.now_ns)
    f.run_until(9.9)
    assert not f.service.fresh(f.now_ns)
    assert f.of_type("ATTITUDE_QUATERNION", 5.1) == [], "nothing stale is sent"
    assert {beat.system_status for beat in f.of_type("HEARTBEAT", 5.6, 9.9)} == {BOOT}
    assert "RAW_IMU: no usable sample for 0.5 s" in f.texts
    assert "attitude withheld: samples stopped" in f.texts
    assert "nothing is sent: samples stopped" in f.status()
    f.run_until(14.0)
    assert f.service.fresh(f.now_ns)
    assert f.of_type("ATTITUDE_QUATERNION", 11.0)
    assert f.of_type("HEARTBEAT")[-1].system_status == ACTIVE


@pytest.mark.parametrize("stale_s", [0.1, 2.0])
def test_the_time_to_stop_is_configured(flight, stale_s):
    f = flight(f"[estimate]\nstale_s = {stale_s}", sim(faults=["imu-silent@5+15"]))
    f.run_until(5.0 + stale_s - 0.05)
    assert f.service.estimate is not None
    f.run_until(5.0 + stale_s + 0.01)
    assert f.service.estimate is None


def test_readings_that_are_not_finite_are_never_published(flight):
    f = flight(
        "[streams]\nimu_messages = ['HIGHRES_IMU']",
        sim(personality="px4", faults=["imu-nan@5+2"]),
    )
    f.run_until(10.0)
    for message in f.of_type("ATTITUDE_QUATERNION"):
        assert math.isfinite(sum((message.q1, message.q2, message.q3, message.q4)))
        assert math.isfinite(message.rollspeed + message.pitchspeed + message.yawspeed)
    assert f.of_type("ATTITUDE_QUATERNION", 5.6, 7.0) == []
    assert f.of_type("ATTITUDE_QUATERNION", 9.0)


def test_a_wrong_autopilot_is_said(flight):
    f = flight("[[link]]\nurl = 'sim:'\n", sim(faults=["attitude-offset-north=29@6"]))
    f.run_until(5.9)
    assert f.of_type("HEARTBEAT")[-1].system_status == ACTIVE
    f.run_until(9.0)
    assert f.of_type("HEARTBEAT")[-1].system_status == CRITICAL
    assert any(text.startswith("verdict: ATTITUDE DISAGREES (tilt)") for text in f.texts)


def test_the_verdict_reaches_the_autopilots_log_where_wanted(flight):
    config = "publish = ['named_values', 'attitude_quaternion_cov']"
    f = flight(config)
    f.run_until(6.0)
    values = {one.name: one.value for one in f.of_type("NAMED_VALUE_FLOAT", 5.0)}
    assert values["ATT_OK"] == 1.0
    assert 0.0 <= values["ATT_TILT"] < 1.0
    assert len(f.of_type("ATTITUDE_QUATERNION_COV", 3.0, 5.0)) == pytest.approx(40, abs=1)
    assert f.of_type("ATTITUDE_QUATERNION") == []


def test_a_reboot_realigns_and_asks_again(flight):
    f = flight("", sim(faults=["reboot@6"]))
    f.run_until(5.9)
    asked = len(f.of_type("COMMAND_LONG"))
    f.run_until(14.0)
    assert len(f.of_type("COMMAND_LONG")) >= 2 * asked
    assert any("went back" in text for text in f.texts)
    times = [one.time_boot_ms for one in f.of_type("ATTITUDE_QUATERNION", 9.0)]
    assert times
    assert max(times) < 9000, "the new time base"
    assert f.errors_deg(11.0)[0] < 1.0


@pytest.mark.parametrize(
    ("personality", "asked", "said"),
    [
        (
            "ardupilot",
            [*FOR_THE_FILTER, *FOR_THE_FRAME, *FOR_THE_SENSORS],
            ["gyro low-pass is 20 Hz (INS_GYRO_FILTER)", "GPS delay is 0.1 s (GPS1_DELAY_MS)"],
        ),
        ("px4", ["EKF2_GPS_DELAY", "EKF2_MAG_DECL", *FOR_PX4S_SENSORS], ["GPS delay is 0.1 s (EKF2_GPS_DELAY)"]),
    ],
)
def test_the_settings_are_read_from_the_autopilot_before_the_first_sample(flight, personality, asked, said):
    f = flight(VELOCITY_AIDED, sim(personality=personality))
    f.run_until(3.0)
    assert [one.param_id for one in f.of_type("PARAM_REQUEST_READ")] == asked
    learned = [text for text in f.texts if text.startswith("the autopilot's ")]
    assert learned == [f"the autopilot's {text}" for text in said]


def test_the_settings_are_asked_again_after_a_reboot_and_hold_until_then(flight):
    f = flight(VELOCITY_AIDED, sim(faults=["reboot@4"]))
    f.run_until(3.0)
    station = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
    change = mavlink.MAVLink_param_set_message(1, 1, b"INS_GYRO_FILTER", 60.0, mavlink.MAV_PARAM_TYPE_REAL32)
    f.vehicle.handle(change.pack(station), f.now_ns)
    f.run_until(3.9)
    assert low_pass_hz(f) == 60.0
    f.run_until(5.9)
    assert low_pass_hz(f) == 60.0
    f.run_until(9.0)
    asked = [one.param_id for one in f.of_type("PARAM_REQUEST_READ", 4.0)]
    assert asked == [*FOR_THE_FILTER, *FOR_THE_FRAME, *FOR_THE_SENSORS]
    assert low_pass_hz(f) == 60.0
    assert [text for text in f.texts if text.startswith("the autopilot's gyro")] == [
        "the autopilot's gyro low-pass is 20 Hz (INS_GYRO_FILTER)",
        "the autopilot's gyro low-pass is 60 Hz (INS_GYRO_FILTER)",
    ]


def test_px4s_inertial_messages_have_passed_no_low_pass(flight):
    worst_tilt = {}
    for key in ("low_pass_hz = 'auto'", "low_pass_hz = 20"):
        highres = "[streams]\nimu_messages = ['HIGHRES_IMU']"
        f = flight(f"{highres}\n{VELOCITY_AIDED}\n[filter.velocity-aided]\n{key}", sim("tumbling", personality="px4"))
        f.run_until(25.0)
        assert low_pass_hz(f) == 0.0
        worst_tilt[key] = f.errors_deg(15.0)[0]
    assert worst_tilt["low_pass_hz = 'auto'"] < 0.5
    assert worst_tilt["low_pass_hz = 20"] > 0.8, "making good a delay that was not there costs a degree"


def test_settings_of_other_components_and_vehicles_are_not_taken(flight):
    f = flight(VELOCITY_AIDED)
    f.run_until(3.0)
    for sender in ((1, 100), (2, 1), (255, 190), (1, 193)):
        f.service.receive(0, parameter(f, 60.0, sender), f.now_ns)
    assert low_pass_hz(f) == 20.0


def test_what_is_configured_is_not_asked_for(flight):
    f = flight(f"{VELOCITY_AIDED}\n[filter.velocity-aided]\nlow_pass_hz = 35")
    f.run_until(3.0)
    assert [one.param_id for one in f.of_type("PARAM_REQUEST_READ")] == [
        "GPS1_DELAY_MS",
        *FOR_THE_FRAME,
        *FOR_THE_SENSORS,
    ]


def test_a_service_that_must_not_learn_asks_for_no_sensors(flight):
    f = flight("[state]\ncalibration = false")
    f.run_until(3.0)
    assert [one.param_id for one in f.of_type("PARAM_REQUEST_READ")] == [*FOR_THE_FILTER, *FOR_THE_FRAME]


def test_a_filter_that_has_no_use_for_the_settings_asks_for_none(flight):
    f = flight("[filter]\nname = 'gradient-descent'")
    f.run_until(3.0)
    assert [one.param_id for one in f.of_type("PARAM_REQUEST_READ")] == FOR_THE_FRAME


VELOCITY_AIDED = "[filter]\nname = 'velocity-aided'"


def parameter(f, value, sender=(1, 1)):
    """A PARAM_VALUE that nobody asked for."""
    values = {"param_id": b"INS_GYRO_FILTER", "param_value": value, "param_type": 4}
    return Encoder(f.vehicle.dialect, *sender).message("PARAM_VALUE", values)


def low_pass_hz(f):
    """The low-pass that the filters are given, Hz."""
    return f.snapshot().vehicle.settings.low_pass_hz


def test_headings_are_true_once_the_position_is_known(flight):
    f = flight("", sim(errors=PERFECT, first_fix_s=4.0))
    f.run_until(12.0)
    assert f.errors_deg(9.0)[1] < 1.0
    config = flight("[estimate]\ndeclination_deg = 0", sim(errors=PERFECT))
    config.run_until(12.0)
    assert config.errors_deg(9.0)[1] == pytest.approx(12.69, abs=1.0), "as configured, not as looked up"


@pytest.mark.parametrize("chunk", [1, 7, 64])
def test_how_the_bytes_are_cut_changes_nothing(flight, chunk):
    whole, cut = flight(), flight(chunk=chunk)
    whole.run_until(4.0)
    cut.run_until(4.0)
    assert whole.raw == cut.raw


def test_a_broken_link_is_begun_anew(flight):
    f = flight()
    f.run_until(4.0)
    f.service.receive(0, b"\xfd\x20\x00", f.now_ns)
    f.service.link_restarted(0)
    asked = len(f.of_type("COMMAND_LONG"))
    f.run_until(6.0)
    assert f.of_type("ATTITUDE_QUATERNION", 5.0), "data goes on"
    assert len(f.of_type("COMMAND_LONG")) > asked, "streams are asked for again after the next heartbeat"


def test_garbage_is_survived(flight):
    f = flight()
    for second in range(1, 8):
        f.run_until(float(second))
        f.service.receive(0, bytes((17 * second + i * i) % 256 for i in range(3000)), f.now_ns)
    f.run_until(9.0)
    assert f.of_type("ATTITUDE_QUATERNION", 8.0)


def test_with_two_vehicles_nothing_is_sent_until_one_is_left(flight):
    f = flight()
    other = Encoder(f.vehicle.dialect, 2, 1)
    f.run_until(1.0)
    assert f.service.estimate is not None
    for second in range(1, 11):
        f.service.receive(0, other.heartbeat(2, 3, 0, 4), f.now_ns)
        f.run_until(second + 1.0)
    assert f.service.estimate is None
    assert f.of_type("ATTITUDE_QUATERNION", 1.1) == []
    assert {beat.system_status for beat in f.of_type("HEARTBEAT", 2.5)} == {BOOT}
    assert any(note.level == logging.ERROR and "systems 1 and 2" in note.text for note in f.notes)
    line = f.status()
    assert line.startswith("waiting | several vehicles, systems 1 and 2: name one with system_id under [vehicle]")
    f.run_until(18.0)
    assert len(f.of_type("ATTITUDE_QUATERNION", 16.0)) == pytest.approx(40, abs=2)
    assert f.errors_deg(16.0)[0] < 1.0


def test_a_camera_that_claims_an_autopilot_changes_nothing(flight):
    f, alone = flight(), flight()
    camera = Encoder(f.vehicle.dialect, 1, 100)
    for second in range(8):
        f.service.receive(0, camera.heartbeat(30, 0, 0, 4), f.now_ns)
        f.run_until(second + 1.0)
    alone.run_until(8.0)
    assert f.of_type("ATTITUDE_QUATERNION")
    assert f.raw == alone.raw


def notes(f):
    return [note.text for note in f.service.take_notes()]


def test_the_estimate_of_another_component_is_not_carried_over_to_the_autopilot(flight):
    """Their inertial messages have the same name, but another sensor, clock and unit stands behind them."""
    f = flight("[streams]\nimu_messages = ['HIGHRES_IMU']", sim(personality="px4"))
    other = Encoder(f.vehicle.dialect, 1, 140)
    for step in range(350):
        now_ns = step * SECOND // 50
        if step % 50 == 0:
            f.service.receive(0, other.heartbeat(2, 0, 0, 4), now_ns)
        values = {"time_usec": 10**9 + 20_000 * step, "xacc": 9.8, "xmag": 0.2, "zmag": 0.4, "fields_updated": 511}
        f.service.receive(0, other.message("HIGHRES_IMU", values | {"ygyro": 1e-3 * (step % 2)}), now_ns)
        f.service.poll(now_ns)
    assert f.snapshot().lanes
    f.now_ns = 7 * SECOND
    autopilot = Encoder(f.vehicle.dialect, 1, 1)
    f.service.receive(0, autopilot.heartbeat(2, 12, 0, 4), f.now_ns)
    assert f.snapshot().lanes, "the other one brings samples and goes on"
    assert any("component 1 of system 1 is an autopilot too" in text for text in f.texts + notes(f))
    f.now_ns = 11 * SECOND
    f.service.poll(f.now_ns)
    f.service.receive(0, autopilot.heartbeat(2, 12, 0, 4), f.now_ns)
    assert f.snapshot().lanes == ()
    assert f.service.estimate is None


def test_what_is_heard_instead_of_a_vehicle_is_said(flight):
    f = flight()
    assert "| no vehicle yet |" in f.status()
    f.service.receive(0, b"x" * 500, 0)
    assert "| no vehicle yet: bytes come, but no MAVLink; is the baud rate right? |" in f.status()
    f.service.receive(0, Encoder(f.vehicle.dialect, 1, 1).message("ATTITUDE", {}), 0)
    assert "| no vehicle yet: MAVLink comes, but no HEARTBEAT of an autopilot |" in f.status()


def test_the_status_line_says_it_all(flight):
    f = flight()
    assert f.status() == "waiting | no vehicle yet | sent 0.0 Hz"
    f.run_until(6.0)
    f.status()
    f.run_until(8.0)
    line = f.status()
    state, imu, attitude, witness, verdict, sensors, sent = line.split(" | ")
    assert state == "active"
    assert imu.startswith("RAW_IMU 50.")
    assert imu.endswith(" of 50 Hz")
    assert attitude.startswith("roll ")
    assert attitude.endswith("(true)")
    assert re.fullmatch(r"velocity-aided, velocity from GPS_RAW_INT, sigma tilt 0\.\d\d heading \d\.\d\d deg", witness)
    assert verdict.startswith("ATTITUDE agrees tilt 0.")
    assert sensors == "sensors RAW_IMU, SCALED_IMU2"
    assert sent == "sent 20.0 Hz"

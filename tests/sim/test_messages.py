"""What is on the wire, read with pymavlink and compared with the truth."""

from math import atan2, degrees, hypot, isnan

import numpy as np
import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from attest_mav.algebra import q_exp, q_mul, q_to_euler, rotate_back, scale, tilt_between
from attest_mav.mavlink.dialect import load_dialect
from attest_mav.sim.autopilot import FakeAutopilot
from attest_mav.sim.messages import FIELDS, int16
from attest_mav.sim.personality import ARDUPILOT, PX4
from attest_mav.sim.settings import PERFECT, SensorErrors, SimSettings
from attest_mav.types import G_MPS2

S = 1_000_000_000
NO_ERROR = {"errors": PERFECT, "attitude_error": (0.0, 0.0, 0.0)}


def fly(decode, until_s, **settings):
    """Messages of a flight up to then, and the vehicle."""
    vehicle = FakeAutopilot(SimSettings(**settings), seed=1)
    return decode(vehicle.frames_until(round(until_s * S))), vehicle


def truth_at(vehicle, message):
    """The truth at the time that a message carries."""
    t_ns = message.time_usec * 1000 if hasattr(message, "time_usec") else message.time_boot_ms * 1_000_000
    return vehicle.truth(t_ns)


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (0.999, 0),
        (-0.999, 0),
        (1.999, 1),
        (-1.999, -1),
        (4e4, 32767),
        (-4e4, -32768),
        (float("nan"), 0),
        (32767.9, 32767),
        (-32768.9, -32768),
    ],
)
def test_integers_are_cut_toward_zero_and_held_in_range(value, expected):
    assert int16(value) == expected


def test_the_fields_are_in_the_dialects_wire_order_and_every_streamed_message_has_some():
    dialect = load_dialect()
    for name, fields in FIELDS.items():
        dialect.layout(name).pick(*fields)  # raises where the order is wrong
    assert {stream.message for stream in ARDUPILOT.streams + PX4.streams} == set(FIELDS)


def test_raw_imu_is_the_truth_cut_toward_zero_in_milli_units(decode):
    # PX4 has no low-pass, so that the numbers can be foretold exactly; its SCALED_IMU has RAW_IMU's units.
    messages, vehicle = fly(decode, 14.0, personality="px4", scenario="tumbling", **NO_ERROR)
    signs = set()
    for message in messages["SCALED_IMU"]:
        truth = truth_at(vehicle, message)
        force = truth.specific_force()
        accel = (message.xacc, message.yacc, message.zacc)
        gyro = (message.xgyro, message.ygyro, message.zgyro)
        for got, exact in zip(
            accel + gyro, [1000.0 * f / G_MPS2 for f in force] + [1000.0 * w for w in truth.rates], strict=True
        ):
            assert got == int(exact)
            assert abs(got) <= abs(exact)
            signs.add(np.sign(got))
    assert signs == {-1, 0, 1}


def test_ardupilots_imu_is_late_by_its_lowpass(decode):
    messages, vehicle = fly(decode, 24.0, scenario="tumbling", fast_rate_hz=50.0, **NO_ERROR)
    imu = messages["RAW_IMU"][350:]

    def residual(lag_ms):
        gyro = [(m.xgyro, m.ygyro, m.zgyro) for m in imu]
        true = [vehicle.truth(m.time_usec * 1000 - round(lag_ms * 1e6)).rates for m in imu]
        return float(np.std(np.array(gyro) * 1e-3 - np.array(true)))

    lags = [9.0 + 0.25 * k for k in range(20)]
    assert min(lags, key=residual) == pytest.approx(11.25, abs=0.25)
    assert residual(11.25) < 1e-3  # the resolution, and what is not linear phase
    assert residual(0.0) > 5e-3


def test_units_differ_and_scaled_imu_repeats_raw_imu(decode, companion):
    vehicle = FakeAutopilot(SimSettings(scenario="hover", fast_rate_hz=50.0), seed=1)
    ask = mavlink.MAVLink_command_long_message(1, 1, 511, 0, mavlink.MAVLINK_MSG_ID_SCALED_IMU, 20_000, 0, 0, 0, 0, 0)
    vehicle.handle(ask.pack(companion), 0)
    messages = decode(vehicle.frames_until(12 * S))
    raw = {m.time_usec // 1000: m for m in messages["RAW_IMU"]}
    axes = ("xacc", "yacc", "zacc", "xgyro", "ygyro", "zgyro", "xmag", "ymag", "zmag")
    assert len(messages["SCALED_IMU"]) > 590
    for scaled in messages["SCALED_IMU"]:
        assert [getattr(scaled, a) for a in axes] == [getattr(raw[scaled.time_boot_ms], a) for a in axes]
    second = messages["SCALED_IMU2"][500]
    first = raw[second.time_boot_ms]
    assert [getattr(first, a) for a in axes] != [getattr(second, a) for a in axes]
    assert abs(first.zacc - second.zacc) < 30


def test_a_third_unit_that_is_not_there_has_only_a_magnetometer(decode):
    messages, _ = fly(decode, 10.0)
    last = messages["SCALED_IMU3"][-1]
    assert (last.xacc, last.yacc, last.zacc, last.xgyro, last.ygyro, last.zgyro) == (0, 0, 0, 0, 0, 0)
    assert 550 < np.linalg.norm((last.xmag, last.ymag, last.zmag)) < 610


def test_the_first_messages_carry_a_magnetometer_of_zeros(decode):
    messages, _ = fly(decode, 1.0, fast_rate_hz=50.0)
    fields = [(m.xmag, m.ymag, m.zmag) for m in messages["RAW_IMU"]]
    assert fields[0] == (0, 0, 0)
    assert all(field != (0, 0, 0) for field in fields[7:])


@pytest.mark.parametrize("personality", ["ardupilot", "px4"])
@pytest.mark.parametrize("scenario", ["tumbling", "coordinated-turns"])
def test_sim_state_is_the_truth_and_attitude_stays_within_its_error(decode, personality, scenario):
    messages, vehicle = fly(decode, 30.0, personality=personality, scenario=scenario, fast_rate_hz=10.0)
    assert len(messages["SIM_STATE"]) == len(messages["ATTITUDE"]) == 300
    for state, attitude in zip(messages["SIM_STATE"], messages["ATTITUDE"], strict=True):
        t_ns = attitude.time_boot_ms * 1_000_000
        truth = vehicle.truth(t_ns)
        assert (state.q1, state.q2, state.q3, state.q4) == pytest.approx(truth.q_nb, abs=1e-6)
        assert (state.roll, state.pitch, state.yaw) == pytest.approx(q_to_euler(truth.q_nb), abs=1e-5)
        assert (state.xacc, state.yacc, state.zacc) == pytest.approx(truth.specific_force(), abs=1e-5)
        assert (state.xgyro, state.ygyro, state.zgyro) == pytest.approx(truth.rates, abs=1e-6)
        assert (state.vn, state.ve, state.vd) == pytest.approx(truth.v_ned, abs=1e-5)
        error = vehicle.messages.report.error(t_ns * 1e-9)
        reported = q_mul(q_exp(scale(error, 0.5)), truth.q_nb)
        assert degrees(tilt_between(reported, truth.q_nb)) < 0.15
        assert (attitude.roll, attitude.pitch, attitude.yaw) == pytest.approx(q_to_euler(reported), abs=1e-6)


def test_the_reported_attitude_errs_slowly(decode):
    messages, vehicle = fly(decode, 3.0, scenario="still")
    report = vehicle.messages.report
    errors = np.array([report.error(0.2 * k) for k in range(1000)])
    last = messages["ATTITUDE"][-1]
    expected = q_mul(q_exp(scale(report.error(last.time_boot_ms * 1e-3), 0.5)), vehicle.truth(0).q_nb)
    assert (last.roll, last.pitch, last.yaw) == pytest.approx(q_to_euler(expected), abs=1e-6)
    assert np.all(np.abs(errors).max(axis=0) < (0.0015001, 0.0015001, 0.0040001))
    assert np.all(np.abs(errors).max(axis=0) > (0.0008, 0.0008, 0.002))
    assert np.abs(np.diff(errors, axis=0)).max() * 5.0 < 1e-3  # rad/s


def test_highres_imu_of_px4_is_without_bias_and_says_what_is_new(decode):
    errors = SensorErrors(0.0, 0.02, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0)
    messages, vehicle = fly(decode, 12.0, personality="px4", scenario="tumbling", fast_rate_hz=100.0, errors=errors)
    fresh = 0
    for message in messages["HIGHRES_IMU"]:
        truth = truth_at(vehicle, message)
        assert (message.xacc, message.yacc, message.zacc) == pytest.approx(truth.specific_force(), abs=1e-5)
        assert (message.xgyro, message.ygyro, message.zgyro) == pytest.approx(truth.rates, abs=1e-5)
        assert message.fields_updated & 0x3F == 0x3F
        fresh += message.fields_updated & 0x1C0 == 0x1C0
    assert fresh == pytest.approx(600, abs=3)  # the magnetometer reads at 50 Hz
    last, scaled = messages["HIGHRES_IMU"][-1], messages["SCALED_IMU"][-1]
    assert 1000.0 * last.xgyro != pytest.approx(scaled.xgyro, abs=1.0)  # the bias is still in SCALED_IMU


def test_scaled_imu_of_px4_has_an_uncalibrated_magnetometer_in_its_own_axes(decode):
    offset = (0.1, -0.2, 0.3)
    messages, vehicle = fly(decode, 10.0, personality="px4", scenario="still", mag_offset=offset, **NO_ERROR)
    x, y, z = rotate_back(vehicle.truth(0).q_nb, vehicle.settings.earth.field_ned())
    scaled, highres = messages["SCALED_IMU"][-1], messages["HIGHRES_IMU"][-1]
    assert (highres.xmag, highres.ymag, highres.zmag) == pytest.approx((x, y, z), abs=1e-6)
    expected = (1000 * (x + 0.1), 1000 * (-y - 0.2), 1000 * (-z + 0.3))
    assert (scaled.xmag, scaled.ymag, scaled.zmag) == tuple(int(m) for m in expected)


def test_gps_gives_position_and_velocity_from_the_first_fix_on(decode):
    messages, vehicle = fly(decode, 30.0, scenario="coordinated-turns")
    fixes = messages["GPS_RAW_INT"]
    assert [m.fix_type for m in fixes if m.time_usec == 0] == [1] * len([m for m in fixes if m.time_usec == 0])
    assert min(m.time_usec for m in fixes if m.fix_type == 3) == 3_071_000
    last = fixes[-1]
    t_ns = last.time_usec * 1000 - 100_000_000
    v = vehicle.truth(t_ns).v_ned
    assert last.vel * 0.01 == pytest.approx(hypot(v[0], v[1]), abs=0.2)
    assert last.cog * 0.01 == pytest.approx(degrees(atan2(v[1], v[0])) % 360.0, abs=0.6)
    north = (last.lat * 1e-7 + 35.363262) * 111_319.5
    east = (last.lon * 1e-7 - 149.165237) * 111_319.5 * np.cos(np.radians(35.363262))
    assert (north, east) == pytest.approx(vehicle.trajectory.position(t_ns * 1e-9)[:2], abs=1.5)


def test_global_position_is_empty_before_the_fix_and_the_truth_after(decode):
    messages, vehicle = fly(decode, 30.0, scenario="square")
    first, last = messages["GLOBAL_POSITION_INT"][0], messages["GLOBAL_POSITION_INT"][-1]
    assert (first.lat, first.lon, first.vx, first.vy) == (0, 0, 0, 0)
    truth = truth_at(vehicle, last)
    assert (last.vx, last.vy, last.vz) == tuple(int(100.0 * v) for v in truth.v_ned)
    assert last.relative_alt == 12_000
    assert last.alt == 584_000 + 12_000
    assert last.hdg * 0.01 == pytest.approx(degrees(truth.euler[2]) % 360.0, abs=0.5)


@pytest.mark.parametrize(("scenario", "airspeed"), [("coordinated-turns", 22.0), ("hover", 0.0)])
def test_only_a_plane_measures_airspeed(decode, scenario, airspeed):
    messages, _ = fly(decode, 30.0, scenario=scenario)
    assert messages["VFR_HUD"][-1].airspeed == pytest.approx(airspeed)


def test_system_time_knows_the_wall_clock_after_the_fix(decode):
    messages, _ = fly(decode, 6.0)
    times = messages["SYSTEM_TIME"]
    assert times[0].time_unix_usec == 0
    assert times[-1].time_unix_usec - times[-1].time_boot_ms * 1000 == 1_750_000_000_000_000


@pytest.mark.parametrize(
    ("personality", "scenario", "kind", "autopilot"),
    [
        ("ardupilot", "square", mavlink.MAV_TYPE_QUADROTOR, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA),
        ("ardupilot", "coordinated-turns", mavlink.MAV_TYPE_FIXED_WING, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA),
        ("px4", "hover", mavlink.MAV_TYPE_QUADROTOR, mavlink.MAV_AUTOPILOT_PX4),
    ],
)
def test_heartbeats_once_a_second_say_who_it_is_and_when_it_is_armed(decode, personality, scenario, kind, autopilot):
    messages, _ = fly(decode, 10.0, personality=personality, scenario=scenario, system=7)
    beats = messages["HEARTBEAT"]
    assert len(beats) == 11
    assert {(m.type, m.autopilot, m.get_srcSystem(), m.get_srcComponent()) for m in beats} == {(kind, autopilot, 7, 1)}
    armed = [bool(m.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED) for m in beats]
    assert armed == [False] * 5 + [True] * 6
    assert beats[0].system_status == mavlink.MAV_STATE_STANDBY
    assert beats[-1].system_status == mavlink.MAV_STATE_ACTIVE


def test_nothing_is_ever_not_a_number_without_a_fault(decode):
    for personality in ("ardupilot", "px4"):
        messages, _ = fly(decode, 8.0, personality=personality, scenario="tumbling")
        for message in (m for kind in messages.values() for m in kind):
            assert not any(isnan(v) for v in message.to_dict().values() if isinstance(v, float))

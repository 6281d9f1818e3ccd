"""Messages to samples: units, frames and times, message by message."""

import math
import random
import struct

import pytest
from pymavlink.dialects.v20 import all as pymav

from attest_mav import samples, types
from attest_mav.mavlink.decode.decoder import Decoder, of_message
from attest_mav.mavlink.wire.framer import Framer


def f32(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


@pytest.fixture
def hear(dialect, sender):
    framer, decoder = Framer(dialect, None), Decoder(dialect)

    def decode(message, kind="v2"):
        (frame,) = framer.feed(sender.pack(message, kind), 77)
        samples = decoder.decode(frame)
        for sample in samples:
            assert (sample.source, sample.system, sample.component) == (message.msgname, 1, 1)
            assert sample.rx_ns == 77
        return samples

    decode.decoder = decoder
    return decode


def matrix_of_euler(roll, pitch, yaw):
    """Body to NED by the aerospace sequence, written out from its three rotations."""
    cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (math.cos, math.sin))
    return [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]


def matrix_of_quaternion(q):
    """Columns: where q turns the body axes to, by the product q v conj(q)."""

    def product(a, b):
        w, x, y, z = a
        s, i, j, k = b
        return (
            w * s - x * i - y * j - z * k,
            w * i + x * s + y * k - z * j,
            w * j - x * k + y * s + z * i,
            w * k + x * j - y * i + z * s,
        )

    conjugate = (q[0], -q[1], -q[2], -q[3])
    columns = [product(product(q, (0, *axis)), conjugate)[1:] for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
    return [list(row) for row in zip(*columns, strict=True)]


def assert_same_rotation(q, matrix):
    for ours, theirs in zip(matrix_of_quaternion(q), matrix, strict=True):
        assert ours == pytest.approx(theirs, abs=1e-6)


def test_everything_it_wants_it_understands(dialect):
    names = {dialect.name_of(message_id) for message_id in Decoder(dialect).wanted}
    assert names == {
        "RAW_IMU", "SCALED_IMU", "SCALED_IMU2", "SCALED_IMU3", "HIGHRES_IMU", "ATTITUDE", "ATTITUDE_QUATERNION",
        "SIM_STATE", "SIMSTATE", "AHRS2", "HEARTBEAT", "SYSTEM_TIME", "GLOBAL_POSITION_INT", "GPS_RAW_INT",
        "VFR_HUD", "LOCAL_POSITION_NED", "PARAM_VALUE", "EXTENDED_SYS_STATE", "AUTOPILOT_VERSION", "STATUSTEXT",
        "EKF_STATUS_REPORT", "ESTIMATOR_STATUS", "SYS_STATUS", "AHRS3",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("vel_acc_mms", "eph", "satellites", "sigma"),
    [
        (300, 80, 12, 0.3),
        (0, 80, 12, None),
        (0, 65535, 255, None),
        (0, 4900, 12, 19.6),
        (5000, 300, 12, 5.0),
        (0, 90, 4, 1.0),
    ],
)
def test_a_receiver_says_how_good_its_velocity_is(hear, vel_acc_mms, eph, satellites, sigma):
    message = pymav.MAVLink_gps_raw_int_message(
        1_000_000, 3, 0, 0, 0, eph, 100, 500, 0, satellites, vel_acc=vel_acc_mms
    )
    velocity, position = hear(message)
    assert velocity.sigma == (None if sigma is None else pytest.approx(sigma))
    assert position.satellites == (None if satellites == 255 else satellites)
    assert position.dilution == (None if eph == 65535 else pytest.approx(0.01 * eph))


@pytest.mark.parametrize(("state", "on_ground"), [(0, None), (1, True), (2, False), (3, False), (4, False), (9, None)])
def test_the_landing_detector(hear, state, on_ground):
    samples = hear(pymav.MAVLink_extended_sys_state_message(0, state))
    assert [sample.on_ground for sample in samples] == ([] if on_ground is None else [on_ground])


def test_other_messages_give_nothing(hear):
    assert hear(pymav.MAVLink_ping_message(0, 1, 0, 0)) == []
    assert hear.decoder.refusals == {}


@pytest.mark.parametrize("kind", ["v1", "v2", "signed"])
def test_attitude(hear, kind):
    (sample,) = hear(pymav.MAVLink_attitude_message(4_294_967_295, 0.3, -0.7, 2.5, 0.1, -0.2, 0.3), kind)
    assert isinstance(sample, samples.AttitudeSample)
    assert sample.t_ns == 4_294_967_295_000_000
    assert sample.rates == (f32(0.1), f32(-0.2), f32(0.3))
    assert_same_rotation(sample.q_nb, matrix_of_euler(0.3, -0.7, 2.5))


def test_an_attitude_that_ends_in_zeros_is_whole(hear):
    (sample,) = hear(pymav.MAVLink_attitude_message(5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert (sample.t_ns, sample.q_nb, sample.rates) == (5_000_000, (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


@pytest.mark.parametrize("field", range(6))
def test_an_attitude_that_is_not_finite_is_refused(hear, field):
    values = [0.1] * 6
    values[field] = math.nan
    assert hear(pymav.MAVLink_attitude_message(5, *values)) == []
    assert hear.decoder.refusals["ATTITUDE"] == "ATTITUDE of system 1: a value is not finite"
    assert len(hear(pymav.MAVLink_attitude_message(6, *[0.1] * 6))) == 1
    assert hear.decoder.refusals == {}
    assert hear.decoder.refused == {"ATTITUDE": 1}


def test_ahrs2_has_neither_time_nor_rates(hear):
    (sample,) = hear(pymav.MAVLink_ahrs2_message(0.3, -0.7, 2.5, 100.0, 1, 2))
    assert (sample.t_ns, sample.rates) == (types.NO_TIME, None)
    assert_same_rotation(sample.q_nb, matrix_of_euler(0.3, -0.7, 2.5))


def test_simstate_has_rates_and_no_time(hear):
    (sample,) = hear(pymav.MAVLink_simstate_message(0.3, -0.7, 2.5, 1.0, 2.0, 3.0, 0.25, -0.5, 0.75, 4, 5))
    assert (sample.t_ns, sample.rates) == (types.NO_TIME, (0.25, -0.5, 0.75))
    assert_same_rotation(sample.q_nb, matrix_of_euler(0.3, -0.7, 2.5))


Q = (0.5, -0.5, 0.1, 0.7)  # of length 1


def sim_state(q, euler=(9.0, 9.0, 9.0), rates=(0.25, -0.5, 0.75)):
    return pymav.MAVLink_sim_state_message(*q, *euler, 1.0, 2.0, 3.0, *rates, *[7.0] * 8, lat_int=5, lon_int=6)


def test_sim_state_is_its_quaternion(hear):
    (sample,) = hear(sim_state(Q))
    assert (sample.t_ns, sample.rates) == (types.NO_TIME, (0.25, -0.5, 0.75))
    assert sample.q_nb == pytest.approx(Q, abs=1e-7)
    assert math.hypot(*sample.q_nb) == pytest.approx(1.0, abs=1e-15)


def test_sim_state_without_quaternion_is_its_angles(hear):
    (sample,) = hear(sim_state((0.0, 0.0, 0.0, 0.0), (0.3, -0.7, 2.5)))
    assert_same_rotation(sample.q_nb, matrix_of_euler(0.3, -0.7, 2.5))


@pytest.mark.parametrize("euler", [(math.inf, 0.0, 0.0), (0.0, -math.inf, 0.0), (0.0, 0.0, math.nan)])
def test_a_truth_without_a_quaternion_and_with_infinite_angles_is_refused(hear, euler):
    assert hear(sim_state((0.0, 0.0, 0.0, 0.0), euler)) == []
    assert "no attitude" in hear.decoder.refusals["SIM_STATE"]


@pytest.mark.parametrize("q", [(0.5, 0.0, 0.0, 0.0), (math.nan, 0.0, 0.0, 1.0), (2.0, 0.0, 0.0, 0.0)])
def test_what_is_no_rotation_is_refused(hear, q):
    assert hear(sim_state(q)) == []
    assert "no attitude" in hear.decoder.refusals["SIM_STATE"]
    assert hear(pymav.MAVLink_attitude_quaternion_message(5, *q, 0.0, 0.0, 0.0)) == []
    assert "no attitude" in hear.decoder.refusals["ATTITUDE_QUATERNION"]


def test_attitude_quaternion(hear):
    (sample,) = hear(pymav.MAVLink_attitude_quaternion_message(123456, *Q, 0.25, -0.5, 0.75))
    assert (sample.t_ns, sample.rates) == (123_456_000_000, (0.25, -0.5, 0.75))
    assert sample.q_nb == pytest.approx(Q, abs=1e-7)


@pytest.mark.parametrize("offset", [(0.0, 0.0, 0.0, 0.0), (math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0)])
def test_repr_offset_is_for_display_and_turns_nothing(hear, offset):
    """PX4 fills it on a tailsitter in forward flight; q and rates stay the body's, as the inertial messages are."""
    (sample,) = hear(pymav.MAVLink_attitude_quaternion_message(5, *Q, 1.0, 2.0, 3.0, list(offset)))
    assert sample.q_nb == pytest.approx(Q, abs=1e-7)
    assert sample.rates == (1.0, 2.0, 3.0)


def test_heartbeat(hear):
    armed = pymav.MAV_MODE_FLAG_SAFETY_ARMED
    (sample,) = hear(pymav.MAVLink_heartbeat_message(2, 3, armed | 1, 5, 4, 3))
    assert (sample.vehicle_type, sample.autopilot, sample.armed, sample.status) == (2, 3, True, 4)
    assert sample.t_ns == types.NO_TIME
    (sample,) = hear(pymav.MAVLink_heartbeat_message(6, 8, 255 & ~armed, 5, 4, 3))
    assert (sample.autopilot, sample.armed) == (8, False)
    assert hear.decoder.autopilots == {1: 3}
    (sample,) = hear(pymav.MAVLink_heartbeat_message(1, 3, 81, 17, 4, 3))
    assert sample.mode == 17


def test_system_time(hear):
    (sample,) = hear(pymav.MAVLink_system_time_message(1_700_000_000_123_456, 60_000))
    assert (sample.t_ns, sample.unix_us) == (60_000_000_000, 1_700_000_000_123_456)
    (sample,) = hear(pymav.MAVLink_system_time_message(0, 60_000))
    assert sample.unix_us == 0


def gps(fix=3, vel=500, cog=12000):
    return pymav.MAVLink_gps_raw_int_message(
        123_456_789, fix, -353_629_847, 1_491_649_392, 587_850, 121, 200, vel, cog, 10
    )


def test_gps_velocity_and_position(hear):
    velocity, position = hear(gps())
    assert isinstance(velocity, samples.VelocitySample)
    assert velocity.t_ns == position.t_ns == 123_456_789_000
    assert velocity.v_ned == pytest.approx((-2.5, 5.0 * math.sqrt(0.75), 0.0), abs=1e-12)
    assert velocity.vertical_known is False
    assert isinstance(position, samples.PositionSample)
    assert position.latitude_deg == pytest.approx(-35.3629847, abs=1e-12)
    assert position.longitude_deg == pytest.approx(149.1649392, abs=1e-12)
    assert position.altitude_m == pytest.approx(587.85, abs=1e-12)


@pytest.mark.parametrize("fix", [0, 1, 2])
def test_gps_without_a_3d_fix_is_refused(hear, fix):
    assert hear(gps(fix)) == []
    assert hear.decoder.refusals["GPS_RAW_INT"] == f"GPS_RAW_INT of system 1: no 3-D fix (fix type {fix})"


@pytest.mark.parametrize("fix", [3, 4, 5, 6])
def test_better_fixes_count_too(hear, fix):
    assert len(hear(gps(fix))) == 2


def test_gps_of_unknown_speed_or_course_is_a_position_alone(hear):
    assert [type(sample) for sample in hear(gps(vel=65535))] == [samples.PositionSample]
    assert [type(sample) for sample in hear(gps(cog=65535))] == [samples.PositionSample]


def test_gps_at_rest_needs_no_course(hear):
    velocity, _ = hear(gps(vel=0, cog=65535))
    assert velocity.v_ned == (0.0, 0.0, 0.0)


def test_an_impossible_time_is_refused(hear):
    message = gps()
    message.time_usec = (1 << 64) - 1
    assert hear(message) == []
    assert "time is impossible" in hear.decoder.refusals["GPS_RAW_INT"]
    hear(pymav.MAVLink_heartbeat_message(2, 3, 0, 0, 4, 3))
    assert hear(pymav.MAVLink_raw_imu_message((1 << 64) - 1, 0, 0, -1000, 0, 0, 0, 200, 0, 400)) == []
    assert "time is impossible" in hear.decoder.refusals["RAW_IMU"]


def test_global_position_is_a_velocity(hear):
    (sample,) = hear(pymav.MAVLink_global_position_int_message(5000, 1, 2, 3, 4, 150, -250, 32767, 65535))
    assert sample.t_ns == 5_000_000_000
    assert sample.v_ned == pytest.approx((1.5, -2.5, 327.67), abs=1e-12)
    assert sample.vertical_known is True


def test_local_position_is_a_velocity(hear):
    (sample,) = hear(pymav.MAVLink_local_position_ned_message(5000, 1.0, 2.0, 3.0, 1.5, -2.5, 0.5))
    assert (sample.t_ns, sample.v_ned, sample.vertical_known) == (5_000_000_000, (1.5, -2.5, 0.5), True)
    assert hear(pymav.MAVLink_local_position_ned_message(5000, 1.0, 2.0, 3.0, math.nan, -2.5, 0.5)) == []
    assert "not finite" in hear.decoder.refusals["LOCAL_POSITION_NED"]


def test_vfr_hud(hear):
    (sample,) = hear(pymav.MAVLink_vfr_hud_message(12.5, 11.5, 90, 50, 100.0, -0.5))
    assert (sample.airspeed, sample.groundspeed, sample.climb) == (12.5, 11.5, -0.5)
    assert sample.t_ns == types.NO_TIME


@pytest.mark.parametrize("unknown", [math.nan, math.inf])
def test_an_unknown_speed_does_not_cost_the_others(hear, unknown):
    """PX4 sends NaN for the airspeed of a vehicle without a sensor for it."""
    (sample,) = hear(pymav.MAVLink_vfr_hud_message(unknown, 11.5, 90, 50, 100.0, -0.5))
    assert math.isnan(sample.airspeed)
    assert (sample.groundspeed, sample.climb) == (11.5, -0.5)
    assert hear(pymav.MAVLink_vfr_hud_message(unknown, unknown, 90, 50, 100.0, unknown)) == []
    assert "none of its speeds is finite" in hear.decoder.refusals["VFR_HUD"]


def test_refusals_of_a_message_are_not_those_of_one_like_it(hear):
    hear(pymav.MAVLink_heartbeat_message(2, 3, 0, 0, 4, 3))
    for k in range(20):
        hear(pymav.MAVLink_scaled_imu2_message(20 * k, 0, 0, -9000, 0, 0, 0, 200, 0, 400))
        hear(pymav.MAVLink_scaled_imu_message(20 * k, 0, 0, -1000, k % 2, 0, 0, 3, 0, 4))
    refusals = hear.decoder.refusals
    assert "SCALED_IMU2" in refusals
    assert [source for source in refusals if source in of_message("SCALED_IMU")] == ["SCALED_IMU magnetometer"]


def test_any_payload_of_any_message_decodes_without_an_exception(dialect):
    """Whatever the numbers: samples or a refusal."""
    rng = random.Random(5)
    decoder, framer = Decoder(dialect), Framer(dialect, None)
    for _ in range(3000):
        message_id = rng.choice(sorted(decoder.wanted))
        payload = rng.randbytes(rng.randint(1, 60))
        covered = bytes((len(payload), 0, 0, 0, 1, 1, message_id, 0, 0)) + payload
        crc = pymav.x25crc(covered + bytes([pymav.mavlink_map[message_id].crc_extra])).crc
        (frame,) = framer.feed(b"\xfd" + covered + crc.to_bytes(2, "little"), 1)
        before = sum(decoder.refused.values())
        if not decoder.decode(frame):
            refused = sum(decoder.refused.values())
            assert refused in {before, before + 1}
    assert framer.frames == 3000

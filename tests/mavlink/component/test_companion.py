"""The whole companion on virtual time: identity, heartbeat, requests, verdict, goodbye."""

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from attest_mav.mavlink.component.channel import PortSettings
from attest_mav.mavlink.component.companion import Companion
from attest_mav.mavlink.component.companion_settings import CompanionSettings
from attest_mav.mavlink.component.vehicle_data import DataSettings

SECOND = 1_000_000_000
RAW_IMU, SCALED_IMU, ATTITUDE, GPS_RAW_INT, VFR_HUD = 27, 26, 30, 24, 74
SCALED_IMU2, SCALED_IMU3 = 116, 129


def ack(result, command=511, target=(1, 193)):
    return mavlink.MAVLink_command_ack_message(command, result, 0, 0, *target)


def raw_imu(t_us=0):
    return mavlink.MAVLink_raw_imu_message(t_us, 0, 0, -1000, 0, 0, 0, 200, 0, 400)


def test_the_heartbeat_is_an_onboard_controllers_once_a_second_on_every_link_even_alone(bench):
    b = bench(links=[PortSettings(), PortSettings()])
    b.run_until(10.0)
    for link in (0, 1):
        beats = b.of_type("HEARTBEAT", link)
        assert len(beats) == 11
        assert {(m.type, m.autopilot, m.base_mode, m.system_status) for m in beats} == {
            (18, 8, 0, mavlink.MAV_STATE_BOOT)
        }
        assert {(m.get_srcSystem(), m.get_srcComponent()) for m in beats} == {(1, 193)}


def test_the_heartbeat_says_the_state(bench):
    b = bench()
    b.run_until(2.5)
    b.companion.state = mavlink.MAV_STATE_ACTIVE
    b.run_until(3.5)
    assert [m.system_status for m in b.of_type("HEARTBEAT")] == [
        mavlink.MAV_STATE_BOOT,
        mavlink.MAV_STATE_BOOT,
        mavlink.MAV_STATE_BOOT,
        mavlink.MAV_STATE_ACTIVE,
    ]


def test_a_late_loop_does_not_make_up_for_heartbeats(bench):
    b = bench()
    b.run_until(1.0)
    b.now_ns = 30 * SECOND
    b.run_until(30.4)
    assert len(b.of_type("HEARTBEAT")) == 3


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        (CompanionSettings(), (7, 193)),
        (CompanionSettings(component=200), (7, 200)),
        (CompanionSettings(system=42), (42, 193)),
    ],
)
def test_the_system_id_is_the_vehicles_unless_configured(bench, settings, expected):
    b = bench(settings)
    b.vehicle_heartbeat(system=7)
    b.run_until(0.1)
    message = b.of_type("HEARTBEAT")[0]
    assert (message.get_srcSystem(), message.get_srcComponent()) == expected


def test_streams_are_asked_of_the_autopilots_exact_ids(bench):
    b = bench()
    b.vehicle_heartbeat(system=7, component=1)
    for _ in range(9):
        b.run_until(b.now_ns / SECOND + 0.05)
        b.hear(ack(0, target=(7, 193)), system=7, component=1)
    b.run_until(b.now_ns / SECOND + 0.05)
    assert b.interval_requests() == [
        (RAW_IMU, 20_000, 0),
        (ATTITUDE, 100_000, 0),
        (GPS_RAW_INT, 200_000, 0),
        (VFR_HUD, 200_000, 0),
        (SCALED_IMU2, 20_000, 0),
        (SCALED_IMU3, 20_000, 0),
        (mavlink.MAVLINK_MSG_ID_EKF_STATUS_REPORT, 1_000_000, 0),
        (mavlink.MAVLINK_MSG_ID_SYS_STATUS, 1_000_000, 0),
        (mavlink.MAVLINK_MSG_ID_AHRS2, 1_000_000, 0),
    ]
    assert {(m.target_system, m.target_component) for m in b.of_type("COMMAND_LONG")} == {(7, 1)}


@pytest.mark.parametrize(("autopilot", "message"), [(3, RAW_IMU), (12, SCALED_IMU), (0, 105)])
def test_the_inertial_message_goes_by_the_autopilot(bench, autopilot, message):
    b = bench()
    b.vehicle_heartbeat(autopilot=autopilot)
    b.run_until(0.1)
    assert b.interval_requests()[0][0] == message


def test_a_denied_inertial_message_gives_way_to_the_next(bench):
    b = bench(CompanionSettings(data=DataSettings(imu_messages=("HIGHRES_IMU", "RAW_IMU"))))
    b.vehicle_heartbeat()
    b.run_until(0.05)
    b.hear(ack(2))
    b.run_until(0.1)
    assert [message for message, _, _ in b.interval_requests()] == [105, RAW_IMU]
    assert "HIGHRES_IMU does not come; trying RAW_IMU" in b.notes


def test_only_the_vehicles_own_data_is_taken_and_one_inertial_message_a_sensor(bench):
    b = bench(links=[PortSettings(), PortSettings()])
    assert not b.hear(raw_imu()), "no vehicle yet"
    b.vehicle_heartbeat()
    assert b.hear(raw_imu())
    assert not b.hear(raw_imu(), system=2)
    assert not b.hear(raw_imu(), component=191)
    assert not b.hear(raw_imu(), link=1), "one vehicle, one link: nothing is taken twice"
    assert b.hear(mavlink.MAVLink_scaled_imu2_message(0, 0, 0, -1000, 0, 0, 0, 0, 0, 0))
    assert not b.hear(mavlink.MAVLink_scaled_imu_message(0, 0, 0, -1000, 0, 0, 0, 0, 0, 0))
    assert b.hear(mavlink.MAVLink_attitude_message(0, 0, 0, 0, 0, 0, 0))


def test_acknowledgements_of_others_are_not_ours(bench):
    b = bench()
    b.vehicle_heartbeat()
    b.run_until(0.05)
    b.hear(ack(2, target=(255, 190)))
    b.hear(ack(2, command=400))
    b.hear(ack(2), system=1, component=191)
    b.run_until(0.2)
    assert b.interval_requests() == [(RAW_IMU, 20_000, 0)], "still waiting"
    b.hear(ack(0, target=(0, 0)))
    b.run_until(0.25)
    assert len(b.interval_requests()) == 2, "an answer without targets is ours"


def test_a_reboot_asks_for_everything_again(bench):
    b = bench()
    b.vehicle_heartbeat()
    b.run_until(0.05)
    b.hear(ack(0))
    b.companion.ask_again(b.now_ns)
    b.run_until(0.2)
    assert [message for message, _, _ in b.interval_requests()].count(RAW_IMU) == 2


def test_echoes_of_our_own_are_ignored_silently_and_a_clash_is_said(bench):
    b = bench()
    b.vehicle_heartbeat()
    b.run_until(3.0)
    own = b.of_type("HEARTBEAT")[-1]
    echo = mavlink.MAVLink_heartbeat_message(18, 8, 0, 0, 1, 3)
    assert not b.hear(echo, system=1, component=193, sequence=own.get_seq())
    assert not b.hear(raw_imu(), system=1, component=193)
    assert b.companion.own_ids.clashes == 0
    for _ in range(3):
        b.hear(echo, system=1, component=193, sequence=200)
    assert b.companion.own_ids.clashes == 3
    assert len([note for note in b.notes if "another component speaks as 1/193" in note]) == 1


def test_a_ground_station_that_asks_for_streams_is_the_suspect(bench):
    b = bench()
    b.vehicle_heartbeat()

    def beat():
        if b.now_ns % SECOND == 0:
            b.vehicle_heartbeat()
        if len(b.of_type("COMMAND_LONG")) > len(acked):
            acked.append(b.hear(ack(0)))
        b.hear(raw_imu(b.now_ns // 1000))
        b.companion.imu_taken("RAW_IMU", b.now_ns, b.now_ns)
        if b.now_ns % (2 * SECOND) == 0:
            b.hear(mavlink.MAVLink_request_data_stream_message(1, 1, 0, 4, 1), system=255, component=190)

    acked = []
    b.run_until(10.0, beat)
    assert any("RAW_IMU arrives at 10" in note and "system 255 also asks" in note for note in b.notes)


def test_of_several_vehicles_the_named_one_is_used(bench):
    named = bench(CompanionSettings(vehicle_system=2))
    named.vehicle_heartbeat(system=1)
    named.vehicle_heartbeat(system=2)
    named.run_until(0.1)
    assert named.of_type("HEARTBEAT")[0].get_srcSystem() == 2


def test_the_verdict_goes_out_as_named_values_where_wanted(bench, estimate):
    b = bench(links=[PortSettings(("attitude_quaternion", "named_values")), PortSettings()])
    b.publish(estimate(t_s=5.0))
    b.companion.set_verdict(1.0, 0.01, float("nan"))
    b.run_until(2.5)
    values = {m.name: m.value for m in b.of_type("NAMED_VALUE_FLOAT")}
    assert values == {"ATT_OK": 1.0, "ATT_TILT": pytest.approx(0.573, abs=0.001)}
    assert len(b.of_type("NAMED_VALUE_FLOAT")) == 2 * 3, "once a second"
    assert b.of_type("NAMED_VALUE_FLOAT", 1) == []


def test_goodbye_is_a_heartbeat_with_poweroff(bench):
    b = bench(links=[PortSettings(), PortSettings()])
    b.vehicle_heartbeat()
    b.run_until(0.1)
    asked = len(b.interval_requests())
    b.stop()
    assert [b.of_type("HEARTBEAT", link)[-1].system_status for link in (0, 1)] == [7, 7]
    assert len(b.interval_requests()) == asked, "nothing is set back unless configured"


def test_goodbye_sets_the_rates_back_where_configured(bench):
    b = bench(CompanionSettings(data=DataSettings(restores=True, further_imu_messages=("SCALED_IMU2",))))
    b.vehicle_heartbeat()
    for t_s in (0.1, 0.2, 0.3, 0.4, 0.5):
        b.run_until(t_s)
        b.hear(ack(0))
    b.stop()
    restored = [message for message, interval_us, _ in b.interval_requests() if interval_us == 0]
    assert sorted(restored) == sorted([RAW_IMU, SCALED_IMU2, ATTITUDE, GPS_RAW_INT, VFR_HUD])


def test_goodbye_sets_back_all_that_was_ever_asked_for(bench):
    """Also what was tried and given up."""
    settings = DataSettings(restores=True, imu_messages=("HIGHRES_IMU", "RAW_IMU"))
    b = bench(CompanionSettings(data=settings))
    b.vehicle_heartbeat()
    b.run_until(0.05)
    b.hear(ack(2))
    b.run_until(0.1)
    b.stop()
    requests = b.interval_requests()
    asked = {message for message, interval_us, _ in requests if interval_us > 0}
    assert {105, RAW_IMU} <= asked
    assert {message for message, interval_us, _ in requests if interval_us == 0} == asked


def test_when_the_autopilot_proves_to_be_another_one_its_own_messages_are_asked_for(bench):
    """A companion that claims a generic autopilot was taken; then the autopilot itself is heard."""
    b = bench()
    for second in range(5):
        b.run_until(float(second))
        b.vehicle_heartbeat(component=140, autopilot=0)
    b.run_until(4.1)
    assert {message for message, _, _ in b.interval_requests()} == {105}
    assert b.companion.sender == (1, 140, 0)
    b.vehicle_heartbeat(autopilot=3)
    b.run_until(4.2)
    assert b.companion.sender == (1, 1, 3)
    assert b.interval_requests()[-1][0] == RAW_IMU
    assert b.of_type("COMMAND_LONG")[-1].target_component == 1
    assert b.hear(raw_imu())
    assert not b.hear(raw_imu(), component=140)


def test_an_autopilot_with_other_firmware_is_asked_for_what_suits_it(bench):
    b = bench()
    b.vehicle_heartbeat(autopilot=12)
    b.run_until(0.1)
    b.run_until(10.0)
    b.vehicle_heartbeat(autopilot=3)
    b.run_until(10.1)
    assert b.interval_requests()[0][0] == SCALED_IMU
    assert b.interval_requests()[-1][0] == RAW_IMU


def heard_by_a_made_up_handler(bench, answer):
    """What a handler of PING, which the companion does not have, was given."""
    b = bench()
    calls = []
    ping = mavlink.MAVLINK_MSG_ID_PING

    def handler(link, frame, now_ns):
        calls.append((link, frame.system, frame.message_id, now_ns))
        return answer

    assert ping not in b.companion.wanted
    b.companion.handlers[ping] = handler
    assert ping in b.companion.wanted, "the framers pass its message on"
    b.now_ns = 5
    return b.hear(mavlink.MAVLink_ping_message(0, 1, 0, 0), system=9), calls


@pytest.mark.parametrize("answer", [True, False])
def test_a_handler_in_the_table_gets_its_message_and_says_whether_it_is_data(bench, answer):
    assert heard_by_a_made_up_handler(bench, answer) == (answer, [(0, 9, mavlink.MAVLINK_MSG_ID_PING, 5)])


def test_any_frame_of_the_dialect_is_survived(dialect):
    """Every message with an empty, a short and a full payload, from everybody, before and after lock-on."""
    from attest_mav.mavlink.wire.framer import Frame  # noqa: PLC0415

    companion = Companion(dialect, CompanionSettings(vehicle_system=1), [("link", PortSettings())], 0)
    sound = mavlink.MAVLink_heartbeat_message(2, 3, 0, 0, 4, 3)
    for _ in range(2):
        for message_id in sorted(companion.wanted):
            for payload in (b"", b"\xff", b"\xff" * 255):
                for sender in ((1, 193), (255, 190)):
                    companion.handle(0, Frame(message_id, *sender, 0, 2, False, payload, 0), 0)
        packed = sound.pack(mavlink.MAVLink(None, srcSystem=1, srcComponent=1))
        companion.handle(0, Frame(0, 1, 1, 0, 2, False, packed[6:-2], 0), 0)
    companion.poll(0)
    assert companion.discovery.vehicle is not None

"""Asking the autopilot for its settings, on virtual time."""

from itertools import pairwise
from math import inf, nan

import pytest
from pymavlink.dialects.v20 import all as pymav

from attest_mav.mavlink.component.companion_settings import CompanionSettings
from attest_mav.mavlink.component.vehicle_data import DataSettings
from attest_mav.vehicle_reports import ParameterSample
from attest_mav.vehicle_settings import Setting, VehicleSettings

BOTH = VehicleSettings(20.0, 0.1)


@pytest.fixture
def curious(bench):
    """A bench whose filter wants to know these settings."""

    def make(default_settings=BOTH, asks=True, **others):
        return bench(CompanionSettings(data=DataSettings(asks=asks, default_settings=default_settings), **others))

    return make


def tell(b, name, setting, value):
    b.companion.parameter_taken(ParameterSample("PARAM_VALUE", 1, 1, b.now_ns, name, setting, value))


def change(b, name, setting, value):
    """A value that nobody asked for, which the autopilot confirms each time that it is asked."""
    asked = all_names(b).count(name)
    tell(b, name, setting, value)
    for _ in range(2):
        end_s = b.now_ns * 1e-9 + 2.0
        while all_names(b).count(name) == asked and b.now_ns * 1e-9 < end_s:
            b.run_until(b.now_ns * 1e-9 + 0.02)
        if all_names(b).count(name) > asked:
            asked = all_names(b).count(name)
            tell(b, name, setting, value)


FOR_FILTERS = {"INS_GYRO_FILTER", "GPS1_DELAY_MS", "GPS_DELAY_MS", "EKF2_GPS_DELAY", "SENS_GPS0_DELAY"}
OF_COPTERS = [
    "AHRS_TRIM_X", "AHRS_TRIM_Y", "AHRS_TRIM_Z", "AHRS_EKF_TYPE", "COMPASS_DEC", "COMPASS_AUTODEC",
]  # fmt: skip
OF_PLANES = [*OF_COPTERS[:3], "PTCH_TRIM_DEG", "FLIGHT_OPTIONS", "Q_ENABLE", *OF_COPTERS[3:]]


def all_names(b):
    return [one.param_id for one in b.of_type("PARAM_REQUEST_READ")]


def names(b):
    """The names of settings that filters want."""
    return [name for name in all_names(b) if name in FOR_FILTERS]


def beat_until(b, t_s, autopilot=3, **ids):
    """Time goes on, with a heartbeat of the vehicle every 0.1 s."""
    b.vehicle_heartbeat(autopilot=autopilot, **ids)
    b.run_until(t_s, every=lambda: b.vehicle_heartbeat(autopilot=autopilot, **ids))


def about_parameters(b):
    return [note for note in b.notes if "gyro low-pass" in note or "GPS delay" in note]


def test_parameters_are_asked_by_name_of_the_autopilots_exact_ids(curious):
    b = curious()
    beat_until(b, 0.5, system=7)
    asked = b.of_type("PARAM_REQUEST_READ")[:2]
    assert [(m.target_system, m.target_component, m.param_index, m.param_id) for m in asked] == [
        (7, 1, -1, "INS_GYRO_FILTER"),
        (7, 1, -1, "GPS1_DELAY_MS"),
    ]
    assert {(m.get_srcSystem(), m.get_srcComponent()) for m in asked} == {(7, 193)}


def test_nothing_is_asked_before_there_is_a_vehicle(curious):
    b = curious()
    b.run_until(5.0)
    assert names(b) == []


@pytest.mark.parametrize(
    ("assumed", "autopilot", "expected"),
    [
        (VehicleSettings(), 3, []),
        (VehicleSettings(nan, 0.1), 3, ["GPS1_DELAY_MS"]),
        (VehicleSettings(20.0, nan), 3, ["INS_GYRO_FILTER"]),
        (BOTH, 12, ["EKF2_GPS_DELAY"]),
        (BOTH, 0, []),
    ],
)
def test_only_what_the_filter_wants_and_the_autopilot_has_is_asked(curious, assumed, autopilot, expected):
    b = curious(assumed)
    beat_until(b, 0.5, autopilot)
    assert names(b) == expected


def test_who_asks_for_nothing_asks_for_no_parameters_and_listens(curious):
    b = curious(asks=False)
    beat_until(b, 3.0)
    assert names(b) == []
    tell(b, "INS_GYRO_FILTER", Setting.LOW_PASS_HZ, 40.0)
    b.run_until(3.1)
    assert about_parameters(b) == ["the autopilot's gyro low-pass is 40 Hz (INS_GYRO_FILTER)"]


def test_what_tells_the_frame_of_an_attitude_is_framed_for_every_filter(curious, dialect):
    wanted = curious(VehicleSettings()).companion.wanted
    assert {dialect.id_of(name) for name in ("PARAM_VALUE", "AUTOPILOT_VERSION", "STATUSTEXT")} <= wanted


@pytest.mark.parametrize(("vehicle_type", "expected"), [(2, OF_COPTERS), (1, OF_PLANES), (22, OF_PLANES)])
def test_the_frame_of_the_attitude_is_asked_for_whatever_the_filter_wants(curious, vehicle_type, expected):
    b = curious(VehicleSettings())
    beat_until(b, 0.9, vehicle_type=vehicle_type)
    assert all_names(b) == expected


def test_of_px4_only_the_declination_is_asked_for(curious):
    b = curious(VehicleSettings())
    beat_until(b, 0.9, autopilot=12)
    assert all_names(b) == ["EKF2_MAG_DECL"]


def test_requests_are_spaced(curious):
    b = curious()
    b.vehicle_heartbeat()
    counts = []
    for step in range(12):
        b.run_until(0.05 * step + 0.001)
        counts.append(len(all_names(b)))
    assert counts[-1] == len(OF_COPTERS) + 2
    assert max(later - sooner for sooner, later in pairwise(counts)) == 1


def test_a_plane_that_hovers_is_asked_for_more_and_for_its_quaternion(curious):
    b = curious(VehicleSettings())
    beat_until(b, 0.9, vehicle_type=1)
    tell(b, "Q_ENABLE", Setting.HOVERS, 0.0)
    beat_until(b, 1.5, vehicle_type=1)
    assert not {"Q_TRIM_PITCH", "Q_TAILSIT_ENABLE", "Q_FRAME_CLASS"} & set(all_names(b))
    assert "ATTITUDE_QUATERNION" not in {stream.name for stream in b.companion.data.stream_manager.streams}
    change(b, "Q_ENABLE", Setting.HOVERS, 1.0)
    beat_until(b, 3.5, vehicle_type=1)
    assert {"Q_TRIM_PITCH", "Q_TAILSIT_ENABLE", "Q_FRAME_CLASS"} <= set(all_names(b))
    assert "ATTITUDE_QUATERNION" in {stream.name for stream in b.companion.data.stream_manager.streams}


def version_requests(b):
    commands = [m for m in b.of_type("COMMAND_LONG") if m.command == pymav.MAV_CMD_REQUEST_MESSAGE]
    return [(m.target_system, m.target_component, m.param1) for m in commands]


def test_the_version_is_asked_for_once_a_boot_and_of_ardupilot_alone(curious):
    b = curious()
    beat_until(b, 20.0, system=7)
    asked = (7, 1, pymav.MAVLINK_MSG_ID_AUTOPILOT_VERSION)
    assert version_requests(b) == [asked]
    b.companion.ask_again(b.now_ns)
    beat_until(b, 25.0, system=7)
    assert version_requests(b) == [asked] * 2
    for silent in (curious(asks=False), curious()):
        beat_until(silent, 5.0, autopilot=12)
        assert version_requests(silent) == []


def test_a_trim_that_is_not_told_is_noted_once_and_a_told_one_by_who_takes_it_off(curious):
    b = curious(VehicleSettings())
    beat_until(b, 1.0)
    tell(b, "COMPASS_DEC", Setting.DECLINATION, 0.1)
    beat_until(b, 120.0)
    assert [note for note in b.notes if note.startswith("the autopilot")] == [
        "the autopilot does not tell its trim (AHRS_TRIM_X): a steady offset of its attitude is measured instead"
    ]
    told = curious(VehicleSettings())
    beat_until(told, 1.0)
    tell(told, "AHRS_TRIM_X", Setting.TRIM_X, 0.1)
    beat_until(told, 120.0)
    assert [note for note in told.notes if note.startswith("the autopilot")] == []


def test_an_answer_ends_the_asking_and_is_said_once(curious):
    b = curious()
    beat_until(b, 0.5)
    tell(b, "INS_GYRO_FILTER", Setting.LOW_PASS_HZ, 20.0)
    tell(b, "GPS1_DELAY_MS", Setting.FIX_DELAY_S, 0.22)
    tell(b, "INS_GYRO_FILTER", Setting.LOW_PASS_HZ, 20.0)
    beat_until(b, 90.0)
    assert len(names(b)) == 2
    assert about_parameters(b) == [
        "the autopilot's gyro low-pass is 20 Hz (INS_GYRO_FILTER)",
        "the autopilot's GPS delay is 0.22 s (GPS1_DELAY_MS)",
    ]


def test_a_change_is_said(curious):
    b = curious()
    beat_until(b, 0.5)
    tell(b, "INS_GYRO_FILTER", Setting.LOW_PASS_HZ, 20.0)
    tell(b, "INS_GYRO_FILTER", Setting.LOW_PASS_HZ, 20.0)
    change(b, "INS_GYRO_FILTER", Setting.LOW_PASS_HZ, 80.0)
    b.run_until(b.now_ns * 1e-9 + 0.1)
    assert [note for note in b.notes if "low-pass" in note][-1].endswith("is 80 Hz (INS_GYRO_FILTER)")
    assert len(about_parameters(b)) == 2


def test_a_default_that_the_autopilot_does_not_tell_is_an_answer(curious):
    b = curious(VehicleSettings(nan, 0.1))
    beat_until(b, 0.5)
    tell(b, "GPS1_DELAY_MS", Setting.FIX_DELAY_S, nan)
    beat_until(b, 20.0)
    assert names(b) == ["GPS1_DELAY_MS"]
    assert about_parameters(b) == [
        "the autopilot's GPS delay is left to a driver (GPS1_DELAY_MS is 0): 0.1 s is assumed"
    ]


def test_a_silent_autopilot_is_asked_ever_more_seldom_by_each_name_and_then_let_be(curious):
    b = curious(VehicleSettings(nan, 0.1))
    count, times = 0, []
    b.vehicle_heartbeat()
    while b.now_ns < 120e9:
        b.run_until(b.now_ns * 1e-9 + 0.5)
        b.vehicle_heartbeat()
        times += [round(b.now_ns * 1e-9)] * (len(names(b)) - count)
        count = len(names(b))
    assert times == pytest.approx([0, 1, 3, 7, 15, 31], abs=1)
    assert names(b) == ["GPS1_DELAY_MS", "GPS_DELAY_MS"] * 3
    assert about_parameters(b) == [
        "the autopilot does not tell its GPS delay (GPS1_DELAY_MS or GPS_DELAY_MS): 0.1 s is assumed"
    ]


def test_a_reboot_and_a_return_ask_again(curious):
    b = curious(VehicleSettings(20.0, nan))
    beat_until(b, 0.5)
    tell(b, "INS_GYRO_FILTER", Setting.LOW_PASS_HZ, 20.0)
    beat_until(b, 2.0)
    b.companion.ask_again(b.now_ns)
    beat_until(b, 2.5)
    assert names(b) == ["INS_GYRO_FILTER"] * 2, "it may have been set to something else before the reboot"
    tell(b, "INS_GYRO_FILTER", Setting.LOW_PASS_HZ, 20.0)
    b.companion.link_broken(0)
    b.run_until(3.5)
    assert len(names(b)) == 2, "nobody is there to answer"
    beat_until(b, 4.0)
    assert names(b) == ["INS_GYRO_FILTER"] * 3
    assert len(about_parameters(b)) == 1, "nothing new was learned"


def test_nobody_is_asked_while_the_vehicle_is_silent(curious):
    b = curious(VehicleSettings(20.0, nan))
    b.vehicle_heartbeat()
    b.run_until(60.0)
    assert len(names(b)) <= 3
    assert about_parameters(b) == []


def test_another_vehicle_is_asked_anew(curious):
    b = curious(VehicleSettings(20.0, nan))
    beat_until(b, 0.5, component=140)
    assert names(b) == [], "a component that is not the autopilot is waited with"
    beat_until(b, 3.8, component=140)
    tell(b, "INS_GYRO_FILTER", Setting.LOW_PASS_HZ, 20.0)
    beat_until(b, 4.5, component=1)
    tell(b, "INS_GYRO_FILTER", Setting.LOW_PASS_HZ, 20.0)
    b.run_until(4.6)
    asked = [m for m in b.of_type("PARAM_REQUEST_READ") if m.param_id == "INS_GYRO_FILTER"]
    assert [m.target_component for m in asked] == [140, 1]
    assert len(about_parameters(b)) == 2


def test_asking_sets_no_loop_spinning(curious):
    b = curious()
    b.vehicle_heartbeat()
    b.run_until(0.2)
    assert 0 < b.companion.next_deadline_ns - b.now_ns < inf

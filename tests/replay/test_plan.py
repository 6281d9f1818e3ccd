from inspect import signature

import pytest

from attest_mav.errors import UnreadableDataError, UsageError
from attest_mav.logs.tlog.source import TlogSource
from attest_mav.replay.plan import check_names, make_plan, replayable

LEVEL = {"ATTITUDE_QUATERNION": {"q1": 1.0}}
"""Fields of messages whose zeros are no attitude."""


def changed(record, **changes):
    """The record with some other values."""
    kind = type(record)
    return kind(**{name: getattr(record, name) for name in signature(kind).parameters} | changes)


def plan_of(log, imu=None, reference=None):
    return make_plan(TlogSource(log.data, log.dialect).summary(), imu, reference)


def fill(log, **counts):
    for name, count in counts.items():
        for k in range(count):
            log.imu(1000 + 20 * k, name) if "IMU" in name else log.add(name, 1000 + 20 * k, LEVEL.get(name, {}))


@pytest.mark.parametrize(
    ("autopilot", "counts", "chosen"),
    [
        (3, {"SCALED_IMU2": 50, "RAW_IMU": 50}, "RAW_IMU"),
        (3, {"SCALED_IMU2": 52, "RAW_IMU": 50}, "RAW_IMU"),  # a few more make no better sensor
        (3, {"SCALED_IMU2": 50, "RAW_IMU": 10}, "SCALED_IMU2"),
        (3, {"SCALED_IMU3": 50}, "SCALED_IMU3"),
        (12, {"HIGHRES_IMU": 50, "SCALED_IMU": 50}, "SCALED_IMU"),  # PX4 subtracts its biases from HIGHRES_IMU
        (0, {"RAW_IMU": 50, "SCALED_IMU2": 50}, "SCALED_IMU2"),  # nobody knows what its RAW_IMU counts mean
    ],
)
def test_the_inertial_message_is_the_best_of_the_frequent_ones(log, autopilot, counts, chosen):
    log.heartbeat(autopilot=autopilot)
    fill(log, **counts)
    assert plan_of(log).imu == chosen


@pytest.mark.parametrize(
    ("present", "reference", "autopilot", "timing"),
    [
        (("SIM_STATE", "SIMSTATE", "ATTITUDE_QUATERNION", "ATTITUDE"), "SIM_STATE", "ATTITUDE", "ATTITUDE"),
        (("SIMSTATE", "ATTITUDE_QUATERNION", "ATTITUDE"), "SIMSTATE", "ATTITUDE", "ATTITUDE"),
        (("SIMSTATE", "ATTITUDE_QUATERNION"), "SIMSTATE", "ATTITUDE_QUATERNION", "ATTITUDE_QUATERNION"),
        (("SIM_STATE",), "SIM_STATE", None, "RAW_IMU"),
        (("ATTITUDE_QUATERNION", "ATTITUDE"), "ATTITUDE_QUATERNION", None, None),
        (("ATTITUDE",), "ATTITUDE", None, None),
        (("AHRS2",), None, None, None),  # another filter of the autopilot: only when it is asked for
        ((), None, None, None),
    ],
)
def test_the_reference_is_chosen_in_the_order_of_the_contract(log, present, reference, autopilot, timing):
    log.heartbeat()
    fill(log, RAW_IMU=2, **dict.fromkeys(present, 1))
    plan = plan_of(log)
    assert (plan.reference, plan.autopilot, plan.timing) == (reference, autopilot, timing)


@pytest.mark.parametrize(
    ("present", "velocity_lack", "duration_s", "chosen"),
    [
        ("ATTITUDE", "", 5.0, "smoothed"),
        ("ATTITUDE", "it has no GPS_RAW_INT", 5.0, "ATTITUDE"),
        ("ATTITUDE", "", 5.1, "ATTITUDE"),  # 50 samples: less than 10 Hz
        ("SIM_STATE", "", 5.0, "SIM_STATE"),
    ],
    ids=["allowed", "no velocity", "slow", "truth"],
)
def test_without_a_truth_the_smoothed_attitude_is_chosen_where_the_log_allows_it(
    log, present, velocity_lack, duration_s, chosen
):
    log.heartbeat()
    fill(log, RAW_IMU=50, **{present: 50})
    summary = TlogSource(log.data, log.dialect).summary()
    vehicle = changed(summary.vehicles[1, 1], velocity_lack=velocity_lack)
    summary = changed(summary, vehicles={(1, 1): vehicle}, duration_s=duration_s)
    assert make_plan(summary, None, None, smooths=True).reference == chosen
    assert make_plan(summary, None, None).reference == present


def test_the_smoothed_attitude_is_no_message_and_the_autopilots_is_compared_with_it(log):
    log.heartbeat()
    fill(log, RAW_IMU=5, ATTITUDE=5)
    plan = plan_of(log, reference="smoothed")
    assert (plan.reference, plan.autopilot, plan.timing) == ("smoothed", "ATTITUDE", None)
    assert plan.messages == {"RAW_IMU", "ATTITUDE"}
    check_names(None, "smoothed")


def test_what_is_named_is_taken(log):
    log.heartbeat()
    fill(log, RAW_IMU=9, SCALED_IMU2=1, ATTITUDE=9, SIM_STATE=9, AHRS2=1)
    plan = plan_of(log, "SCALED_IMU2", "AHRS2")
    assert (plan.imu, plan.reference, plan.autopilot, plan.timing) == ("SCALED_IMU2", "AHRS2", "ATTITUDE", "ATTITUDE")


def test_what_is_named_but_not_there_is_an_error_that_tells_what_is(log):
    log.heartbeat()
    fill(log, RAW_IMU=9, ATTITUDE=9)
    with pytest.raises(UnreadableDataError, match=r"no SIM_STATE.*it has ATTITUDE$"):
        plan_of(log, reference="SIM_STATE")
    with pytest.raises(UnreadableDataError, match=r"no HIGHRES_IMU.*it has RAW_IMU$"):
        plan_of(log, imu="HIGHRES_IMU")


def test_a_log_without_inertial_messages_is_an_error(log):
    log.heartbeat()
    fill(log, ATTITUDE=9)
    with pytest.raises(UnreadableDataError, match="no RAW_IMU or SCALED_IMU"):
        plan_of(log)


def test_names_that_cannot_be_meant_are_usage_errors():
    check_names("RAW_IMU", "AHRS2")
    check_names(None, None)
    with pytest.raises(UsageError, match=r"'ATTITUDE'; known: RAW_IMU"):
        check_names("ATTITUDE", None)
    with pytest.raises(UsageError, match=r"'RAW_IMU'; known: SIM_STATE"):
        check_names(None, "RAW_IMU")


@pytest.mark.parametrize(
    ("counts", "reference"),
    [
        ({"ATTITUDE_QUATERNION": 2, "ATTITUDE": 60}, "ATTITUDE"),  # a companion asked twice
        ({"ATTITUDE_QUATERNION": 20, "ATTITUDE": 60}, "ATTITUDE"),
        ({"ATTITUDE_QUATERNION": 50, "ATTITUDE": 60}, "ATTITUDE_QUATERNION"),
        ({"SIM_STATE": 10, "ATTITUDE": 60}, "SIM_STATE"),  # truth is worth more than number
        ({"SIM_STATE": 2, "ATTITUDE": 60}, "ATTITUDE"),
        ({"SIM_STATE": 2, "SIMSTATE": 50, "ATTITUDE": 60}, "SIMSTATE"),
    ],
)
def test_a_few_messages_do_not_make_a_reference(log, counts, reference):
    log.heartbeat()
    for k in range(60):
        for name, count in counts.items():
            if k * count // 60 != (k - 1) * count // 60:
                log.add(name, 1000 + 20 * k, LEVEL.get(name, {}))
        log.imu(1000 + 20 * k)
    assert plan_of(log).reference == reference


def test_a_reference_of_the_first_seconds_alone_is_none(log):
    log.heartbeat()
    for k in range(400):
        log.imu(1000 + 20 * k)
        log.attitude(1000 + 20 * k)
        if k < 100:
            log.add("ATTITUDE_QUATERNION", 1000 + 20 * k, {"q1": 1.0})
            log.add("ATTITUDE_QUATERNION", 1001 + 20 * k, {"q1": 1.0})
            log.add("ATTITUDE_QUATERNION", 1002 + 20 * k, {"q1": 1.0})
    assert plan_of(log).reference == "ATTITUDE"


def test_quaternions_that_are_zero_are_no_reference(log):
    log.heartbeat()
    for k in range(60):
        log.imu(1000 + 20 * k)
        log.attitude(1000 + 20 * k)
        log.add("ATTITUDE_QUATERNION", 1000 + 20 * k, {})
    assert plan_of(log).reference == "ATTITUDE"


def test_quaternions_of_the_secondary_estimator_are_no_reference(log):
    log.heartbeat()
    log.add("STATUSTEXT", 0, {"text": b"ArduCopter V3.6.8 (0a1b2c3d)", "severity": 6})
    for k in range(60):
        log.imu(1000 + 20 * k)
        log.attitude(1000 + 20 * k)
        log.add("ATTITUDE_QUATERNION", 1000 + 20 * k, {"q1": 1.0})
    assert plan_of(log).reference == "ATTITUDE"


def test_nor_where_there_is_nothing_else_to_compare_with(log):
    log.heartbeat()
    log.add("STATUSTEXT", 0, {"text": b"ArduCopter V3.6.8 (0a1b2c3d)", "severity": 6})
    for k in range(60):
        log.imu(1000 + 20 * k)
        log.add("ATTITUDE_QUATERNION", 1000 + 20 * k, {"q1": 1.0})
    summary = TlogSource(log.data, log.dialect).summary()
    plan = make_plan(summary, None, None)
    assert (plan.reference, plan.autopilot) == (None, None)
    assert "secondary" in summary.vehicles[plan.vehicle].unfit["ATTITUDE_QUATERNION"]


@pytest.fixture
def two_vehicles(log):
    """1/1 has most inertial messages, then 2/1; a camera has none."""
    for sender, count in (((1, 1), 30), ((2, 1), 20)):
        log.heartbeat(sender=sender)
        for k in range(count):
            log.imu(1000 + 20 * k, sender=sender)
    log.heartbeat(autopilot=8, sender=(1, 100))
    return TlogSource(log.data, log.dialect).summary()


@pytest.mark.parametrize(
    ("wanted", "vehicle"), [(None, (1, 1)), ((1, None), (1, 1)), ((2, None), (2, 1)), ((2, 1), (2, 1))]
)
def test_a_vehicle_can_be_named(two_vehicles, wanted, vehicle):
    assert make_plan(two_vehicles, None, None, wanted).vehicle == vehicle
    assert [one.vehicle for one in replayable(two_vehicles)] == [(1, 1), (2, 1)]


@pytest.mark.parametrize(
    ("wanted", "words"),
    [
        ((3, None), "no vehicle 3 in it; it has 1/1, 2/1"),
        ((1, 2), "no vehicle 1/2 in it; it has 1/1, 2/1"),
        ((1, 100), "of vehicle 1/100 in it: nothing to estimate an attitude from"),
    ],
)
def test_a_vehicle_that_is_not_there_is_an_error_that_names_the_others(two_vehicles, wanted, words):
    with pytest.raises(UnreadableDataError, match=words):
        make_plan(two_vehicles, None, None, wanted)

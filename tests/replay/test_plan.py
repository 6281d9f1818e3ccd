import pytest

from attest_mav.errors import UnreadableDataError, UsageError
from attest_mav.logs.tlog.source import TlogSource
from attest_mav.replay.plan import check_names, make_plan


def plan_of(log, imu=None, reference=None):
    return make_plan(TlogSource(log.data, log.dialect).summary(), imu, reference)


def fill(log, **counts):
    for name, count in counts.items():
        for k in range(count):
            log.imu(1000 + 20 * k, name) if "IMU" in name else log.add(name, 1000 + 20 * k, {})


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

import pytest

from attest_mav.errors import UnreadableDataError
from attest_mav.evaluation.fault_study.card import Fault, FaultCard, FaultGroup, bounds_of, read_card

CARD = """{"clock": "time_boot_ms / 1000", "leave_out": [[30, 34]], "faults": [
 {"fault": "imu2 gyro x +5 deg/s", "start_s": 10.0, "end_s": 20.0},
 {"fault": "imu1 accel stuck at 5", "start_s": 28.0, "end_s": 30.0},
 {"fault": "both gyros z +3 deg/s", "start_s": 90.0, "end_s": 100.0},
 {"fault": "vibration 20 m/s2", "start_s": 140.0, "end_s": 150.0}]}"""


def test_a_card_tells_who_is_at_fault_and_what_is_required():
    card = read_card(CARD)
    assert [fault.accused for fault in card.faults] == [("SCALED_IMU2", "gyro x"), ("RAW_IMU",), (), ()]
    assert [fault.group for fault in card.faults] == [
        FaultGroup.SINGLE,
        FaultGroup.SINGLE,
        FaultGroup.BOTH_VERTICAL,
        FaultGroup.VIBRATION,
    ]
    assert card.leave_out == ((30.0, 34.0),)


def test_a_fault_lasts_until_the_next_one_or_for_a_time():
    card = FaultCard((Fault("a", 10.0, 20.0), Fault("b", 28.0, 30.0)))
    assert card.window(0) == (10.0, 28.0)
    assert card.window(1) == (28.0, 55.0)


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"faults": [{"fault": "x"}]}'])
def test_a_card_that_is_none_is_refused(text):
    with pytest.raises(UnreadableDataError, match="card"):
        read_card(text)


def test_sensors_that_fail_together_may_blind_for_longer():
    assert bounds_of(FaultGroup.SINGLE)["blind"] < bounds_of(FaultGroup.BOTH_SENSORS)["blind"]
    assert "ours" not in bounds_of(FaultGroup.BOTH_VERTICAL)

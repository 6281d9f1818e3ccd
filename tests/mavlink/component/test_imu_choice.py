import pytest

from attest_mav.mavlink.component.imu_choice import ImuChoice, preferred_messages

SECOND = 1_000_000_000


@pytest.mark.parametrize(("autopilot", "first"), [(3, "RAW_IMU"), (12, "SCALED_IMU"), (0, "HIGHRES_IMU")])
def test_preference_goes_by_the_autopilot(autopilot, first):
    messages = preferred_messages(autopilot)
    assert messages[0] == first
    assert len(set(messages)) == len(messages)


def test_the_first_that_gives_samples_is_taken_and_no_other():
    choice = ImuChoice(["A", "B"], 0)
    assert not choice.take("B", 1)
    assert choice.take("A", 2)
    assert choice.chosen == "A"
    assert not choice.take("B", 3)


def test_refused_or_missing_gives_way_to_the_next_round_and_round():
    choice = ImuChoice(["A", "B"], 0)
    assert not choice.poll(False, SECOND)
    assert choice.poll(True, SECOND)
    assert choice.candidate == "B"
    assert choice.poll(False, choice.next_deadline_ns)
    assert choice.candidate == "A"
    assert choice.next_deadline_ns >= 10 * SECOND, "no hurry once all were tried"


def test_a_chosen_message_that_stops_begins_the_choice_again():
    choice = ImuChoice(["A", "B"], 0)
    choice.poll(True, 0)
    choice.take("B", SECOND)
    assert not choice.poll(False, choice.next_deadline_ns - 1)
    assert choice.poll(False, choice.next_deadline_ns)
    assert choice.chosen == ""
    assert choice.candidate == "A"


def test_one_message_alone_is_asked_for_again():
    choice = ImuChoice(["A"], 0)
    assert choice.poll(False, choice.next_deadline_ns)
    assert choice.candidate == "A"


def test_where_all_are_refused_each_is_waited_for():
    """Messages may come although every command is denied."""
    choice = ImuChoice(["A", "B"], 0)
    assert choice.poll(True, 0)
    assert choice.poll(True, 0)
    assert choice.candidate == "A"
    assert not choice.poll(True, SECOND), "no round of requests without a pause"
    assert choice.take("A", 2 * SECOND)

"""Recorded faults, flown by the daemon's own core: pieces of a copter's flights that circles at 7 m/s."""

from pathlib import Path

import pytest

from attest_mav.errors import UnreadableDataError
from attest_mav.evaluation.fault_study.card import read_card
from attest_mav.evaluation.fault_study.study import run, tasks_of

DATA = Path(__file__).parent.parent.parent / "data"


def flown(name):
    card = read_card((DATA / f"{name}.json").read_text())
    (task,) = tasks_of((DATA / f"{name}.tlog").read_bytes(), card, "", 0)
    (found,) = run(task)
    return found


def test_a_gyro_that_steps_is_set_aside_and_named_and_the_misled_autopilot_contradicted():
    found = flown("copter_gyro_step")
    figures = found.figures
    assert figures["autopilot tilt"] > 10.0
    assert figures["blind"] <= 0.5
    assert figures["false"] == 0.0
    assert figures["disagree"] <= 1.2
    assert figures["ours"] <= 1.0
    assert found.named == "RAW_IMU"
    assert figures["named"] <= 2.0
    assert figures["named right"] == 1.0


def test_a_receiver_that_makes_no_sense_is_not_used():
    """By itself, the filter is led astray by 40 degrees."""
    figures = flown("copter_receiver_noise").figures
    assert figures["ours"] <= 1.0
    assert figures["false"] == figures["blind"] == 0.0
    assert figures["mute"] <= 3.0


def test_two_gyros_that_step_together_are_found_by_receiver_and_field():
    figures = flown("copter_both_gyros").figures
    assert figures["autopilot tilt"] > 5.0
    assert figures["blind"] <= 1.0
    assert figures["above 3"] <= 0.4
    assert figures["false"] == 0.0


def test_with_one_sensor_alone_the_receiver_is_still_seen_through():
    card = read_card((DATA / "copter_receiver_noise.json").read_text())
    (task,) = tasks_of((DATA / "copter_receiver_noise.tlog").read_bytes(), card, "", 1)
    (found,) = run(task)
    assert found.figures["ours"] <= 1.0
    assert found.figures["false"] == 0.0


@pytest.mark.parametrize("wanted", ["gyro x +2", "receiver"])
def test_only_faults_that_are_asked_for_are_put_into_a_clean_flight(wanted):
    tasks = tasks_of(b"", None, wanted, 0)
    assert tasks[0].injected is None
    assert len(tasks) > 1


@pytest.mark.parametrize(
    ("name", "reason"), [("copter_trim_told", "no true attitude"), ("plane_circles_turn", "a flight of more than 60 s")]
)
def test_a_log_that_cannot_be_studied_is_refused(name, reason):
    (task, *_) = tasks_of((DATA / f"{name}.tlog").read_bytes(), None, "", 0)
    with pytest.raises(UnreadableDataError, match=reason):
        run(task)

"""Figures of flights made by hand: a row each tenth of a second."""

from math import isnan, nan

import numpy as np
import pytest

from attest_mav.estimation.events import Agreement
from attest_mav.evaluation.fault_study.card import Fault
from attest_mav.evaluation.fault_study.figures import figures_of
from attest_mav.evaluation.fault_study.flown import FlownFaults, Track
from attest_mav.evaluation.fault_study.table import HEADER, lines_of, missed

AGREE, DISAGREE, UNDECIDED = Agreement.AGREE, Agreement.DISAGREE, Agreement.UNDECIDED
T_S = np.arange(0.0, 20.0, 0.1)
FAULT = Fault("imu1 gyro x +5 deg/s", 5.0, 10.0, accused=("RAW_IMU", "gyro x"))
WINDOW = (5.0, 20.0)


def track(tilt, heading=0.0):
    return Track(T_S, np.broadcast_to(tilt, T_S.shape), np.broadcast_to(heading, T_S.shape), np.full(T_S.shape, 0.2))


def between(first_s, last_s, value, otherwise=0.0):
    return np.where((first_s - 1e-6 <= T_S) & (last_s - 1e-6 > T_S), value, otherwise)


def figures(autopilot, said, ours=0.3, events=(), leave_out=()):
    flown = FlownFaults(track(autopilot), said.astype(int), track(ours), tuple(events))
    return figures_of(FAULT, flown, WINDOW, leave_out)


def test_agreeing_with_a_wrong_autopilot_is_blind():
    found = figures(between(6.0, 8.0, 8.0), np.full(T_S.shape, AGREE)).figures
    assert found["blind"] == pytest.approx(2.0)
    assert found["autopilot tilt"] == 8.0
    assert isnan(found["disagree"])


def test_the_delay_counts_from_three_degrees():
    tilt = np.clip(T_S - 5.0, 0.0, 10.0)
    found = figures(tilt, between(9.0, 20.0, DISAGREE, AGREE)).figures
    assert found["disagree"] == pytest.approx(0.9, abs=0.11)
    assert found["blind"] == 0.0


def test_an_alarm_is_false_a_second_after_the_autopilot_came_back():
    found = figures(between(6.0, 8.0, 8.0), between(7.0, 11.0, DISAGREE, AGREE)).figures
    assert found["false"] == pytest.approx(2.0, abs=0.11)


def test_undecided_beside_a_right_autopilot_is_mute():
    found = figures(between(6.0, 8.0, 8.0), between(6.0, 9.0, UNDECIDED, AGREE)).figures
    assert found["mute"] == pytest.approx(1.0)


def test_a_touch_down_is_left_out():
    found = figures(between(6.0, 8.0, 8.0), np.full(T_S.shape, AGREE), leave_out=[(6.0, 8.0)]).figures
    assert found["blind"] == 0.0


def test_our_own_attitude_above_three_degrees():
    found = figures(0.0, np.full(T_S.shape, AGREE), ours=between(6.0, 7.0, 3.5, nan)).figures
    assert found["above 3"] == pytest.approx(1.0)
    assert found["ours"] == 3.5


@pytest.mark.parametrize(("text", "right"), [("RAW_IMU: gyro x +5.0", 1.0), ("RAW_IMU: gyro y +5.0", 0.0)])
def test_the_first_source_named_is_right_or_not(text, right):
    events = [(4.0, "FAULTY", "SCALED_IMU2: before"), (6.5, "FAULTY", text), (7.0, "FAULTY", "SCALED_IMU2: later")]
    found = figures(0.0, np.full(T_S.shape, AGREE), events=events)
    assert found.named == "RAW_IMU"
    assert found.figures["named"] == pytest.approx(1.5)
    assert found.figures["named right"] == right


def test_a_row_is_at_most_80_columns_wide_and_marks_what_is_missed():
    found = figures(between(6.0, 8.0, 108.0), np.full(T_S.shape, AGREE), events=[(6.5, "FAULTY", "RAW_IMU: gyro y")])
    assert missed(found) == ["blind"]
    line = lines_of(found)
    assert len(line) <= 80
    assert len(HEADER) <= 80
    assert "2.00!" in line
    assert line.endswith("raw1.5?")

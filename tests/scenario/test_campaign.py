"""Disturbances one after another in one flight: drawn with a seed, at times of their own, each with its bounds."""

import subprocess
import sys
from collections import Counter
from itertools import pairwise
from pathlib import Path

import pytest

from attest_mav.estimation.events import Agreement
from attest_mav.evaluation.disturbed_flights.campaign import movable, moved, plan
from attest_mav.evaluation.disturbed_flights.row import Disturbance
from attest_mav.evaluation.disturbed_flights.table import ROWS

TOOL = Path(__file__).parents[2] / "tools" / "disturbed_flights"


def command(*arguments):
    return subprocess.run([sys.executable, "-P", str(TOOL), *arguments], capture_output=True, text=True, check=False)


def test_rows_do_not_overlap_and_all_come_before_one_comes_again():
    choice = [row.name for row in ROWS if movable(row)]
    drawn = plan(ROWS, 2 * len(choice), 7)
    assert all(later.begin_s >= sooner.end_s + sooner.after_s for sooner, later in pairwise(drawn))
    assert Counter(row.name for row in drawn[: len(choice)]) == Counter(choice)
    assert Counter(row.name for row in drawn) == Counter(2 * choice)


def test_the_seed_decides_the_order():
    assert [row.name for row in plan(ROWS, 9, 1)] == [row.name for row in plan(ROWS, 9, 1)]
    assert [row.name for row in plan(ROWS, 9, 1)] != [row.name for row in plan(ROWS, 9, 2)]


def test_faults_on_board_move_with_their_row():
    row = moved(Disturbance("any", faults=("gyro1-bias-x=5@15+10", "receiver-off@15+40")), 123.456)
    assert row.faults == ("gyro1-bias-x=5@123.456+10", "receiver-off@123.456+40")
    assert row.begin_s == 123.456
    assert row.end_s == pytest.approx(133.456)


def test_only_doubt_is_forgiven_in_a_campaign():
    row = moved(Disturbance("any", tilt_deg=1.0, accused_s=2.0, sign="x", detected_s=3.0, after_s=12.0), 20.0)
    assert row.verdicts == {Agreement.AGREE, Agreement.UNDECIDED}
    assert (row.recovered_s, row.tilt_deg, row.accused_s, row.sign, row.detected_s) == (12.0, 2.0, 2.0, "x", 3.0)


def test_rows_that_need_a_start_of_their_own_are_left_out():
    assert not movable(Disturbance("any", faults=("reboot@15",)))
    assert not movable(Disturbance("any", begin_s=0.0))
    assert not movable(Disturbance("any", personality="px4"))
    assert movable(Disturbance("any"))


def test_the_command_flies_rows_in_one_flight():
    done = command("three times", "vibrates", "--in-one-flight", "2", "--seed", "2")
    assert done.returncode == 0, done.stdout
    assert len(done.stdout.splitlines()) == 2 + 2
    assert "MISSED" not in done.stdout


def test_the_command_says_what_it_cannot_fly():
    done = command("reboots", "--in-one-flight", "3")
    assert done.returncode == 2
    assert "one at least that can stand anywhere in a flight" in done.stderr

from math import nan, radians

import pytest

from attest_mav.algebra import q_from_euler, q_heading, q_mul
from attest_mav.replay.comparison import Attitude, Comparison
from attest_mav.replay.reference_track import ReferenceTrack
from attest_mav.types import North

MS = 1_000_000
LEVEL = q_heading(0.0)


class Rows:
    def __init__(self):
        self.rows = []

    def write(self, row):
        self.rows.append(row)


def attitude(t_ms, q_nb=LEVEL, north=North.TRUE, counted=True):
    return Attitude(t_ms * MS, 1e-3 * t_ms, q_nb, north, nan, nan, counted)


def comparison_with(*reference_ms):
    track, rows = ReferenceTrack(), Rows()
    for t_ms in reference_ms:
        track.add(t_ms * MS, LEVEL, None)
    return track, rows, Comparison("ours", track, rows)


def test_roll_of_three_degrees_and_yaw_of_five_are_tilt_and_heading():
    _, _, comparison = comparison_with(0)
    # Turned by 5 degrees about the vertical after rolling: the gravity direction moves by the roll alone.
    q = q_mul(q_heading(radians(5.0)), q_from_euler(radians(3.0), 0.0, 0.0))
    comparison.add(attitude(0, q))
    tilt, heading = comparison.errors.tilt(), comparison.errors.heading()
    assert tilt is not None
    assert heading is not None
    assert tilt.rms == pytest.approx(3.0)
    assert heading.rms == pytest.approx(5.0, rel=1e-6)


def test_an_attitude_waits_for_the_reference_to_reach_it():
    track, rows, comparison = comparison_with(0)
    comparison.add(attitude(10))
    assert rows.rows == []
    track.add(20 * MS, LEVEL, None)
    comparison.settle()
    assert [row.tilt for row in rows.rows] == [0.0]


def test_a_reference_that_stopped_is_not_waited_for():
    _, rows, comparison = comparison_with(0)
    for t_ms in range(100, 10_000, 100):
        comparison.add(attitude(t_ms))
    assert len(rows.rows) == len(range(100, 10_000, 100)) - 41  # 4 s of them still wait
    assert all(row.tilt is None for row in rows.rows)
    comparison.finish()
    assert len(rows.rows) == 99
    assert comparison.errors.samples == 0
    assert comparison.errors.tilt() is None


def test_what_is_not_counted_has_a_row_but_no_part_in_the_figures():
    _, rows, comparison = comparison_with(0, 100)
    comparison.add(attitude(0, counted=False))
    comparison.add(attitude(50))
    assert comparison.errors.samples == 1
    assert len(rows.rows) == 2


def test_a_heading_without_north_is_not_compared():
    _, rows, comparison = comparison_with(0)
    comparison.add(attitude(0, north=North.RELATIVE))
    assert comparison.errors.samples == 1
    assert comparison.errors.heading() is None
    assert rows.rows[0].heading is None


def test_attitudes_from_before_a_restart_are_given_up():
    track, rows, comparison = comparison_with(900_000)
    comparison.add(attitude(900_010))
    comparison.add(attitude(2_000))
    assert [row.tilt for row in rows.rows] == [None, None]  # the second is older than the reference
    track.add(3_000 * MS, LEVEL, None)
    comparison.add(attitude(3_000))
    assert rows.rows[-1].tilt == 0.0


def test_clocks_that_wrap_after_49_days_meet_those_that_do_not():
    wrap_ms = 1 << 32
    track, rows, comparison = comparison_with(5)
    del track
    comparison.add(attitude(wrap_ms + 5))
    assert rows.rows[0].tilt == 0.0

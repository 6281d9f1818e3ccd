"""Tables in files, the median of a table, and the largest of late over runs of rows."""

import numpy as np
import pytest

from attest_mav.smoothing.held_largest import HeldLargest
from attest_mav.smoothing.selection import median
from attest_mav.smoothing.tables import Scratch

ROW = np.dtype([("t_s", "<f8"), ("count", "<i8")])


def rows(times):
    out = np.zeros(len(times), ROW)
    out["t_s"], out["count"] = times, range(len(times))
    return out


class Closing:
    def __init__(self, closed):
        self._closed = closed

    def close(self):
        self._closed.append(self)


def test_rows_come_back_as_they_were_appended_and_written_over():
    table = Scratch().table(ROW)
    for one in rows([1.0, 2.0, 3.0]):
        table.append(one.tobytes())
    table.write(1, rows([20.0]))
    table.append(rows([4.0, 5.0]).tobytes())
    assert len(table) == 5
    assert table.rows(0, 5)["t_s"].tolist() == [1.0, 20.0, 3.0, 4.0, 5.0]
    assert np.concatenate(list(table.column("count"))).tolist() == [0, 0, 2, 0, 1]


@pytest.mark.parametrize(("behind_equal", "expected"), [(False, 1), (True, 3)])
def test_a_time_has_its_place_among_equal_ones(behind_equal, expected):
    table = Scratch().table(ROW)
    table.append(rows([1.0, 2.5, 2.5, 3.0]).tobytes())
    assert table.place(2.0, 0.5, behind_equal=behind_equal) == expected


def work_that_fails(closed):
    with Scratch(lambda: Closing(closed)) as scratch:
        scratch.table(ROW)
        scratch.table(ROW)
        raise ZeroDivisionError


def test_all_files_are_closed_when_the_work_fails():
    closed = []
    with pytest.raises(ZeroDivisionError):
        work_that_fails(closed)
    assert len(closed) == 2


@pytest.mark.parametrize("count", [1, 2, 7, 1000, 1001])
def test_the_median_of_runs_is_that_of_all(count):
    values = np.random.default_rng(count).standard_cauchy(count).round(2)
    runs = np.array_split(values, 4)
    assert median(lambda: runs) == np.median(values)


def test_the_median_of_nothing_is_no_number():
    assert np.isnan(median(lambda: [np.empty(0)]))


def test_the_largest_of_late_decays_and_goes_on_over_runs():
    t_s = np.arange(4.0)
    held = HeldLargest(1.0)
    found = np.concatenate(
        [held.take(part, at) for part, at in ((np.array([0.0, 1.0]), t_s[:2]), (np.array([0.0, 0.9]), t_s[2:]))]
    )
    np.testing.assert_allclose(found, [0.0, 1.0, np.exp(-1.0), 0.9])

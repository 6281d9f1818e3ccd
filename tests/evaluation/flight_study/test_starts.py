from math import inf, nan

import numpy as np
import pytest

from attest_mav.evaluation.flight_study.flying import Errors
from attest_mav.evaluation.flight_study.starts import Start, start_of, summary


def errors_of(tilt):
    """Errors at 10 Hz, the first 1 s after the start, with a heading error of 3 degrees."""
    count = len(tilt)
    t_s = 1.0 + 0.1 * np.arange(count)
    ones = np.ones(count)
    return Errors(t_s, np.array(tilt, dtype=float), 3.0 * ones, ones, ones, ones > 0.0)


def test_a_good_first_output_is_the_attitude_found():
    assert start_of(7.0, errors_of([0.5] * 30)) == Start(7.0, 1.0, 3.0, 1.0, 0.5)


def test_it_is_found_when_the_error_has_fallen():
    start = start_of(0.0, errors_of([10.0] * 15 + [1.9] * 40))
    assert start.found_s == pytest.approx(2.5)
    assert start.first_tilt == 10.0


def test_a_relapse_within_two_seconds_counts_from_its_end():
    assert start_of(0.0, errors_of([1.0] * 10 + [2.1] + [1.0] * 40)).found_s == pytest.approx(2.1)


def test_a_relapse_later_is_none_of_the_start():
    assert start_of(0.0, errors_of([1.0] * 30 + [50.0] * 40)).found_s == pytest.approx(1.0)


@pytest.mark.parametrize("tilt", [[5.0] * 100, [1.0] * 15, [nan] * 100, []])
def test_what_is_never_good_for_two_seconds_is_never_found(tilt):
    assert start_of(0.0, errors_of(tilt)).found_s == inf


def test_samples_without_truth_decide_nothing():
    assert start_of(0.0, errors_of([nan] * 10 + [1.0] * 30)).found_s == pytest.approx(2.0)


def test_starts_that_never_end_count_as_the_cap():
    starts = [Start(0.0, 1.0, 2.0, 1.0, 0.5), Start(0.0, 3.0, -4.0, 1.0, 0.5), Start(0.0, inf, nan, nan, nan)]
    figures = summary("three", starts, {}).figures
    assert (figures["median s"], figures["max s"]) == (3.0, 60.0)
    assert figures["never %"] == pytest.approx(100.0 / 3.0)
    assert figures["heading max"] == 4.0

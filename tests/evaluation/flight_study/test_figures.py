from math import nan

import numpy as np
import pytest

from attest_mav.evaluation.flight_study.figures import Line, at_least, at_most, largest, p95, rms, share_within


def test_figures_of_errors_leave_out_what_is_no_number():
    errors = np.array([3.0, -4.0, nan, 0.0])
    assert rms(errors) == pytest.approx((25.0 / 3.0) ** 0.5)
    assert largest(errors) == 4.0
    assert p95(np.arange(101.0)) == 95.0
    assert share_within(errors, np.array([1.0, 1.0, 1.0, nan]), 3.0) == 50.0


def test_a_line_passes_when_every_limit_is_kept():
    figures = {"tilt": 0.1, "share": 99.5, "free": 1e9}
    assert Line("", figures, {"tilt": at_most(0.1), "share": at_least(99.0)}).passed
    assert not Line("", figures, {"tilt": at_most(0.09), "share": at_least(99.0)}).passed


def test_what_could_not_be_measured_keeps_no_limit():
    line = Line("no flight", {"tilt": nan}, {"tilt": at_most(1.0)})
    assert not line.passed
    assert line.as_json()["figures"] == {"tilt": None}
    assert line.as_json()["limits"] == {"tilt": [None, 1.0]}

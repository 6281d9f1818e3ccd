from math import hypot

import numpy as np
import pytest

from attest_mav.errors import UsageError
from attest_mav.evaluation.flight_study.edits import WHOLE
from attest_mav.evaluation.flight_study.figures import largest, p95, rms
from attest_mav.evaluation.flight_study.flights import evenly, flying_interval, rate_hz, turn_tilt_deg, turning_times
from attest_mav.evaluation.flight_study.flying import Chosen, Trial, flown, recorded
from attest_mav.filters.registry import default_filter
from attest_mav.logs.tlog.source import TlogSource
from attest_mav.mavlink.dialect import load_dialect
from attest_mav.replay.engine import replay
from attest_mav.replay.report import as_json
from attest_mav.replay.request import Outputs, Request, Window
from attest_mav.samples import VelocitySample


@pytest.mark.parametrize("name", ["gradient-descent", "velocity-aided"])
@pytest.mark.parametrize("cut", ["copter_square_laps", "plane_circles_gps"])
def test_an_unedited_flight_gives_the_figures_of_the_replay(data, cut, name):
    log = (data / f"{cut}.tlog").read_bytes()
    result = flown(Trial(log, Chosen(name), WHOLE, skip_s=5.0))
    request = Request((default_filter(name),), window=Window(skip_s=5.0))
    report = as_json(cut, replay(TlogSource(log, load_dialect()), request, Outputs()))
    sides = [(result.ours, report["filters"][0]), (result.autopilot, report["autopilot"])]
    for errors, expected in sides:
        if expected is None:
            assert not len(errors.tilt)
            continue
        counting = errors.that_count()
        for kind in ("tilt", "heading"):
            column = getattr(counting, kind)
            figures = {"rms": rms(column), "p95": p95(column), "max": largest(column)}
            reported = {name: expected[f"{kind}_deg"][name] for name in figures}
            assert figures == pytest.approx(reported, abs=2e-6)  # the report has six decimals


def test_the_flight_is_known_by_its_truth(plane):
    recording = recorded(plane)
    assert turn_tilt_deg(recording) == 20.0
    assert rate_hz(recording) == pytest.approx(50.0, abs=0.5)
    times = turning_times(recording, 20.0, 10.0)
    assert len(times) == pytest.approx(300, abs=3)  # it circles all the time, and has 10 attitudes a second
    assert flying_interval(recording)[1] > 39.0
    assert hypot(*next(s for s in recording.samples if isinstance(s, VelocitySample)).v_ned) > 15.0


def test_starts_are_spread_evenly():
    assert evenly(np.arange(100.0), 4) == [12.0, 37.0, 62.0, 87.0]
    assert evenly(np.arange(3.0), 4) == [0.0, 1.0, 2.0]


def test_parameters_that_are_none_are_refused():
    assert Chosen("velocity-aided", {"gyro_noise": 1e-3}).build().parameters.gyro_noise == 1e-3
    with pytest.raises(UsageError, match="gyro_nose"):
        Chosen("velocity-aided", {"gyro_nose": 1e-3}).build()
    with pytest.raises(UsageError, match="gradient-descent"):
        Chosen("gradient-descent", {"beta": 0.1}).build()

"""The leveling filter on recorded flights: in banked turns, and started in the middle of one."""

import csv
from io import StringIO

import pytest

from attest_mav.filters.gradient_descent.filter import GradientDescent
from attest_mav.filters.leveling.filter import Leveling
from attest_mav.logs.tlog.source import TlogSource
from attest_mav.replay.csv_table import CsvTable
from attest_mav.replay.engine import replay
from attest_mav.replay.report import as_json
from attest_mav.replay.request import Outputs, Request, Window
from attest_mav.replay.table_rows import TableRows


def tilt_rms(data, dialect, *filters, **window):
    """Tilt rms of each filter in degrees."""
    request = Request(filters, window=Window(**window))
    result = as_json("flight", replay(TlogSource(data, dialect), request, Outputs()))
    return [figures["tilt_deg"]["rms"] for figures in result["filters"]]


def tilt_errors(data, dialect, name):
    """(seconds since the first estimate, tilt error in degrees) of one filter."""
    rows = StringIO()
    request = Request((Leveling(),), window=Window(skip_s=0.0))
    replay(TlogSource(data, dialect), request, Outputs(observer=TableRows("flight", [CsvTable(rows)])))
    rows.seek(0)
    errors = [
        (float(r["t_s"]), float(r["tilt_error_deg"]))
        for r in csv.DictReader(rows)
        if r["filter"] == name and r["tilt_error_deg"]
    ]
    return [(t - errors[0][0], error) for t, error in errors]


def test_started_in_the_middle_of_a_turn_it_finds_the_level_within_a_second(cuts, dialect):
    errors = tilt_errors((cuts / "plane_circles_airspeed.tlog").read_bytes(), dialect, "leveling")
    assert errors[0][1] > 20.0
    assert max(error for t, error in errors if t > 1.0) < 4.0


def test_in_a_turn_it_errs_several_times_less_than_gradient_descent(cuts, dialect):
    data = (cuts / "plane_circles_airspeed.tlog").read_bytes()
    leaning, leveling = tilt_rms(data, dialect, GradientDescent(), Leveling(), skip_s=3.0)
    assert leveling < leaning / 4.0


@pytest.mark.parametrize(("name", "expected"), [("sitl/plane_circles.tlog", 1.9), ("sitl/copter_square.tlog", 0.8)])
def test_whole_flights_show_the_figures_of_the_documentation(data_folder, dialect, name, expected):
    path = data_folder / name
    if not path.is_file():
        pytest.skip(f"{path} is not there")
    (rms,) = tilt_rms(path.read_bytes(), dialect, Leveling())
    assert rms == pytest.approx(expected, abs=0.1)

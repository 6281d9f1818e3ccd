"""The flight filter on recorded flights: better than the autopilot's own attitude, and honest about itself."""

import csv
from io import StringIO

import numpy as np
import pytest

from attest_mav.filters.velocity_aided.filter import VelocityAided
from attest_mav.logs.tlog.source import TlogSource
from attest_mav.replay.csv_table import CsvTable
from attest_mav.replay.engine import replay
from attest_mav.replay.report import as_json
from attest_mav.replay.request import Outputs, Request, Window
from attest_mav.replay.table_rows import TableRows


def flown(data, dialect, **window):
    """The figures of the replay, and the rows of the filter's estimates as columns."""
    rows = StringIO()
    request = Request((VelocityAided(),), window=Window(**window))
    outputs = Outputs(observer=TableRows("flight", [CsvTable(rows)]))
    figures = as_json("flight", replay(TlogSource(data, dialect), request, outputs))
    rows.seek(0)
    table = [r for r in csv.DictReader(rows) if r["filter"] == "velocity-aided"]
    names = ("t_s", "tilt_error_deg", "heading_error_deg", "tilt_sigma_deg", "heading_sigma_deg")
    columns = np.array([[float(r[name] or "nan") for name in names] for r in table])
    return figures, columns


def whole(folder, dialect, name):
    path = folder / name
    if not path.is_file():
        pytest.skip(f"{path} is not there")
    return flown(path.read_bytes(), dialect)


def test_started_in_a_turn_it_is_right_to_a_degree_or_two(cuts, dialect):
    _, rows = flown((cuts / "plane_circles_turn.tlog").read_bytes(), dialect, skip_s=0.0)
    assert rows[0, 0] < 6.0
    assert np.nanmax(rows[:, 1]) < 2.0


def test_it_starts_on_the_ground_within_a_second(cuts, dialect):
    _, rows = flown((cuts / "copter_square_start.tlog").read_bytes(), dialect, skip_s=0.0)
    assert rows[0, 0] < 3.0  # the first seconds of the log have a magnetometer of zeros
    assert np.nanmax(rows[:, 1]) < 0.5


@pytest.mark.parametrize(
    ("name", "tilt", "heading"),
    [("sitl/copter_square.tlog", 0.10, 0.25), ("sitl/plane_circles.tlog", 0.16, 0.30)],
)
def test_at_50_hz_it_is_twice_as_good_as_the_autopilot(data_folder, dialect, name, tilt, heading):
    figures, rows = whole(data_folder, dialect, name)
    ours, theirs = figures["filters"][0], figures["autopilot"]
    assert ours["tilt_deg"]["rms"] < tilt
    assert ours["heading_deg"]["rms"] < heading
    assert ours["tilt_deg"]["rms"] < 0.5 * theirs["tilt_deg"]["rms"]
    assert ours["heading_deg"]["rms"] < theirs["heading_deg"]["rms"]
    counted = rows[rows[:, 0] > rows[0, 0] + 30.0]
    assert np.nanmean(counted[:, 1] < 3.0 * counted[:, 3]) > 0.99
    assert np.nanmean(np.abs(counted[:, 2]) < 3.0 * counted[:, 4]) > 0.99


def test_at_4_hz_its_sigma_says_what_to_believe(data_folder, dialect):
    figures, rows = whole(data_folder, dialect, "public/vtol_4hz.tlog")
    ours = figures["filters"][0]
    assert ours["tilt_deg"]["rms"] < 2.5
    assert ours["heading_deg"]["rms"] < 2.5
    counted = rows[(rows[:, 0] > rows[0, 0] + 30.0) & np.isfinite(rows[:, 1])]
    certain = counted[counted[:, 3] < 1.0]
    assert len(certain) > 0.4 * len(counted)
    assert np.sqrt(np.mean(certain[:, 1] ** 2)) < 0.7
    assert np.mean(counted[:, 1] < 3.0 * counted[:, 3]) > 0.99

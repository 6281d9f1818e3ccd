"""``attest-mav replay --report``: one page of one flight, and a sentence where there can be none."""

import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from attest_mav.cli.replay import command
from attest_mav.errors import UsageError

CUTS = Path(__file__).parent.parent / "data"
LAPS = CUTS / "copter_square_laps.tlog"
START = CUTS / "copter_square_start.tlog"


def replay(*arguments):
    return CliRunner().invoke(command, [str(one) for one in arguments])


def data_of(page):
    """The object that the page's script draws."""
    return json.loads(re.search(r'id="data">(.*?)</script>', page, re.DOTALL)[1])


def series_of(charts, title, label):
    chart = next(one for one in charts if one["title"].startswith(title))
    return next(one for one in chart["series"] if one["label"].startswith(label))


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """The figures and the page of one flight, with its table."""
    folder = tmp_path_factory.mktemp("written")
    done = replay(LAPS, "--skip", "2", "--json", "--report", folder / "p.html", "--csv", folder / "t.csv")
    assert done.exit_code == 0
    page = (folder / "p.html").read_text(encoding="utf-8")
    return json.loads(done.stdout), page, (folder / "t.csv").read_text(encoding="utf-8").splitlines()


def test_the_page_has_the_figures_of_the_report(written):
    report, page, _ = written
    tilt = report["filters"][0]["tilt_deg"]["rms"]
    assert f"<td>{tilt:.3g}</td>" in page
    assert len(data_of(page)["verdict"]) == len(report["verdict"]["intervals"])
    assert str(LAPS) in page


def test_the_page_draws_the_attitudes_of_the_table(written):
    _, page, rows = written
    columns = rows[0].split(",")
    mine = [dict(zip(columns, row.split(","), strict=True)) for row in rows[1:]]
    mine = [row for row in mine if row["filter"] == "velocity-aided"]
    drawn = series_of(data_of(page)["charts"], "Roll", "velocity-aided")
    assert len(drawn["v"]) == len(mine)
    assert drawn["v"] == pytest.approx([float(row["roll_deg"]) for row in mine], abs=0.001)
    assert sum(drawn["t"]) == pytest.approx(1e3 * float(mine[-1]["t_s"]), abs=1.0)


def test_every_subject_of_the_page_is_there(written):
    _, page, _ = written
    charts = data_of(page)["charts"]
    titles = [one["title"] for one in charts]
    for title in ("Roll", "Yaw", "Tilt", "Heading", "Normalised", "Innovation", "Estimated", "Interval", "Vibration"):
        assert any(one.startswith(title) for one in titles), title
    assert series_of(charts, "Yaw", "reference (SIM_STATE)")["v"]
    assert series_of(charts, "Tilt", "autopilot against velocity-aided")["v"]
    assert series_of(charts, "Tilt", "autopilot against reference")["v"]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ((LAPS, START, "--report", "p.html"), "--report takes one LOG: a page shows one flight"),
        ((LAPS, "--report", "p.html", "--results", "r.json"), "--report and --results: a result that is kept has no"),
        ((LAPS, "--report", LAPS), "would replace the log it is made from"),
        ((LAPS, "--report", "p.html", "--csv", "p.html"), "--csv and --report are both p.html: expected two files"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path, monkeypatch, arguments, sentence):
    monkeypatch.chdir(tmp_path)
    done = replay(*arguments)
    assert isinstance(done.exception, UsageError)
    assert sentence in str(done.exception)
    assert list(tmp_path.iterdir()) == []


def test_a_log_that_cannot_be_read_leaves_no_page(tmp_path):
    empty = tmp_path / "empty.tlog"
    empty.touch()
    done = replay(empty, "--report", tmp_path / "p.html")
    assert done.exit_code == 65
    assert list(tmp_path.iterdir()) == [empty]

"""tools/soak and tools/soak_live in their short forms: the table, the picture, and the bounds that can be missed."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

TOOLS = Path(__file__).parents[2] / "tools"


def soaked(tmp_path, tool, *options):
    """The cells of the last row, and the picture, of a flight that holds its bounds."""
    pytest.importorskip("matplotlib")
    picture = tmp_path / "soak.svg"
    command = [sys.executable, str(TOOLS / tool), *options, "--plot", str(picture)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    *_, row, conclusion = done.stdout.splitlines()
    assert conclusion == "all bounds hold"
    return row.split(), picture.read_text(encoding="utf-8")


def test_a_short_soak_holds_its_bounds_and_draws_its_curves(tmp_path):
    cells, drawn = soaked(tmp_path, "soak", "--hours", "0.003", "--rows", "2")
    hours, _, memory_mb, descriptors, cost_percent, *_, verdict = cells
    assert float(hours) == 0.0
    assert 10.0 < float(memory_mb) < 200.0
    assert int(descriptors) > 2
    assert 0.0 < float(cost_percent) < 100.0
    assert verdict == "AGREE"
    for title in ("resident memory", "open descriptors", "processor time", "time for one message"):
        assert title in drawn


def test_the_daemon_answers_in_real_time_with_its_page_open(tmp_path):
    cells, drawn = soaked(tmp_path, "soak_live", "--minutes", "0.03", "--rows", "1")
    _, attitudes_hz, memory_mb, descriptors, _, median_ms, _, largest_ms, *_, lost, verdict = cells
    assert 10.0 < float(attitudes_hz) < 25.0
    assert 10.0 < float(memory_mb) < 200.0
    assert int(descriptors) > 2
    assert 0.0 < float(median_ms) <= float(largest_ms)
    assert (lost, verdict) == ("0", "AGREE")
    assert "time from an inertial message to its attitude" in drawn


@pytest.fixture
def table():
    spec = importlib.util.spec_from_file_location("soak_table", TOOLS / "soak_table.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_each_bound_that_a_row_misses_is_named(table):
    def row(memory_mb, descriptors, lost, missed=()):
        return table.Row(1.0, 1.0, memory_mb, descriptors, 1.0, (1.0, 1.0, 1.0), 1.0, lost, "AGREE", missed)

    good = row(50.0, 9, 0)
    assert table.failures_of([good, row(55.0, 9, 0)]) == []
    assert table.failures_of([good, row(55.1, 9, 0), good]) == ["memory grew"]
    assert table.failures_of([good, row(50.0, 10, 0)]) == ["descriptors stayed open"]
    assert table.failures_of([good, row(50.0, 9, 1)]) == ["frames were lost"]
    assert table.failures_of([good, row(50.0, 9, 0, ("attitudes stopped",)), good]) == ["attitudes stopped"]

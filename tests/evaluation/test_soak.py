"""tools/soak in its short form: the table, the picture, and the bounds that can be missed."""

import subprocess
import sys
from pathlib import Path

import pytest

SOAK = Path(__file__).parents[2] / "tools" / "soak"


def test_a_short_soak_holds_its_bounds_and_draws_its_curves(tmp_path):
    pytest.importorskip("matplotlib")
    picture = tmp_path / "soak.svg"
    command = [sys.executable, "-P", str(SOAK), "--hours", "0.003", "--rows", "2", "--plot", str(picture)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) == 4
    hours, _, memory_mb, descriptors, cost_percent, *_, verdict = lines[2].split()
    assert float(hours) == 0.0
    assert 10.0 < float(memory_mb) < 200.0
    assert int(descriptors) > 2
    assert 0.0 < float(cost_percent) < 100.0
    assert verdict == "AGREE"
    drawn = picture.read_text(encoding="utf-8")
    for title in ("resident memory", "open descriptors", "processor time", "time for one message"):
        assert title in drawn

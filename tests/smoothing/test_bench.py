"""tools/bench_smoother in its short form: a row for a log of half a minute, and its bounds."""

import subprocess
import sys
from pathlib import Path

TOOL = Path(__file__).parents[2] / "tools" / "bench_smoother"
LAPS = Path(__file__).parents[1] / "data" / "copter_square_laps.tlog"


def test_a_short_log_keeps_the_bounds():
    command = [sys.executable, "-P", str(TOOL), str(LAPS), "--minutes", "0.3"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    minutes, read_s, smooth_s, peak_mb = map(float, done.stdout.splitlines()[1].split())
    assert 0.2 < minutes < 0.5
    assert read_s > 0.0
    assert smooth_s > 0.0
    assert 20.0 < peak_mb < 200.0

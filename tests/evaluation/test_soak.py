"""The command of hours of flight, for seconds of one."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent.parent


def test_it_prints_a_row_for_each_part_and_draws_a_picture(tmp_path):
    picture = tmp_path / "soak.svg"
    command = [sys.executable, "-P", str(ROOT / "tools" / "soak"), "--hours", "0.002", "--rows", "2"]
    done = subprocess.run([*command, "--plot", str(picture)], capture_output=True, text=True, timeout=120, check=True)
    head, first, second, end = done.stdout.splitlines()
    assert head.split()[:3] == ["hours", "speed", "MB"]
    for line in (first, second):
        _, _, memory, descriptors, median, p99, largest, _, lost, verdict = line.split()
        assert 20 < float(memory) < 200
        assert int(descriptors) < 20
        assert float(median) <= float(p99) <= float(largest)
        assert lost == "0"
        assert verdict == "AGREE"
    assert end == "memory, descriptors and recording hold"
    assert picture.read_text(encoding="utf-8").startswith("<?xml")

"""The benchmark command runs; what it measures is not tested here."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent.parent


def test_it_prints_times_recovery_and_memory():
    log = ROOT / "tests" / "data" / "copter_square_start.tlog"
    command = [sys.executable, "-P", str(ROOT / "tools" / "bench_logs"), str(log)]
    done = subprocess.run(
        [*command, "--rounds", "1", "--times", "3", "--seeds", "1"],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    for line in ("attest-mav, walk and check", "pymavlink mavlogfile", "intact frames recovered", "peak MB"):
        assert line in done.stdout
    (recovered,) = [line for line in done.stdout.splitlines() if line.startswith("attest-mav  ")]
    assert recovered.split() == ["attest-mav", "100.000%"]

"""The benchmark command runs; what it measures is not tested here."""

import subprocess
import sys
from pathlib import Path

TOOL = Path(__file__).parents[3] / "tools" / "bench_dataflash"


def test_it_prints_times_recovery_and_memory(writer, tmp_path):
    writer.still_flight(20.0)
    log = tmp_path / "flight.bin"
    log.write_bytes(writer.data)
    command = [sys.executable, "-P", str(TOOL), str(log), "--rounds", "1", "--times", "3", "--seeds", "1"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    for line in ("attest-mav, both passes", "DFReader, all", "intact records recovered", "peak MB"):
        assert line in done.stdout
    (recovered,) = [line for line in done.stdout.splitlines() if line.startswith("seed 0")]
    assert float(recovered.split()[2].rstrip("%")) >= 100.0

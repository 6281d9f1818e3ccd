"""The short form of tools/many_logs: a folder with broken logs, here and on a Dask cluster that loses a worker."""

import shutil
import subprocess
import sys
from pathlib import Path

REPOSITORY = Path(__file__).parents[2]


def test_a_folder_gives_one_summary_here_and_on_a_cluster_that_loses_a_worker(tmp_path):
    shutil.copy(REPOSITORY / "tests" / "data" / "copter_square_start.tlog", tmp_path)
    command = [sys.executable, "tools/many_logs", str(tmp_path), "--logs", "9", "--filter", "gradient-descent"]
    done = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, check=False, timeout=120)
    assert done.stderr == ""
    assert done.stdout.count("6 logs and 3 errors") == 2
    assert [line for line in done.stdout.splitlines() if line.endswith(": equal")] == [
        "results: equal",
        "errors: equal",
        "summaries: equal",
    ]
    assert done.returncode == 0

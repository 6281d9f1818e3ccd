"""A replay loads what it needs, and searches seldom for cycles of garbage."""

import gc
import subprocess
import sys
from pathlib import Path

from attest_mav.cli.collector import SELDOM, seldom_collected

LAPS = Path(__file__).parent.parent / "data" / "copter_square_laps.tlog"
HEAVY = (
    "rich",
    "tempfile",
    "zipfile",
    "xml.etree.ElementTree",
    "numpy",
    "pyarrow",
    "msgspec",
    "matplotlib",
    "multiprocessing",
    "attest_mav.smoothing",
    "attest_mav.service",
)
RUN = f"""
import sys
from attest_mav.cli.main import run

assert run(["replay", {str(LAPS)!r}, *sys.argv[1:]]) == 0
print(*[name for name in {HEAVY} if name in sys.modules], file=sys.stderr)
"""


def loaded(*options):
    command = [sys.executable, "-P", "-c", RUN, *options]
    return subprocess.run(command, capture_output=True, text=True, check=True).stderr.split()


def test_a_replay_loads_no_library_that_it_does_not_use():
    assert loaded() == []
    assert loaded("--json") == []


def test_the_collector_goes_on_as_before():
    before = gc.get_threshold()
    with seldom_collected():
        assert gc.get_threshold() == (SELDOM, *before[1:])
        assert gc.get_freeze_count() > 0
    assert gc.get_threshold() == before
    assert gc.get_freeze_count() == 0

"""The unit file, by systemd's own tools."""

import configparser
import re
import shutil
import subprocess
from pathlib import Path

import pytest

FOLDER = Path(__file__).parent.parent / "systemd"
UNIT = FOLDER / "attest-mav.service"

ANALYZE = shutil.which("systemd-analyze")
SYSUSERS = shutil.which("systemd-sysusers")

needs_systemd = pytest.mark.skipif(ANALYZE is None, reason="systemd-analyze is not installed")


def analyze(*arguments):
    return subprocess.run([ANALYZE, *arguments], capture_output=True, text=True, check=False)


@pytest.fixture
def service():
    unit = configparser.ConfigParser(strict=False, interpolation=None)
    unit.optionxform = str
    unit.read(UNIT)
    return unit["Service"]


@needs_systemd
def test_verify_finds_nothing():
    done = analyze("verify", str(UNIT))
    assert done.stderr == ""
    assert done.returncode == 0


@needs_systemd
def test_the_exposure_is_at_most_2():
    done = analyze("security", "--offline=true", str(UNIT))
    assert done.returncode == 0, done.stderr
    exposure = re.search(r"Overall exposure level for attest-mav.service: ([0-9.]+)", done.stdout)
    assert float(exposure[1]) <= 2.0


@pytest.mark.skipif(SYSUSERS is None, reason="systemd-sysusers is not installed")
def test_the_user_of_the_service_can_be_made(tmp_path, service):
    (tmp_path / "etc").mkdir()
    arguments = [SYSUSERS, f"--root={tmp_path}", str(FOLDER / "attest-mav.conf")]
    done = subprocess.run(arguments, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    users = (tmp_path / "etc" / "passwd").read_text()
    assert f"{service['User']}:x:" in users


def test_the_manners_of_the_service(service):
    assert service["Type"] == "notify"
    assert service["NotifyAccess"] == "main"
    assert int(service["WatchdogSec"]) > 0
    assert service["Restart"] == "always"
    assert service["MemoryDenyWriteExecute"] == "yes"
    assert "dialout" in service["SupplementaryGroups"]
    assert "attest-mav run --config" in service["ExecStart"]

"""The unit files as they are installed, by systemd's own tools."""

import configparser
import re
import shutil
import subprocess

import pytest

from attest_mav.installation.plan import planned_files

ANALYZE = shutil.which("systemd-analyze")
SYSUSERS = shutil.which("systemd-sysusers")
UNITS = ("attest-mav.service", "attest-mav@.service")

needs_systemd = pytest.mark.skipif(ANALYZE is None, reason="systemd-analyze is not installed")


def analyze(*arguments):
    return subprocess.run([ANALYZE, *arguments], capture_output=True, text=True, check=False)


@pytest.fixture
def folder(tmp_path):
    """All files as an old systemd gets them, in one folder; the program is one that every machine has."""
    for file in planned_files("/bin/true", 252, "ardupilot-serial"):
        (tmp_path / file.path.rpartition("/")[2]).write_text(file.text)
    return tmp_path


@pytest.fixture(params=UNITS)
def unit(request, folder):
    return folder / request.param


def section(path):
    unit = configparser.ConfigParser(strict=False, interpolation=None)
    unit.optionxform = str
    unit.read(path)
    return unit["Service"]


@needs_systemd
def test_verify_finds_nothing(unit):
    done = analyze("verify", str(unit))
    assert done.stderr == ""
    assert done.returncode == 0


@needs_systemd
def test_the_exposure_is_at_most_2(unit):
    done = analyze("security", "--offline=true", str(unit))
    assert done.returncode == 0, done.stderr
    exposure = re.search(r"Overall exposure level for attest-mav@?.*\.service: ([0-9.]+)", done.stdout)
    assert float(exposure[1]) <= 2.0


@pytest.mark.skipif(SYSUSERS is None, reason="systemd-sysusers is not installed")
def test_the_user_of_the_service_can_be_made(tmp_path, folder):
    (tmp_path / "etc").mkdir()
    arguments = [SYSUSERS, f"--root={tmp_path}", str(folder / "attest-mav.conf")]
    done = subprocess.run(arguments, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    users = (tmp_path / "etc" / "passwd").read_text()
    assert f"{section(folder / UNITS[0])['User']}:x:" in users


def test_the_manners_of_the_service(unit):
    service = section(unit)
    assert service["Type"] == "notify"
    assert service["NotifyAccess"] == "main"
    assert int(service["WatchdogSec"]) > 0
    assert service["Restart"] == "always"
    assert service["RestartPreventExitStatus"] == "2 78"
    assert service["MemoryDenyWriteExecute"] == "yes"
    assert "dialout" in service["SupplementaryGroups"]
    assert service["ExecStart"].startswith("/bin/true run --config /etc/attest-mav/")
    assert "HUP" in service["ExecReload"]


def test_each_vehicle_has_a_configuration_a_state_and_a_name_in_the_log_of_its_own(folder):
    one, several = (section(folder / name) for name in UNITS)
    keys = ("ExecStart", "StateDirectory", "SyslogIdentifier", "EnvironmentFile")
    assert [one[key].rpartition("/")[2] for key in keys] == ["attest-mav.toml", *["attest-mav"] * 3]
    assert [several[key] for key in keys] == [
        "/bin/true run --config /etc/attest-mav/%i.toml",
        "attest-mav/%i",
        "attest-mav@%i",
        "-/etc/default/%i",
    ]
    assert {key for key in one if one[key] != several[key]} == set(keys)


def test_a_newer_systemd_waits_for_reloads_and_backs_off():
    old, new = (
        {file.path: file.text for file in planned_files("/bin/true", version, "sitl")} for version in (253, 254)
    )
    added = sorted(set(new) - set(old))
    assert [path.rpartition("/")[0] for path in added] == [f"/etc/systemd/system/{name}.d" for name in sorted(UNITS)]
    assert all("Type=notify-reload" in new[path] and "RestartSteps=" in new[path] for path in added)
    assert {path: new[path] for path in old} == old

import tomllib
from pathlib import Path

import pytest
from click.testing import CliRunner

from attest_mav.cli.config import command
from attest_mav.errors import ConfigError

CONFIGS = Path(__file__).parents[2] / "configs"


def run(*arguments):
    return CliRunner().invoke(command, arguments, catch_exceptions=False)


def test_check_says_that_a_file_is_valid_and_what_it_makes():
    path = str(CONFIGS / "attest-mav.toml")
    done = run("check", path)
    assert done.exit_code == 0
    assert done.output == f"{path}: valid; links: udpin:127.0.0.1:14550; filter: velocity-aided\n"


@pytest.mark.parametrize("name", ["check", "show"])
def test_a_simulation_that_does_not_exist_is_a_configuration_error(tmp_path, name):
    path = tmp_path / "sim.toml"
    path.write_text("[[link]]\nurl = 'sim:still'\n[[link]]\nurl = 'sim:nonsense'\n")
    with pytest.raises(ConfigError, match=r"sim\.toml: link\[1\]\.url: unknown scenario 'nonsense': expected one of"):
        run(name, str(path))


def test_a_fault_that_does_not_exist_is_a_configuration_error(tmp_path):
    path = tmp_path / "sim.toml"
    path.write_text("[[link]]\nurl = 'sim:?receiver-off@3,gyro-bais=5@20'\n")
    with pytest.raises(ConfigError, match=r"link\[0\]\.url: fault 'gyro-bais=5@20': .*did you mean gyro-bias\?"):
        run("check", str(path))


@pytest.mark.parametrize("name", ["check", "show"])
def test_a_wrong_file_is_a_configuration_error(tmp_path, name):
    path = tmp_path / "wrong.toml"
    path.write_text("[outptu]\n")
    with pytest.raises(ConfigError, match=r"wrong\.toml: unknown key outptu; did you mean output\?"):
        run(name, str(path))


@pytest.mark.parametrize("source", [None, *sorted(CONFIGS.glob("*.toml"))], ids=str)
def test_what_show_prints_passes_check_and_shows_the_same(tmp_path, source):
    shown = run("show", *([] if source is None else [str(source)]))
    assert shown.exit_code == 0
    path = tmp_path / "shown.toml"
    path.write_text(shown.output)
    if source is not None:
        assert run("check", str(path)).exit_code == 0
    again = run("show", str(path)).output
    assert tomllib.loads(again) == tomllib.loads(shown.output)
    assert "# default" not in again, "every value stands in the file"
    assert again.count(f"  # {path}\n") == shown.output.count("  # ")


def test_the_origin_of_each_value_is_shown(tmp_path, monkeypatch):
    path = tmp_path / "a.toml"
    path.write_text("[output]\nrate_hz = 5\n[log]\nstatus_s = 2\n")
    (tmp_path / "a.conf.d").mkdir()
    for number in (2, 1):
        (tmp_path / "a.conf.d" / f"{number}.toml").write_text(f"[log]\nstatus_s = {number}\n")
    (tmp_path / "a.conf.d" / "README").write_text("no TOML")
    monkeypatch.setenv("ATTEST_MAV__VERDICT__HOLD_S", "2")
    lines = run("show", str(path), "--set", "output.rate_hz=6").output.split("\n")
    assert "rate_hz = 6.0  # --set" in lines
    assert f"status_s = 2.0  # {tmp_path}/a.conf.d/2.toml" in lines
    assert "hold_s = 2.0  # ATTEST_MAV__VERDICT__HOLD_S" in lines
    assert "component_id = 193  # default" in lines


def test_check_warns_and_says_what_run_would_meet(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text("[[link]]\nurl = 'serial:/dev/ttyS0:912600'\n")
    done = run("check", str(path))
    assert done.exit_code == 0
    assert f"{path}: warning: link[0].url: baud rate 912600 is unusual; is 921600 meant?\n" in done.stderr
    path.write_text("[output]\nrate_hz = 5\n")
    with pytest.raises(ConfigError, match=r"a\.toml: no link: write a \[\[link\]\]"):
        run("check", str(path))


@pytest.mark.parametrize(
    ("message", "hint"), [("RADIO_STATU", "did you mean RADIO_STATUS?"), ("?", "expected a name such as RADIO_STATUS")]
)
def test_a_message_that_does_not_exist_cannot_be_taken_unsigned(tmp_path, message, hint):
    path = tmp_path / "signed.toml"
    path.write_text(f"[[link]]\nurl = 'sim:'\naccept_unsigned = ['HEARTBEAT', '{message}']\n")
    with pytest.raises(ConfigError) as caught:
        run("check", str(path))
    assert f"link[0].accept_unsigned: no message {message}; {hint}" in str(caught.value)

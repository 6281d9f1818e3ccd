"""``attest-mav service``: files below a prefix, put in place and taken away."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from attest_mav.cli.service import command
from attest_mav.config.parsing import parse_config
from attest_mav.errors import UnwritableError, UsageError
from attest_mav.installation import machine, plan
from attest_mav.installation.unit_folders import unit_remarks

UNIT = "etc/systemd/system/attest-mav.service"
CONFIGURATION = "etc/attest-mav/attest-mav.toml"


@pytest.fixture(autouse=True)
def program(monkeypatch):
    monkeypatch.setattr("attest_mav.cli.service.program_path", lambda: "/opt/attest-mav/bin/attest-mav")
    monkeypatch.setattr("attest_mav.cli.service.systemd_version", lambda: 255)


def run(*arguments):
    done = CliRunner().invoke(command, arguments, catch_exceptions=False)
    assert done.exit_code == 0
    return done.output


def files(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def test_installing_writes_what_uninstalling_takes_away(tmp_path):
    said = run("install", "--prefix", str(tmp_path))
    assert "  sudo systemctl enable --now attest-mav\n" in said
    assert files(tmp_path) == [
        CONFIGURATION,
        "etc/systemd/system/attest-mav.service",
        "etc/systemd/system/attest-mav.service.d/systemd-254.conf",
        "etc/systemd/system/attest-mav@.service",
        "etc/systemd/system/attest-mav@.service.d/systemd-254.conf",
        "etc/sysusers.d/attest-mav.conf",
        "etc/udev/rules.d/65-attest-mav.rules",
    ]
    assert "ExecStart=/opt/attest-mav/bin/attest-mav run" in (tmp_path / UNIT).read_text()
    assert "unchanged" in run("install", "--prefix", str(tmp_path))
    assert "userdel" in run("uninstall", "--prefix", str(tmp_path))
    assert files(tmp_path) == []
    assert not (tmp_path / "etc/attest-mav").exists()
    assert not (tmp_path / "etc/systemd/system/attest-mav.service.d").exists()


def test_a_configuration_that_was_changed_is_never_overwritten_and_goes_only_with_purge(tmp_path):
    run("install", "--prefix", str(tmp_path))
    (tmp_path / CONFIGURATION).write_text("# mine\n")
    (tmp_path / UNIT).write_text(plan.MADE_BY_US + ", by an older version\n")
    said = run("install", "--prefix", str(tmp_path), "--example", "sitl")
    assert f"kept        {tmp_path / CONFIGURATION}" in said
    assert f"overwritten {tmp_path / UNIT}" in said
    run("uninstall", "--prefix", str(tmp_path))
    assert files(tmp_path) == [CONFIGURATION]
    assert (tmp_path / CONFIGURATION).read_text() == "# mine\n"
    run("uninstall", "--prefix", str(tmp_path), "--purge")
    assert files(tmp_path) == []


def test_a_dry_run_says_the_same_and_does_nothing(tmp_path):
    said = run("install", "--prefix", str(tmp_path), "--dry-run")
    assert files(tmp_path) == []
    assert said == run("install", "--prefix", str(tmp_path))
    before = files(tmp_path)
    foreseen = run("uninstall", "--prefix", str(tmp_path), "--dry-run")
    assert f"removed     {tmp_path / UNIT}" in foreseen
    assert "kept" not in foreseen
    assert files(tmp_path) == before


def test_a_unit_of_somebody_else_is_left_alone(tmp_path):
    (tmp_path / UNIT).parent.mkdir(parents=True)
    (tmp_path / UNIT).write_text("[Service]\n")
    with pytest.raises(UnwritableError, match="not made by attest-mav"):
        run("install", "--prefix", str(tmp_path))
    assert f"kept        {tmp_path / UNIT}" in run("uninstall", "--prefix", str(tmp_path))
    assert (tmp_path / UNIT).read_text() == "[Service]\n"


def warnings(prefix):
    return CliRunner().invoke(command, ["install", "--prefix", str(prefix)], catch_exceptions=False).stderr


@pytest.mark.parametrize(
    ("name", "folder", "said"),
    [
        ("attest-mav", "/var/lib/attest-mav/flights", ""),
        ("attest-mav", "/srv/flights", "record.folder: the service attest-mav may not write into /srv/flights; name a"),
        ("attest-mav", "flights", "record.folder: the service attest-mav may not write into flights"),
        ("attest-mav", "/var/lib/attest-mav/../x", "may not write into /var/lib/attest-mav/../x"),
        ("two", "/var/lib/attest-mav/two/flights", ""),
        ("two", "/var/lib/attest-mav/flights", "systemctl edit attest-mav@two, [Service], ReadWritePaths=/var/lib/"),
    ],
)
def test_a_folder_that_the_unit_cannot_write_into_is_said(tmp_path, name, folder, said):
    path = (tmp_path / CONFIGURATION).with_name(f"{name}.toml")
    path.parent.mkdir(parents=True)
    path.write_text(f"[[link]]\nurl = 'sim:'\n[record]\nfolder = '{folder}'\n")
    assert said in warnings(tmp_path)
    assert bool(said) == ("warning" in warnings(tmp_path))
    config = parse_config(path.read_text(), "x")
    assert list(unit_remarks(config, path, tmp_path)) == [], "a file that no unit reads"
    drop_in = tmp_path / "etc/systemd/system/attest-mav@.service.d/mine.conf"
    drop_in.write_text("[Service]\nReadWritePaths=-/mnt /var/lib/attest-mav/flights\n")
    (tmp_path / (UNIT + ".d/mine.conf")).write_text("[Service]\nReadWritePaths=/srv\n")
    assert ("warning" in warnings(tmp_path)) == (folder in {"flights", "/var/lib/attest-mav/../x"})


def test_a_configuration_that_is_wrong_stops_no_installation(tmp_path):
    path = tmp_path / CONFIGURATION
    path.parent.mkdir(parents=True)
    path.write_text("[oops]\n")
    assert "warning: " in warnings(tmp_path)
    assert "unknown key oops" in warnings(tmp_path)
    assert (tmp_path / UNIT).exists()


def test_what_the_user_has_added_survives_is_named_and_goes_with_purge(tmp_path):
    run("install", "--prefix", str(tmp_path))
    mine = [UNIT + ".d/override.conf", "etc/default/attest-mav", "var/lib/attest-mav/state.json"]
    for name in mine:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("mine\n")
    foreseen = run("uninstall", "--prefix", str(tmp_path), "--dry-run")
    said = run("uninstall", "--prefix", str(tmp_path))
    assert files(tmp_path) == sorted(mine)
    for kept in ("etc/systemd/system/attest-mav.service.d", "etc/default/attest-mav", "var/lib/attest-mav"):
        assert f"kept        {tmp_path / kept}\n" in said
        assert f"kept        {tmp_path / kept}\n" in foreseen
    run("uninstall", "--prefix", str(tmp_path), "--purge", "--dry-run")
    assert files(tmp_path) == sorted(mine)
    assert f"removed     {tmp_path / 'var/lib/attest-mav'}\n" in run("uninstall", "--prefix", str(tmp_path), "--purge")
    assert files(tmp_path) == []


def test_a_service_that_is_enabled_is_not_torn_out(tmp_path):
    run("install", "--prefix", str(tmp_path))
    wants = tmp_path / "etc/systemd/system/multi-user.target.wants"
    wants.mkdir()
    (wants / "attest-mav@two.service").symlink_to("/etc/systemd/system/attest-mav@.service")
    with pytest.raises(UsageError, match=r"systemctl disable --now attest-mav@two\.service"):
        run("uninstall", "--prefix", str(tmp_path))


def test_without_root_the_command_to_give_is_said(monkeypatch):
    monkeypatch.setattr("os.geteuid", lambda: 1000)
    for name in ("install", "uninstall"):
        with pytest.raises(UsageError, match=f"sudo /opt/attest-mav/bin/attest-mav service {name}; --dry-run"):
            run(name)


def test_a_machine_without_systemd_is_said(monkeypatch):
    monkeypatch.setattr("attest_mav.cli.service.systemd_version", lambda: None)
    with pytest.raises(UsageError, match="not run by systemd"):
        run("install", "--dry-run")


@pytest.mark.parametrize(
    ("program", "said"),
    [
        ("/home/pi/.local/bin/attest-mav", "cannot start a program below /home/"),
        ("/root/venv/bin/attest-mav", "pipx install --global"),
        ("/opt/my tools/attest-mav", "cannot name this path"),
    ],
)
def test_a_program_that_the_unit_could_not_start_is_refused(program, said):
    with pytest.raises(UsageError, match=said):
        list(plan.planned_files(program, 252, "sitl"))


def test_an_example_that_does_not_exist_is_named_with_the_others(tmp_path):
    with pytest.raises(UsageError, match="no example 'stil'; expected one of ardupilot-serial, attest-mav"):
        run("install", "--prefix", str(tmp_path), "--example", "stil")


def test_the_program_is_the_one_of_this_python(monkeypatch, tmp_path):
    monkeypatch.setattr("sysconfig.get_path", lambda _name: str(tmp_path))
    with pytest.raises(UsageError, match="no such program"):
        machine.program_path()
    Path(tmp_path / "attest-mav").touch()
    assert machine.program_path() == f"{tmp_path}/attest-mav"


def test_the_template_differs_from_the_unit_only_in_its_instance():
    unit, template = plan.unit_text("/opt/a/attest-mav", "attest-mav"), plan.unit_text("/opt/a/attest-mav", "%i")
    changed = [line for line in template.splitlines() if line not in unit.splitlines()]
    assert len(changed) == 6
    assert all("%i" in line or "@NAME" in line for line in changed)
    assert "/usr/bin/env" not in unit
    assert "ExecStart=/opt/a/attest-mav run --config /etc/attest-mav/attest-mav.toml" in unit

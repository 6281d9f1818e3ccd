"""The files of the service on a machine: where each belongs, and its text for the program that is installed here."""

from collections.abc import Iterator
from enum import Enum
from importlib import resources
from typing import Final, NamedTuple

from attest_mav.errors import UsageError

MADE_BY_US: Final = "# Made by `attest-mav service install`"
"""The beginning of every file that may be overwritten and removed again."""
UNIT: Final = "attest-mav"
CONFIGURATION: Final = "/etc/attest-mav/attest-mav.toml"
STATE: Final = "/var/lib/attest-mav"
FIRST_NOTIFY_RELOAD: Final = 254
"""The systemd that knows Type=notify-reload (253) and RestartSteps (254)."""
HIDDEN: Final = ("/home/", "/root/", "/run/user/", "/tmp/", "/var/tmp/")  # noqa: S108  (nothing is written there)
"""Folders that the unit hides from the daemon, so that a program in them cannot be started."""


BY_HAND: Final = """\
# An installation by hand: found in a virtual environment under /opt/attest-mav, or wherever else it is for all users.
Environment=PATH=/opt/attest-mav/bin:/usr/local/bin:/usr/bin:/bin
ExecStart=/usr/bin/env attest-mav run"""
"""The lines of the unit as it is shipped that find the program; an installation knows where it is."""
TEMPLATE: Final = {
    "`systemctl edit attest-mav`": "`systemctl edit attest-mav@NAME`",
    "a MAVLink vehicle": "a MAVLink vehicle (%i)",
    "/etc/attest-mav/attest-mav.toml": "/etc/attest-mav/%i.toml",
    "/etc/default/attest-mav": "/etc/default/%i",
    "SyslogIdentifier=attest-mav": "SyslogIdentifier=attest-mav@%i",
    "StateDirectory=attest-mav": "StateDirectory=attest-mav/%i",
}
"""The lines of the unit that differ in the template for several vehicles."""


class Owner(Enum):
    """Whose a file is once it is there."""

    OURS = "ours"
    """Overwritten by the next installation, removed with the service."""
    USERS = "the user's"
    """Never overwritten; removed only where it is as it came."""


class PlannedFile(NamedTuple):
    """One file of the service."""

    path: str
    """Absolute, on the machine where the service runs."""
    text: str
    """Its content."""
    owner: Owner
    """Whose it is."""


def planned_files(program: str, systemd_version: int, example: str) -> Iterator[PlannedFile]:
    """All files. program: absolute path of ``attest-mav``. example: name of the configuration to begin with."""
    if program.startswith(HIDDEN):
        raise UsageError(
            f"{program}: the service cannot start a program below {', '.join(HIDDEN)}; install it for all users, "
            "for example: python3 -m venv /opt/attest-mav, or pipx install --global"
        )
    if any(letter.isspace() or letter in "%$\"'\\;" for letter in program):
        raise UsageError(f"{program!r}: a unit cannot name this path; install into one without blanks and quotes")
    for name, instance in ((UNIT, UNIT), (f"{UNIT}@", "%i")):
        folder = f"/etc/systemd/system/{name}.service"
        yield PlannedFile(folder, unit_text(program, instance), Owner.OURS)
        if systemd_version >= FIRST_NOTIFY_RELOAD:
            yield PlannedFile(f"{folder}.d/systemd-254.conf", _shipped("systemd/systemd-254.conf"), Owner.OURS)
    yield PlannedFile(f"/etc/sysusers.d/{UNIT}.conf", _shipped("systemd/sysusers.conf"), Owner.OURS)
    yield PlannedFile(f"/etc/udev/rules.d/65-{UNIT}.rules", _shipped("systemd/udev.rules"), Owner.OURS)
    yield PlannedFile(CONFIGURATION, example_text(example), Owner.USERS)


def unit_text(program: str, instance: str) -> str:
    """The unit of one vehicle, or with the instance ``%i`` the template for several."""
    text = _shipped("systemd/attest-mav.service")
    changes = {BY_HAND: f"ExecStart={program} run"}
    if instance != UNIT:
        changes |= TEMPLATE
    for shipped, own in changes.items():
        if shipped not in text:
            raise ValueError(f"the unit that is shipped has no {shipped!r}")
        text = text.replace(shipped, own)
    return text


def example_names() -> list[str]:
    """The configurations that are shipped, by the names of their files without ``.toml``."""
    folder = resources.files(__package__) / "configs"
    return sorted(entry.name.removesuffix(".toml") for entry in folder.iterdir())


def example_text(name: str) -> str:
    """A configuration that is shipped; UsageError lists them."""
    if name not in example_names():
        raise UsageError(f"no example {name!r}; expected one of {', '.join(example_names())}")
    return _shipped(f"configs/{name}.toml")


def _shipped(name: str) -> str:
    return (resources.files(__package__) / name).read_text(encoding="utf-8")

"""The files of the service in the file system: written, found and removed below a prefix."""

import shutil
import subprocess
import sysconfig
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Final

from attest_mav.errors import UnwritableError, UsageError
from attest_mav.installation.plan import (
    CONFIGURATION,
    MADE_BY_US,
    STATE,
    UNIT,
    Owner,
    PlannedFile,
    example_names,
    example_text,
)
from attest_mav.runtime.files import atomic_write, reason_of

READABLE: Final = 0o644
"""The daemon's user reads its configuration, and systemd its unit, whatever the umask of the installer is."""


def program_path() -> str:
    """The command ``attest-mav`` of the Python that runs this, in a virtual environment or not; UsageError."""
    program = Path(sysconfig.get_path("scripts")) / "attest-mav"
    if not program.is_file():
        raise UsageError(f"{program}: no such program; install the package first: pip install attest-mav")
    return str(program)


def systemd_version() -> int | None:
    """The version of the systemd of this machine, None where there is none."""
    systemctl = shutil.which("systemctl")
    if systemctl is None:
        return None
    done = subprocess.run([systemctl, "--version"], capture_output=True, text=True, check=False)  # noqa: S603
    words = done.stdout.split()
    return int(words[1]) if len(words) > 1 and words[1].isdecimal() else None


def install(files: Iterable[PlannedFile], prefix: Path, dry_run: bool) -> Iterator[str]:
    """Write the files; what happened to each, in a line. UnwritableError names the one that cannot be written."""
    for file in files:
        target = below(prefix, file.path)
        present = _text_of(target)
        if present == file.text:
            yield f"unchanged   {target}"
        elif present is not None and file.owner is Owner.USERS:
            yield f"kept        {target}"
        elif present is not None and not present.startswith(MADE_BY_US):
            raise UnwritableError(f"{target}: not made by attest-mav; move it away, or keep its content in a drop-in")
        else:
            if not dry_run:
                _write(target, file.text)
            yield f"{'written' if present is None else 'overwritten':<11} {target}"


def uninstall(prefix: Path, purge: bool, dry_run: bool) -> Iterator[str]:
    """Remove what is ours, and with ``purge`` configuration and state too; a line for each."""
    enabled = sorted(below(prefix, "/etc/systemd/system").glob(f"*.wants/{UNIT}*.service"))
    if enabled and not dry_run:
        units = " ".join(path.name for path in enabled)
        raise UsageError(f"still enabled: systemctl disable --now {units}, then this again")
    for target in _ours(prefix):
        yield from _remove(target, dry_run)
    configuration = below(prefix, CONFIGURATION)
    if not purge and _is_as_it_came(configuration):
        yield from _remove(configuration, dry_run)
        yield from _remove_if_empty(configuration.parent, dry_run)
    for target in _of_the_user(prefix, purge):
        if purge and not dry_run:
            _delete(target)
        yield f"{'removed' if purge else 'kept':<11} {target}"


def below(prefix: Path, path: str) -> Path:
    """The place of an absolute path below a prefix."""
    return prefix / path.lstrip("/")


def _ours(prefix: Path) -> Iterator[Path]:
    """The files of ours that are there, whichever version wrote them, and the folders that they leave empty."""
    system = below(prefix, "/etc/systemd/system")
    for unit in (f"{UNIT}.service", f"{UNIT}@.service"):
        yield system / unit
        yield system / f"{unit}.d" / "systemd-254.conf"
        yield system / f"{unit}.d"
    yield below(prefix, f"/etc/sysusers.d/{UNIT}.conf")
    yield below(prefix, f"/etc/udev/rules.d/65-{UNIT}.rules")


def _is_as_it_came(file: Path) -> bool:
    """Whether a file is one of the examples."""
    return _text_of(file) in [example_text(name) for name in example_names()]


def _of_the_user(prefix: Path, purge: bool) -> Iterator[Path]:
    """Configuration and state, and what the user has added; a dry run finds our own files still beside them."""
    ours = set(_ours(prefix))
    for folder in (below(prefix, CONFIGURATION).parent, below(prefix, STATE)):
        if folder.is_dir() and (purge or not all(map(_is_as_it_came, folder.iterdir()))):
            yield folder
    environment = below(prefix, f"/etc/default/{UNIT}")
    if environment.exists():
        yield environment
    for folder in sorted(below(prefix, "/etc/systemd/system").glob(f"{UNIT}*.service.d")):
        if any(one not in ours for one in folder.iterdir()):
            yield folder


def _remove(target: Path, dry_run: bool) -> Iterator[str]:
    """Remove a file of ours, or a whole folder that is not one of drop-ins with the user's own in it."""
    if target.name.endswith(".service.d"):
        yield from _remove_if_empty(target, dry_run)
        return
    if not target.exists():
        return
    text = _text_of(target)
    if text is not None and target.suffix != ".toml" and not text.startswith(MADE_BY_US):
        yield f"kept        {target}"
        return
    if not dry_run:
        _delete(target)
    yield f"removed     {target}"


def _remove_if_empty(folder: Path, dry_run: bool) -> Iterator[str]:
    if folder.is_dir() and not dry_run and not any(folder.iterdir()):
        _delete(folder)
        yield f"removed     {folder}"


def _delete(target: Path) -> None:
    try:
        if target.is_dir():
            shutil.rmtree(target)
        else:
            target.unlink()
    except OSError as error:
        raise UnwritableError(f"cannot remove {target}: {reason_of(error)}") from None


def _write(target: Path, text: str) -> None:
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UnwritableError(f"cannot make the folder {target.parent}: {reason_of(error)}") from None
    with atomic_write(target) as file:
        file.write(text.encode())
    target.chmod(READABLE)


def _text_of(path: Path) -> str | None:
    """The text of a file, None where there is no readable one."""
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return None

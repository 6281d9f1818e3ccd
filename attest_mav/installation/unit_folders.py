"""Folders of a configuration that the unit hides from the daemon or keeps it from writing into."""

from collections.abc import Iterator
from pathlib import Path
from typing import Final

from attest_mav.config.records import Config
from attest_mav.installation.machine import below
from attest_mav.installation.plan import CONFIGURATION, STATE, UNIT

_ALLOWS: Final = "ReadWritePaths"


def unit_remarks(config: Config, path: Path, prefix: Path = Path("/")) -> Iterator[str]:
    """A warning with its key for each folder that the service could not write into; none for files of nobody's unit.

    path: the configuration's, on the machine where the service runs. prefix: where that machine's files are.
    """
    if path.parent != Path(CONFIGURATION).parent:
        return
    is_single = path.stem == UNIT
    unit = UNIT if is_single else f"{UNIT}@{path.stem}"
    own = Path(STATE) if is_single else Path(STATE) / path.stem
    allowed = [own, *_allowed_by_drop_ins(prefix, [unit] if is_single else [unit, f"{UNIT}@"])]
    for key, folder in (("record.folder", config.record.folder), ("state.folder", config.state.folder)):
        if folder and not any(_is_below(folder, one) for one in allowed):
            yield (
                f"{key}: the service {unit} may not write into {folder}; name a folder below {own}, or give it to the "
                f"user {UNIT} and allow it: systemctl edit {unit}, [Service], {_ALLOWS}={folder}"
            )


def _is_below(folder: str, allowed: Path) -> bool:
    """Whether a folder, as the service sees it from its working folder /, lies in an allowed one."""
    path = Path("/", folder)
    return ".." not in path.parts and path.is_relative_to(allowed)


def _allowed_by_drop_ins(prefix: Path, units: list[str]) -> Iterator[Path]:
    """The folders that the drop-ins of these units let the service write into."""
    for unit in units:
        for drop_in in below(prefix, f"/etc/systemd/system/{unit}.service.d").glob("*.conf"):
            for line in drop_in.read_text(encoding="utf-8", errors="replace").splitlines():
                name, _, value = line.partition("=")
                if name.strip() == _ALLOWS:
                    yield from (Path(word.lstrip("-+")) for word in value.split())

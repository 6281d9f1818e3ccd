"""The lock files of requirements/ hold what pyproject.toml asks for, each package with the hashes of its files."""

import re
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[1]
LOCKS = sorted((ROOT / "requirements").glob("*.txt"))
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))


def pins(path):
    """Versions by name, a set each: markers choose among several. And how many hashes each pin has."""
    found, hashes = {}, []
    for entry in path.read_text("utf-8").replace("\\\n", " ").splitlines():
        if entry and not entry.startswith("#"):
            name, _, version = entry.split(" ;")[0].split()[0].partition("==")
            found.setdefault(canonicalize_name(name), set()).add(version)
            hashes.append(len(re.findall(r"--hash=sha256:[0-9a-f]{64}\b", entry)))
    return found, hashes


def asked(lock):
    groups, needed = PROJECT["dependency-groups"], PROJECT["project"]["dependencies"]
    build = PROJECT["build-system"]["requires"]
    return {
        "build": build,
        "check": [*needed, *build, *groups["lint"], *groups["test"]],
        "run": needed,
        "test": [*needed, *groups["test"]],
        "mavproxy": [
            line for line in (ROOT / "requirements/mavproxy.in").read_text("utf-8").splitlines() if "=" in line
        ],
    }[lock]


def test_every_environment_of_the_checks_has_a_lock_file():
    assert [path.stem for path in LOCKS] == ["build", "check", "mavproxy", "run", "test"]


@pytest.mark.parametrize("path", LOCKS, ids=lambda path: path.stem)
def test_a_lock_file_pins_what_is_asked_for(path):
    pinned, hashes = pins(path)
    assert min(hashes) >= 1
    for text in asked(path.stem):
        wanted = Requirement(text)
        versions = pinned.get(canonicalize_name(wanted.name), set())
        assert versions, f"{wanted.name} is not in {path.name}: run tools/lock"
        assert all(wanted.specifier.contains(one) for one in versions), f"{wanted} and {versions}: run tools/lock"


@pytest.mark.parametrize("path", LOCKS, ids=lambda path: path.stem)
def test_a_lock_file_names_no_place(path):
    assert "://" not in path.read_text("utf-8")
    assert "--index" not in path.read_text("utf-8")

"""Single values of a configuration that a command line changes: ``--set KEY=VALUE``."""

import tomllib
from collections.abc import Iterable
from typing import Any

from attest_mav.config.text import printable
from attest_mav.errors import UsageError


def apply_changes(data: dict[str, Any], changes: Iterable[str]) -> None:
    """Change the parsed TOML ``data``: each change is ``TABLE.KEY=VALUE``, as in ``output.rate_hz=50``.

    The value is read as TOML, and as a text where it is none. UsageError for another form; whether key and value
    make sense is checked with the rest of the configuration.
    """
    for change in changes:
        key, equals, value = change.partition("=")
        names = [name.strip() for name in key.split(".")]
        if not equals or not all(names):
            raise UsageError(f"--set {printable(change)}: expected KEY=VALUE, for example output.rate_hz=50")
        _table_of(data, names[:-1], change)[names[-1]] = value_of(value.strip())


def _table_of(data: dict[str, Any], names: list[str], change: str) -> dict[str, Any]:
    """The table of these names, made where it is missing."""
    table = data
    for name in names:
        inner = table.setdefault(name, {})
        if not isinstance(inner, dict):
            raise UsageError(f"--set {printable(change)}: {printable(name)} is no table with keys in it")
        table = inner
    return table


def value_of(text: str) -> Any:
    """The value of a text as TOML has it; the text itself where it is no TOML value."""
    try:
        found = tomllib.loads(f"value = {text}")
    except tomllib.TOMLDecodeError:
        return text
    return found["value"] if len(found) == 1 else text

"""The layers of a configuration: file, folder of drop-ins, environment and command line, each over those before it.

Tables are merged key by key. A list, such as the one of the links, is replaced as a whole.
"""

import tomllib
from collections.abc import Iterable, Mapping
from typing import Any, Final, NamedTuple

from attest_mav.config.changes import apply_changes, value_of
from attest_mav.config.parsing import check_whole, read_tables
from attest_mav.config.records import Config
from attest_mav.config.text import printable
from attest_mav.errors import ConfigError

PREFIX: Final = "ATTEST_MAV__"
"""The beginning of the environment variables that are read: ATTEST_MAV__OUTPUT__RATE_HZ is ``output.rate_hz``."""
DEFAULT: Final = "default"
COMMAND_LINE: Final = "--set"


class Layer(NamedTuple):
    """Parsed tables from one place."""

    origin: str
    """The place, as people know it: a file, a variable, an option."""
    tables: dict[str, Any]
    """What stands there."""


class Layered(NamedTuple):
    """A configuration with the places its values come from."""

    config: Config
    """The checked records."""
    origins: dict[str, str]
    """The origin of each value that is not a default, by its full name, such as ``link[0].url``."""


def file_layer(text: str, name: str) -> Layer:
    """The layer of a TOML text; ConfigError names line and column of what is no TOML."""
    try:
        return Layer(name, tomllib.loads(text))
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{name}: not valid TOML: {printable(str(error))}") from None
    except RecursionError:
        raise ConfigError(f"{name}: nested too deeply; expected tables with values in them") from None


def environment_layers(environment: Mapping[str, str]) -> list[Layer]:
    """A layer for each variable that sets a key. A hyphen of a key is an underscore in the variable."""
    layers = []
    for variable in sorted(environment):
        if variable.startswith(PREFIX):
            names = [name.lower() for name in variable.removeprefix(PREFIX).split("__")]
            if names[0] == "filter" and len(names) > 2:
                names[1] = names[1].replace("_", "-")
            tables: Any = value_of(environment[variable])
            for name in reversed(names):
                tables = {name: tables}
            layers.append(Layer(variable, tables))
    return layers


def command_line_layer(changes: Iterable[str]) -> Layer:
    """The layer of ``--set KEY=VALUE``; UsageError for another form."""
    tables: dict[str, Any] = {}
    apply_changes(tables, changes)
    return Layer(COMMAND_LINE, tables)


def layered(layers: Iterable[Layer]) -> Layered:
    """The configuration that the layers make together; ConfigError names the layer that makes it wrong, and the key."""
    tables: dict[str, Any] = {}
    origins: dict[str, str] = {}
    config, places = Config(), []
    for layer in layers:
        _merge(tables, layer.tables, "", layer.origin, origins)
        config = read_tables(tables, layer.origin)
        places.append(layer.origin)
    check_whole(config, " and ".join(places) or DEFAULT)
    return Layered(config, origins)


def _merge(into: dict[str, Any], tables: dict[str, Any], path: str, origin: str, origins: dict[str, str]) -> None:
    """Put tables over others, and note where each value came from."""
    for key, value in tables.items():
        name = f"{path}.{key}" if path else key
        if isinstance(value, dict):
            inner = into.get(key)
            inner = into[key] = inner if isinstance(inner, dict) else {}
            _merge(inner, value, name, origin, origins)
            continue
        into[key] = value
        for old in [one for one in origins if one == name or one.startswith(f"{name}[")]:
            del origins[old]
        origins.update(dict.fromkeys(_names(value, name), origin))


def _names(value: Any, name: str) -> list[str]:
    """The full names of the values in a value: one, or for a list of tables one for each key of each."""
    if isinstance(value, list) and any(isinstance(one, dict) for one in value):
        return [f"{name}[{index}].{key}" for index, table in enumerate(value) for key in table]
    return [name]

"""TOML text in, a checked configuration out. Every error names the file and the key."""

import tomllib
from collections.abc import Sequence
from typing import Any, Final

import msgspec

from attest_mav.config.changes import apply_changes
from attest_mav.config.link_url import LinkUrl, Scheme, first_clash, parse_link
from attest_mav.config.records import Config, OutputConfig
from attest_mav.config.text import (
    LARGEST,
    SMALLEST,
    check_keys,
    check_numbers,
    has_usual_size,
    is_number,
    printable,
    readable,
)
from attest_mav.errors import ConfigError, UsageError
from attest_mav.mavlink.constants import MAV_COMP_ID_AUTOPILOT1, MAV_COMP_ID_MISSIONPLANNER

TAKEN_COMPONENTS: Final = {MAV_COMP_ID_AUTOPILOT1: "the autopilot", MAV_COMP_ID_MISSIONPLANNER: "ground stations"}
TAKEN_SYSTEMS: Final = {255: "ground stations"}
"""Ids that are not ours to use: autopilots and their failsafes take whoever has them for their owner."""


def parse_config(text: str, name: str, changes: Sequence[str] = ()) -> Config:
    """Check the TOML ``text`` of the file ``name``; ConfigError names the key and the error in one line.

    changes: values that replace those of the text, each as ``KEY=VALUE``; UsageError for another form.
    """
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{name}: not valid TOML: {printable(str(error))}") from None
    except RecursionError:
        raise ConfigError(f"{name}: nested too deeply; expected tables with values in them") from None
    apply_changes(data, changes)
    config = read_tables(data, name)
    check_whole(config, name)
    return config


def check_whole(config: Config, name: str) -> None:
    """ConfigError for values that do not go together; ``name``: where the configuration comes from."""
    _check_links(config, name)
    _check_ids(config.output, name)
    if config.web.listen:
        web_address(config.web.listen, f"{name}: web.listen")
    if (config.raw_imu.accel_mps2 == 0.0) != (config.raw_imu.gyro_radps == 0.0):
        raise ConfigError(f"{name}: raw_imu: accel_mps2 and gyro_radps go together; give both or neither")


def web_address(text: str, name: str) -> LinkUrl:
    """The address HOST:PORT of the live page; ConfigError, which begins with ``name``, for anything else."""
    try:
        return parse_link(f"{Scheme.TCPIN}:{text}")
    except UsageError:
        raise ConfigError(f"{name}: expected HOST:PORT, such as 127.0.0.1:8484, got {text!r}") from None


def read_tables(data: dict[str, Any], name: str) -> Config:
    """Parsed tables to records; ConfigError names the key. ``name``: where the tables come from."""
    try:
        check_keys(data, Config, "")
        check_numbers(data, "", is_number, "a number")
        config = msgspec.convert(data, Config)
        check_numbers(data, "", has_usual_size, f"0, or a size from {SMALLEST:g} to {LARGEST:g}")
    except msgspec.ValidationError as error:
        raise ConfigError(f"{name}: {readable(str(error), data, Config)}") from None
    except ValueError as error:
        raise ConfigError(f"{name}: {error}") from None
    except RecursionError:
        raise ConfigError(f"{name}: nested too deeply; expected tables with values in them") from None
    return config


def _check_links(config: Config, name: str) -> None:
    for index, link in enumerate(config.link):
        try:
            parse_link(link.url)
        except UsageError as error:
            raise ConfigError(f"{name}: link[{index}].url: {error}") from None
        if link.signing != "off" and not link.key_file:
            raise ConfigError(
                f'{name}: link[{index}].key_file: signing = "{link.signing}" needs a key; name the file that holds it'
            )
    clash = first_clash([parse_link(link.url) for link in config.link])
    if clash is not None:
        one, other, resource = clash
        raise ConfigError(f"{name}: link[{other}].url: {resource} belongs to link[{one}] already; expected another one")


def _check_ids(output: OutputConfig, name: str) -> None:
    """ConfigError for ids under which we would be taken for somebody else."""
    for key, value, taken in (
        ("component_id", output.component_id, TAKEN_COMPONENTS),
        ("system_id", output.system_id, TAKEN_SYSTEMS),
    ):
        if value in taken:
            raise ConfigError(f"{name}: output.{key}: {value} belongs to {taken[value]}; choose another, such as 193")

"""The keys of a configuration that can change while the daemon runs, and the differences of two configurations.

Rates, thresholds, gains, the messages that are published and the log change at once. All other keys decide what is
opened, requested or built at the start.
"""

from typing import Any

import msgspec

from attest_mav.config.records import Config, LinkConfig
from attest_mav.config.text import value_text


def with_live_keys(running: Config, wanted: Config) -> Config:
    """The running configuration with those keys of the wanted one that can change while it runs."""
    output = msgspec.structs.replace(
        running.output, rate_hz=wanted.output.rate_hz, max_sigma_deg=wanted.output.max_sigma_deg
    )
    # A filter of one's own may have become another class, which cannot go on from the state.
    same_filter = running.filter.chosen == wanted.filter.chosen != "own"
    return msgspec.structs.replace(
        running,
        output=output,
        link=_links(running.link, wanted.link),
        filter=msgspec.structs.replace(wanted.filter, name=running.filter.name) if same_filter else running.filter,
        verdict=wanted.verdict,
        log=wanted.log,
    )


def differences(before: Config, after: Config) -> dict[str, tuple[str, str]]:
    """The keys whose values differ, each with both values as TOML; "" for a key that one of them does not have."""
    old, new = flat(before), flat(after)
    keys = [*old, *(key for key in new if key not in old)]
    return {key: (old.get(key, ""), new.get(key, "")) for key in keys if old.get(key) != new.get(key)}


def flat(config: Config) -> dict[str, str]:
    """Every key of a configuration under its full name, such as ``output.rate_hz`` or ``link[0].url``."""
    return dict(_flattened(msgspec.to_builtins(config), ""))


def _flattened(value: Any, path: str) -> list[tuple[str, str]]:
    if isinstance(value, dict):
        inner = [(f"{path}.{key}" if path else str(key), one) for key, one in value.items()]
    elif isinstance(value, list | tuple) and any(isinstance(one, dict) for one in value):
        inner = [(f"{path}[{index}]", one) for index, one in enumerate(value)]
    else:
        return [(path, value_text(value))]
    return [pair for key, one in inner for pair in _flattened(one, key)]


def _links(running: tuple[LinkConfig, ...], wanted: tuple[LinkConfig, ...]) -> tuple[LinkConfig, ...]:
    """The running links with the outputs of the wanted ones; unchanged where the links themselves are others."""
    if [link.url for link in running] != [link.url for link in wanted]:
        return running
    return tuple(
        msgspec.structs.replace(
            old, publish=new.publish, yield_to_onboard=new.yield_to_onboard, yield_to_stations=new.yield_to_stations
        )
        for old, new in zip(running, wanted, strict=True)
    )

"""``attest-mav run``: the daemon."""

import signal
import time
from functools import partial

import click

from attest_mav.cli.config import load_layered, set_option
from attest_mav.config.records import Config
from attest_mav.errors import UsageError
from attest_mav.runtime.daemon import Daemon
from attest_mav.runtime.journal import log_to_stderr
from attest_mav.runtime.signals import stop_signals
from attest_mav.types import EarthField


@click.command("run")
@click.option("--config", "config_file", metavar="FILE", help="Configuration (TOML); see `attest-mav config show`.")
@set_option
@click.option("--link", "urls", metavar="URL", multiple=True, help="A link, instead of those of the configuration.")
def command(config_file: str | None, changes: tuple[str, ...], urls: tuple[str, ...]) -> None:
    """Run the daemon: inertial messages in, ATTITUDE_QUATERNION out.

    Links: serial:/dev/ttyAMA0:921600, udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT, tcpin:HOST:PORT, and sim: for
    the built-in fake autopilot. pymavlink's spellings work too. SIGINT and SIGTERM end the daemon with exit code 0;
    SIGHUP lets it read its configuration again.
    """
    read = partial(load_config, config_file, urls, changes)
    config = read()
    log_to_stderr(config.log.level, config.log.format)
    with stop_signals(signal.SIGHUP) as stop:
        Daemon(config, find_field, read).run(stop)


def load_config(config_file: str | None, urls: tuple[str, ...], changes: tuple[str, ...] = ()) -> Config:
    """The configuration file, or the defaults, with the values and links of the command line."""
    config = load_layered(config_file, changes).config
    if urls:
        config = config.with_links(urls)
    if not config.link:
        raise UsageError("no link: name one with --link URL, or with [[link]] in the configuration")
    return config


def find_field(latitude_deg: float, longitude_deg: float, altitude_m: float) -> tuple[EarthField, str]:
    """The Earth's field there and now, and the model it comes from."""
    # Imported at the first position: it takes time, and some vehicles never have one.
    from attest_mav.earth_field import field_at  # noqa: PLC0415

    found = field_at(latitude_deg, longitude_deg, altitude_m, time.time())
    return found.direction, found.source

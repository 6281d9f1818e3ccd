"""``attest-mav play``: a recorded flight on a link, like a live vehicle."""

import time

import click

from attest_mav.config.link_url import Scheme, parse_link
from attest_mav.errors import UnreadableDataError, UsageError
from attest_mav.logs.detect import HEAD_BYTES, require_format
from attest_mav.logs.tlog.played import PlayedLog
from attest_mav.mavlink.dialect import load_dialect
from attest_mav.runtime.files import open_log
from attest_mav.runtime.links.open import open_link
from attest_mav.runtime.signals import stop_signals
from attest_mav.runtime.vehicle_host import VehicleHost

DEFAULT_LINK = "udpout:127.0.0.1:14550"
MIN_SPEED = 0.1
MAX_SPEED = 100.0


@click.command("play")
@click.argument("log", metavar="LOG")
@click.option(
    "--to",
    "link_url",
    metavar="LINK",
    default=DEFAULT_LINK,
    show_default=True,
    help="The link to play on.",
)
@click.option(
    "--speed",
    type=float,
    metavar="X",
    default=1.0,
    show_default=True,
    help=f"Times real time, {MIN_SPEED:g} to {MAX_SPEED:g}.",
)
def command(log: str, link_url: str, speed: float) -> None:
    """Send the frames of a telemetry log (tlog) on a link at the times at which they were recorded.

    The frames of ground stations and of attest-mav are left out. A vehicle that is played answers no command, so that
    its streams have the rates of the recording.
    """
    if not MIN_SPEED <= speed <= MAX_SPEED:
        raise UsageError(f"--speed {speed:g} is out of range: expected {MIN_SPEED:g} to {MAX_SPEED:g}")
    url = parse_link(link_url)
    if url.scheme is Scheme.SIM:
        raise UsageError(f"--to {link_url}: a log needs a real link, for example {DEFAULT_LINK}")
    with open_log(log) as data:
        for note in data.notes:
            click.echo(f"attest-mav play: {click.format_filename(log)}: {note}", err=True)
        if require_format(data[:HEAD_BYTES], log) != "tlog":
            raise UnreadableDataError(f"{log}: it has no MAVLink frames with times; expected a tlog")
        try:
            vehicle = PlayedLog(data, load_dialect())
        except UnreadableDataError as error:
            raise UnreadableDataError(f"{log}: {error}") from None
        link = open_link(url, time.monotonic_ns())
        try:
            with stop_signals() as stop:
                click.echo(f"attest-mav play: {click.format_filename(log)} on {link.url}", err=True)
                VehicleHost(vehicle, link, None, speed).run(stop)
            click.echo(f"attest-mav play: {vehicle.sent} frames sent", err=True)
        finally:
            link.close()

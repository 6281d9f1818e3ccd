"""``attest-mav sim``: the fake autopilot as a process of its own."""

import time
from math import isfinite
from typing import Final

import click

from attest_mav.config.link_url import Scheme, parse_link
from attest_mav.errors import UsageError
from attest_mav.runtime.links.open import open_link
from attest_mav.runtime.signals import stop_signals
from attest_mav.runtime.vehicle_host import VehicleHost
from attest_mav.sim.autopilot import MAX_RATE_HZ, FakeAutopilot
from attest_mav.sim.fault_text import EXAMPLE, FORM, parse_faults, spelling
from attest_mav.sim.faults import KINDS
from attest_mav.sim.personality import PERSONALITIES
from attest_mav.sim.scenarios import SCENARIOS
from attest_mav.sim.settings import SimSettings

DEFAULT_LINK: Final = "udpout:127.0.0.1:14550"
DEFAULT_RATE_HZ: Final = 50.0
MIN_SPEED, MAX_SPEED = 0.01, 100.0
MAX_DURATION_S: Final = 1e6

FAULTS_HELP: Final = "\n".join(
    [
        "\b",
        f"Faults, {FORM}, in seconds of simulated time:",
        *(f"  {spelling(kind):<29} {kind.does}" for kind in KINDS),
        "N: 1 is the sensor of RAW_IMU, 2 that of SCALED_IMU2; both without a number.",
        "A: x, y, z, or north, east, down; all without one.",
        f"For example {EXAMPLE}: 5 deg/s on gyro 1, from 20 s on, for 15 s.",
    ]
)


@click.command("sim", epilog=FAULTS_HELP)
@click.option("--link", "link_url", metavar="URL", default=DEFAULT_LINK, show_default=True, help="Where to fly.")
@click.option(
    "--personality",
    metavar="NAME",
    default=PERSONALITIES[0],
    show_default=True,
    help=f"Whose manners: {' or '.join(PERSONALITIES)}.",
)
@click.option(
    "--rate",
    type=float,
    metavar="HZ",
    default=DEFAULT_RATE_HZ,
    show_default=True,
    help=f"IMU, attitude and truth messages a second until somebody asks for something else, 1 to {MAX_RATE_HZ}.",
)
@click.option(
    "--scenario", metavar="NAME", default="hover", show_default=True, help=f"The motion: {', '.join(SCENARIOS)}."
)
@click.option("--fault", "faults", metavar="FAULT", multiple=True, help="What goes wrong, as below. May be repeated.")
@click.option("--duration", type=float, metavar="S", help="End after so many simulated seconds. Default: never.")
@click.option("--seed", type=int, metavar="N", default=0, show_default=True, help="Equal seeds give equal flights.")
@click.option(
    "--speed",
    type=float,
    metavar="X",
    default=1.0,
    show_default=True,
    help=f"Times real time, {MIN_SPEED:g} to {MAX_SPEED:g}.",
)
def command(
    link_url: str,
    personality: str,
    rate: float,
    scenario: str,
    faults: tuple[str, ...],
    duration: float | None,
    seed: int,
    speed: float,
) -> None:
    """A fake autopilot on a link: true motion, sensors with errors, and the truth in SIM_STATE."""
    if not MIN_SPEED <= speed <= MAX_SPEED:
        raise UsageError(f"--speed {speed:g} is out of range: expected {MIN_SPEED:g} to {MAX_SPEED:g}")
    if duration is not None and not (isfinite(duration) and 0.0 < duration <= MAX_DURATION_S):
        raise UsageError(
            f"--duration {duration:g} is out of range: expected more than 0 and at most {MAX_DURATION_S:g}"
        )
    url = parse_link(link_url)
    if url.scheme is Scheme.SIM:
        raise UsageError(f"--link {link_url}: the fake autopilot needs a real link, for example {DEFAULT_LINK}")
    settings = SimSettings(personality, scenario, rate, faults=parse_faults(faults))
    vehicle = FakeAutopilot(settings, seed)
    link = open_link(url, time.monotonic_ns())
    until = "until interrupted" if duration is None else f"for {duration:g} s"
    wrong = f", faults {' '.join(faults)}" if faults else ""
    host = VehicleHost(vehicle, link, None if duration is None else round(duration * 1e9), speed)
    try:
        with stop_signals() as stop:
            click.echo(f"attest-mav sim: {vehicle}, seed {seed}{wrong}, on {link.url} {until}", err=True)
            host.run(stop)
    finally:
        link.close()

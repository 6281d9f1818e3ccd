"""Warnings on a valid configuration: what is probably not meant, for ``attest-mav config check``."""

from collections.abc import Iterable, Iterator
from difflib import get_close_matches
from typing import Final

from attest_mav.config.link_url import LinkUrl, Scheme, first_clash, parse_link
from attest_mav.config.live import flat
from attest_mav.config.parsing import web_address
from attest_mav.config.records import Config

USUAL_BAUDS: Final = (
    1200, 2400, 4800, 9600, 19200, 38400, 57600, 111100, 115200, 230400, 256000, 460800, 500000, 576000, 625000,
    750000, 921600, 1000000, 1500000, 2000000, 3000000, 4000000, 12000000,
)  # fmt: skip
"""Baud rates of serial ports and of autopilots' settings."""


def remarks(config: Config, given: Iterable[str]) -> Iterator[str]:
    """Each warning with the key it belongs to. given: full names of the values that are no defaults."""
    for index, link in enumerate(config.link):
        url = parse_link(link.url)
        if url.scheme is Scheme.SERIAL:
            yield from (f"link[{index}].url: {text}" for text in _serial_remarks(url))
    yield from _page_remarks(config)
    values, defaults = flat(config), flat(Config())
    for name in given:
        parts = name.split(".")
        is_idle = parts[0] == "filter" and len(parts) > 2 and parts[1] != config.filter.chosen
        if is_idle and values[name] != defaults[name]:
            yield f"{name}: has no effect: the filter is {config.filter.chosen}"


def _page_remarks(config: Config) -> Iterator[str]:
    """Links are opened first, so that the page is the one that goes without."""
    if config.web.listen:
        page = web_address(config.web.listen, "web.listen")
        for index, link in enumerate(config.link):
            clash = first_clash([parse_link(link.url), page])
            if clash is not None:
                yield f"web.listen: {clash[2]} belongs to link[{index}]: there would be no page; choose another port"


def _serial_remarks(url: LinkUrl) -> Iterator[str]:
    if ":" in url.device and not url.device.startswith("/dev/serial/"):
        tail = url.device.rpartition(":")[2]
        yield f"{tail!r} is taken for a part of the device's name; a baud rate is a whole number, such as 921600"
    if url.baud not in USUAL_BAUDS:
        near = get_close_matches(str(url.baud), [str(one) for one in USUAL_BAUDS], n=1)
        hint = f"; is {near[0]} meant?" if near else ""
        yield f"baud rate {url.baud} is unusual{hint}"

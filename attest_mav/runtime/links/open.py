"""Opens links from their URLs, each in the module of its kind.

The modules are imported here on demand: most programs need one kind of link, and pyserial takes its time to load.
"""

from collections.abc import Sequence

from attest_mav.config.link_url import LinkUrl, Scheme, parse_link
from attest_mav.config.records import LinkConfig
from attest_mav.errors import LinkError
from attest_mav.mavlink.dialect import Dialect
from attest_mav.runtime.links.base import Link


def open_links(configs: Sequence[LinkConfig], dialect: Dialect, now_ns: int) -> list[Link]:
    """Open all links of a configuration; if one fails, those already open are closed again."""
    links: list[Link] = []
    try:
        for config in configs:
            url = parse_link(config.url)
            if url.scheme is Scheme.SIM:
                links.append(_open_sim(url, dialect, now_ns))
            else:
                links.append(open_link(url, now_ns, wait=config.wait))
    except BaseException:
        for link in links:
            link.close()
        raise
    return links


def open_link(url: LinkUrl, now_ns: int, *, wait: bool = True) -> Link:
    """Open one link; LinkError (exit code 69) names the remedy in one line.

    A port that is taken, or that may not be opened, is an error at once. A serial device that is not there yet, or a
    TCP server that does not answer, is waited for unless ``wait`` is False. ``sim:`` needs a vehicle inside the
    process, which only ``open_links`` provides.
    """
    if url.scheme is Scheme.SERIAL:
        from attest_mav.runtime.links.serial import SerialLink  # noqa: PLC0415

        return SerialLink(url, now_ns, wait=wait)
    if url.scheme is Scheme.TCP:
        from attest_mav.runtime.links.tcp_client import TcpClientLink  # noqa: PLC0415

        return TcpClientLink(url, now_ns, wait=wait)
    if url.scheme is Scheme.TCPIN:
        from attest_mav.runtime.links.tcp_server import TcpServerLink  # noqa: PLC0415

        return TcpServerLink(url)
    if url.scheme is Scheme.SIM:
        raise LinkError("sim: is a vehicle inside the daemon; give it to `attest-mav run` only")
    from attest_mav.runtime.links.udp import UdpInLink, UdpOutLink  # noqa: PLC0415

    return UdpInLink(url) if url.scheme is Scheme.UDPIN else UdpOutLink(url)


def _open_sim(url: LinkUrl, dialect: Dialect, now_ns: int) -> Link:
    from attest_mav.runtime.links.sim import SimLink  # noqa: PLC0415

    return SimLink(url, dialect, now_ns)

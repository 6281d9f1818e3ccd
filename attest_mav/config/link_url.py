"""Where a link leads, as users write it: ``serial:``, ``udpin:``, ``udpout:``, ``tcp:``, ``tcpin:`` and ``sim:``.

pymavlink's spellings are understood too: ``udp:`` is ``udpin:``, and a bare device such as ``/dev/ttyACM0`` or
``/dev/ttyACM0,115200`` is a serial port. No I/O: ``attest_mav.runtime.links.open`` opens links.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

from attest_mav.errors import UsageError

LOOPBACK = "127.0.0.1"
"""Address of a listener when none is given: no network is reachable unless the user names one."""

DEFAULT_BAUD = 115200
"""pymavlink's default; USB ports ignore it."""

MIN_BAUD, MAX_BAUD = 1200, 12_000_000
MAX_URL_LENGTH = 512

FORMS = "serial:/dev/ttyAMA0:921600, udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT, tcpin:HOST:PORT or sim:"


class Scheme(StrEnum):
    """The kinds of link."""

    SERIAL = "serial"
    UDPIN = "udpin"
    UDPOUT = "udpout"
    TCP = "tcp"
    TCPIN = "tcpin"
    SIM = "sim"


LISTENERS = (Scheme.UDPIN, Scheme.TCPIN)
_SCHEMES = {scheme.value: scheme for scheme in Scheme} | {"udp": Scheme.UDPIN}


@dataclass(frozen=True)
class LinkUrl:
    """A link URL taken apart."""

    scheme: Scheme
    """The kind of link."""
    host: str = ""
    """Networks: name or address."""
    port: int = 0
    """Networks: port; 0 lets the system choose one for a listener."""
    device: str = ""
    """Serial: path of the device."""
    baud: int = DEFAULT_BAUD
    """Serial: baud rate."""
    scenario: str = ""
    """Simulation: the scenario, "" for the default one."""
    faults: tuple[str, ...] = ()
    """Simulation: what goes wrong, each as ``attest-mav sim --fault`` takes it."""

    def __str__(self) -> str:
        """The URL in its plain form."""
        if self.scheme is Scheme.SERIAL:
            return f"serial:{self.device}:{self.baud}"
        if self.scheme is Scheme.SIM:
            return f"sim:{self.scenario}" + ("?" + ",".join(self.faults) if self.faults else "")
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{self.scheme}:{host}:{self.port}"


def first_clash(urls: Sequence[LinkUrl]) -> tuple[int, int, str] | None:
    """The first two links that want one device or one port of this machine, by their numbers, and what they want."""
    for other, url in enumerate(urls):
        for one, before in enumerate(urls[:other]):
            if url.scheme is not before.scheme:
                continue
            if url.scheme is Scheme.SERIAL and url.device == before.device:
                return one, other, url.device
            if url.scheme in LISTENERS and 0 != url.port == before.port and _overlap(url.host, before.host):
                return one, other, f"port {url.port}"
    return None


def _overlap(host: str, other: str) -> bool:
    """Whether two listeners hear on a common address, as far as that can be told without asking the network."""
    return host == other or "0.0.0.0" in {host, other} or "::" in {host, other}  # noqa: S104  (compared, not bound)


def parse_link(text: str) -> LinkUrl:
    """Take a link URL apart; UsageError names the part that is wrong."""
    if len(text) > MAX_URL_LENGTH or not text.isprintable():
        raise UsageError(f"link URL of {len(text)} characters: expected at most {MAX_URL_LENGTH}, all printable")
    if text.startswith("/"):
        return _serial(text, text)
    name, colon, rest = text.partition(":")
    scheme = _SCHEMES.get(name.lower())
    if scheme is None or not colon:
        raise UsageError(f"link {text!r}: expected {FORMS}")
    if scheme is Scheme.SERIAL:
        return _serial(text, rest)
    if scheme is Scheme.SIM:
        scenario, _, faults = rest.partition("?")
        return LinkUrl(scheme, scenario=scenario, faults=tuple(faults.split(",")) if faults else ())
    return _network(text, scheme, rest.removeprefix("//"))


def _serial(text: str, rest: str) -> LinkUrl:
    """DEVICE, DEVICE:BAUD or DEVICE,BAUD; a device's name may itself hold colons (/dev/serial/by-path)."""
    device, baud = rest, DEFAULT_BAUD
    for separator in (",", ":"):
        head, found, tail = rest.rpartition(separator)
        if found and tail.isdecimal():
            device, baud = head, int(tail[:9])
            break
        if found and separator == ",":
            raise UsageError(f"link {text!r}: baud rate {tail!r}: expected a number, such as {DEFAULT_BAUD}")
    if not device:
        raise UsageError(f"link {text!r}: no device; expected for example serial:/dev/ttyAMA0:921600")
    if not MIN_BAUD <= baud <= MAX_BAUD:
        raise UsageError(f"link {text!r}: baud rate {baud} is not within {MIN_BAUD} to {MAX_BAUD}")
    return LinkUrl(Scheme.SERIAL, device=device, baud=baud)


def _network(text: str, scheme: Scheme, rest: str) -> LinkUrl:
    host, _, port_text = rest.rpartition(":")
    host = host.removeprefix("[").removesuffix("]")
    port = int(port_text) if port_text.isdecimal() and len(port_text) <= 5 else -1
    listens = scheme in LISTENERS
    if not 0 <= port <= 65535 or (port == 0 and not listens):
        lowest = 0 if listens else 1
        raise UsageError(f"link {text!r}: expected {scheme}:HOST:PORT with a port of {lowest} to 65535")
    if not host and not listens:
        raise UsageError(f"link {text!r}: no host; expected {scheme}:HOST:PORT")
    return LinkUrl(scheme, host=host or LOOPBACK, port=port)

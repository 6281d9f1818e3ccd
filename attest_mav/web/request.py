"""One HTTP request: GET or HEAD without a body, of bounded size, for a host that may be asked for.

A page of another site can make a browser ask us under that site's own name (DNS rebinding). Requests are therefore
answered only where the Host header holds an address, ``localhost`` or a name of the configuration.
"""

import re
from collections.abc import Collection
from dataclasses import dataclass
from http import HTTPStatus
from ipaddress import ip_address
from typing import Final

MAX_REQUEST_BYTES: Final = 8192
"""A longer head is refused, bytes."""

_LINE: Final = re.compile(r"([A-Z]{1,20}) (/[!-~]*) HTTP/1\.([01])")
_FIELD: Final = re.compile(r"([!#$%&'*+.^_`|~0-9A-Za-z-]+):[ \t]*([\t -~\x80-\xff]*)")


@dataclass(frozen=True)
class Request:
    """A request that can be answered."""

    path: str
    """Without the query."""
    wants_body: bool
    """False for HEAD."""


@dataclass(frozen=True)
class Refusal:
    """A request that is not answered as it was meant, and the reason for a person."""

    status: HTTPStatus
    text: str


_NOT_OURS: Final = Refusal(
    HTTPStatus.MISDIRECTED_REQUEST,
    "expected one Host field with a name of ours; ask by address, or add the name to web.hosts in the configuration",
)


def parse_request(head: bytes, hosts: Collection[str]) -> Request | Refusal | None:
    """The request whose first bytes these are, None while its head is not complete. hosts: names that are ours."""
    end = head.find(b"\r\n\r\n")
    if max(end, len(head) if end < 0 else end) > MAX_REQUEST_BYTES:
        return Refusal(HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE, f"expected at most {MAX_REQUEST_BYTES} bytes")
    if end < 0:
        return None
    first, *rest = head[:end].decode("latin-1").split("\r\n")
    line = _LINE.fullmatch(first)
    fields = [_FIELD.fullmatch(one) for one in rest]
    if line is None or None in fields:
        return Refusal(HTTPStatus.BAD_REQUEST, "expected a request of HTTP/1.0 or 1.1")
    if line[1] not in {"GET", "HEAD"}:
        return Refusal(HTTPStatus.METHOD_NOT_ALLOWED, "expected GET or HEAD: nothing can be changed here")
    named = [field[2].strip() for field in fields if field is not None and field[1].lower() == "host"]
    request = Request(line[2].partition("?")[0], line[1] == "GET")
    if not named and line[3] == "0":
        return request
    return request if len(named) == 1 and is_ours(named[0], hosts) else _NOT_OURS


def is_ours(host: str, hosts: Collection[str]) -> bool:
    """Whether a Host field, with a port or without, names this program and not some site of the Internet."""
    name = host.partition("]")[0].removeprefix("[") if host.startswith("[") else host.rpartition(":")[0] or host
    if name.lower() == "localhost" or name.lower() in {one.lower() for one in hosts}:
        return True
    try:
        ip_address(name)
    except ValueError:
        return False
    return True

"""One HTTP answer, and the events of a stream, as bytes. A connection ends behind its answer."""

from dataclasses import dataclass
from http import HTTPStatus
from typing import Final

TEXT: Final = "text/plain; charset=utf-8"
JSON: Final = "application/json"
EVENTS: Final = "text/event-stream"

POLICY: Final = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
_ALWAYS: Final = (
    "Cache-Control: no-store",
    f"Content-Security-Policy: {POLICY}",
    "Cross-Origin-Resource-Policy: same-origin",
    "Referrer-Policy: no-referrer",
    "X-Content-Type-Options: nosniff",
    "Connection: close",
)


@dataclass(frozen=True)
class Response:
    """Status, type and body. ``streams``: the body goes on, event by event, until one end has enough."""

    body: bytes
    content_type: str = TEXT
    status: HTTPStatus = HTTPStatus.OK
    streams: bool = False

    def encoded(self, *, with_body: bool) -> bytes:
        """The bytes of the answer, without the body for HEAD."""
        length = () if self.streams else (f"Content-Length: {len(self.body)}",)
        allow = ("Allow: GET, HEAD",) if self.status is HTTPStatus.METHOD_NOT_ALLOWED else ()
        lines = (
            f"HTTP/1.1 {self.status.value} {self.status.phrase}",
            f"Content-Type: {self.content_type}",
            *length,
            *allow,
            *_ALWAYS,
        )
        head = "".join(f"{line}\r\n" for line in lines) + "\r\n"
        return head.encode() + (self.body if with_body else b"")


def event(document: bytes) -> bytes:
    """A document without line breaks as one server-sent event."""
    return b"data: " + document + b"\n\n"

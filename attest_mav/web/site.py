"""The addresses of the site, and the answer to each request."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from http import HTTPStatus
from typing import Final

from attest_mav.service.snapshot import Snapshot
from attest_mav.web.document import encoded
from attest_mav.web.health import ailments
from attest_mav.web.metrics import CONTENT_TYPE, metrics_text
from attest_mav.web.request import Refusal, Request
from attest_mav.web.response import EVENTS, JSON, Response, event

DOCUMENT_TYPES: Final = {
    "html": "text/html; charset=utf-8",
    "css": "text/css; charset=utf-8",
    "js": "text/javascript; charset=utf-8",
}
RETRY: Final = b"retry: 1000\n"
"""A browser whose stream has ended asks again after this time, ms."""


@dataclass(frozen=True)
class Site:
    """The live page with its style and script, and the documents that are made when somebody asks for them.

    files: the contents by address.
    """

    files: Mapping[str, bytes]

    def answer(self, request: Request | Refusal, snapshot: Callable[[], Snapshot]) -> Response:
        """The answer to one request. snapshot: makes one now."""
        if isinstance(request, Refusal):
            return Response(f"{request.text}\n".encode(), status=request.status)
        contents = self.files.get(request.path)
        if contents is not None:
            suffix = request.path.rpartition(".")[2]
            return Response(contents, DOCUMENT_TYPES.get(suffix, DOCUMENT_TYPES["html"]))
        document = _DOCUMENTS.get(request.path)
        if document is None:
            known = ", ".join(["/", *_DOCUMENTS])
            return Response(f"not found; expected {known}\n".encode(), status=HTTPStatus.NOT_FOUND)
        return document(snapshot())


def _status(snapshot: Snapshot) -> Response:
    return Response(encoded(snapshot) + b"\n", JSON)


def _metrics(snapshot: Snapshot) -> Response:
    return Response(metrics_text(snapshot).encode(), CONTENT_TYPE)


def _health(snapshot: Snapshot) -> Response:
    found = ailments(snapshot)
    if found:
        return Response(f"{'; '.join(found)}\n".encode(), status=HTTPStatus.SERVICE_UNAVAILABLE)
    return Response(b"ok\n")


def _events(snapshot: Snapshot) -> Response:
    return Response(RETRY + event(encoded(snapshot)), EVENTS, streams=True)


_DOCUMENTS: Final[dict[str, Callable[[Snapshot], Response]]] = {
    "/status": _status,
    "/metrics": _metrics,
    "/healthz": _health,
    "/events": _events,
}

"""The state of a running daemon, asked for over HTTP."""

import http.client
from typing import Any, Final

import msgspec

from attest_mav.config.link_url import LinkUrl
from attest_mav.errors import LinkError

PATIENCE_S: Final = 3.0
"""A daemon answers within milliseconds."""
MAX_BYTES: Final = 1 << 20


def fetch_status(url: LinkUrl) -> dict[str, Any]:
    """The document under /status; LinkError (exit code 69) where no daemon answers."""
    where = f"{url.host}:{url.port}"
    try:
        connection = http.client.HTTPConnection(url.host, url.port, timeout=PATIENCE_S)
        try:
            connection.request("GET", "/status")
            with connection.getresponse() as answer:
                body = answer.read(MAX_BYTES)
        finally:
            connection.close()
    except (OSError, http.client.HTTPException) as error:
        advice = 'is web.listen = "HOST:PORT" in its configuration? another address: --at HOST:PORT'
        raise LinkError(f"no daemon answers at {where} ({error or type(error).__name__}); {advice}") from None
    try:
        document = msgspec.json.decode(body, type=dict[str, Any])
    except msgspec.MsgspecError:
        document = {}
    if answer.status != http.client.OK or not {"now_s", "state", "links", "spans"} <= document.keys():
        raise LinkError(f"what answers at {where} is no attest-mav; choose the daemon's address with --at HOST:PORT")
    return document

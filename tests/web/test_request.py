"""Requests: those that are meant for us, and those that are not."""

import pytest

from attest_mav.web.request import MAX_REQUEST_BYTES, Refusal, Request, is_ours, parse_request


def asked(head, hosts=()):
    return parse_request(head.encode("latin-1"), hosts)


@pytest.mark.parametrize(
    ("head", "request_"),
    [
        ("GET / HTTP/1.1\r\nHost: 127.0.0.1:8484\r\n\r\n", Request("/", True)),
        ("GET /status?x=1 HTTP/1.1\r\nhost:localhost\r\nAccept: */*\r\n\r\n", Request("/status", True)),
        ("HEAD /metrics HTTP/1.1\r\nHost: [::1]:8484\r\n\r\n", Request("/metrics", False)),
        ("GET / HTTP/1.0\r\n\r\n", Request("/", True)),
    ],
)
def test_a_request_for_us_is_taken(head, request_):
    assert asked(head) == request_
    for end in range(len(head)):
        assert asked(head[:end]) is None, "every request may come in pieces"


@pytest.mark.parametrize(
    ("head", "status"),
    [
        ("POST / HTTP/1.1\r\nHost: localhost\r\n\r\n", 405),
        ("GET http://localhost/ HTTP/1.1\r\nHost: localhost\r\n\r\n", 400),
        ("GET / HTTP/2.0\r\nHost: localhost\r\n\r\n", 400),
        ("GET /\r\n\r\n", 400),
        ("\x16\x03\x01\r\n\r\n", 400),
        ("GET / HTTP/1.1\r\nHost : localhost\r\n\r\n", 400),
        ("GET / HTTP/1.1\r\nHost: localhost\r\n folded\r\n\r\n", 400),
        ("GET / HTTP/1.1\r\n\r\n", 421),
        ("GET / HTTP/1.1\r\nHost: localhost\r\nHost: evil.example\r\n\r\n", 421),
        ("GET / HTTP/1.1\r\nHost: evil.example:8484\r\n\r\n", 421),
        ("GET / HTTP/1.1\r\nHost: localhost\r\nX: " + MAX_REQUEST_BYTES * "x", 431),
        ("GET / HTTP/1.1\r\nHost: localhost\r\nX: " + MAX_REQUEST_BYTES * "x" + "\r\n\r\n", 431),
    ],
)
def test_anything_else_is_refused_with_a_reason(head, status):
    refused = asked(head)
    assert isinstance(refused, Refusal)
    assert refused.status == status
    assert refused.text


@pytest.mark.parametrize(
    ("host", "ours"),
    [
        ("127.0.0.1", True),
        ("192.168.7.2:8484", True),
        ("[fe80::1]:8484", True),
        ("LOCALHOST:1", True),
        ("companion.local:8484", True),
        ("evil.example", False),
        ("127.0.0.1.evil.example", False),
        ("localhost.evil.example", False),
        ("", False),
        (":8484", False),
    ],
)
def test_a_name_of_a_foreign_site_is_not_ours(host, ours):
    assert is_ours(host, ("companion.local",)) is ours

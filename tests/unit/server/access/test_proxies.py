"""Only trusted proxies are believed about the clients behind them."""

from __future__ import annotations

import pytest

from skiros_py.server.access.proxies import TrustedProxies

TRUSTED = TrustedProxies(["127.0.0.1", "10.0.0.0/8", "::1"])


def seen(peer: str, headers: dict[str, str]) -> tuple[str, str, str]:
    """Returns client address, scheme and host after the reports."""
    raw = [(b"host", b"inside:8000"), *((name.lower().encode(), value.encode()) for name, value in headers.items())]
    scope = {"type": "http", "client": (peer, 4711), "scheme": "http", "headers": raw}
    assert TRUSTED.apply(scope) is None
    (host,) = [value for name, value in scope["headers"] if name == b"host"]
    return scope["client"][0], scope["scheme"], host.decode()


USUAL = {"X-Forwarded-For": "192.0.2.7", "X-Forwarded-Proto": "https", "X-Forwarded-Host": "robots.example"}
STANDARD = {"Forwarded": 'for="192.0.2.7:4711";proto=https;host=robots.example'}


@pytest.mark.parametrize("peer", ["127.0.0.1", "10.9.8.7", "::1", "::ffff:127.0.0.1"])
@pytest.mark.parametrize("headers", [USUAL, STANDARD])
def test_a_trusted_proxy_is_believed(peer: str, headers: dict[str, str]) -> None:
    assert seen(peer, headers) == ("192.0.2.7", "https", "robots.example")


@pytest.mark.parametrize("peer", ["192.0.2.99", "2001:db8::1", "", "unix"])
@pytest.mark.parametrize("headers", [USUAL, STANDARD])
def test_nobody_else_is_believed(peer: str, headers: dict[str, str]) -> None:
    assert seen(peer, headers) == (peer, "http", "inside:8000")


@pytest.mark.parametrize(
    ("given", "client"),
    [
        ("6.6.6.6, 192.0.2.7", "192.0.2.7"),
        ("6.6.6.6, 192.0.2.7, 10.0.0.1", "192.0.2.7"),
        ("10.0.0.2, 10.0.0.1", "10.0.0.2"),
        ("[2001:db8::1]:4711", "2001:db8::1"),
        ("192.0.2.7:80", "192.0.2.7"),
        ("unknown", "127.0.0.1"),
        ("", "127.0.0.1"),
    ],
)
def test_the_client_is_the_last_address_that_is_no_trusted_proxy(given: str, client: str) -> None:
    assert seen("127.0.0.1", {"X-Forwarded-For": given})[0] == client


def test_a_header_that_the_proxy_only_passes_on_is_not_believed() -> None:
    scope = {"type": "http", "client": ("127.0.0.1", 1), "scheme": "http", "headers": []}
    for name, value in {**USUAL, **STANDARD}.items():
        scope["headers"].append((name.lower().encode(), value.encode()))  # type: ignore[attr-defined]
    problem = TRUSTED.apply(scope)
    assert problem is not None
    assert problem.status == 400
    assert scope["client"] == ("127.0.0.1", 1)

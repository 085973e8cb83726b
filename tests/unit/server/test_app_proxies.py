"""Only trusted proxies are believed about the clients behind them."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from uvicorn.middleware.proxy_headers import ProxyHeadersMiddleware

from skiros_py.server.settings import ServerSettings

TRUSTED = ServerSettings(trusted_proxies=("127.0.0.1", "10.1.2.3/8", "::1"))
REPORT = {"X-Forwarded-For": "192.0.2.7", "X-Forwarded-Proto": "https"}


def seen(peer: str, headers: dict[str, str]) -> tuple[str, str]:
    """Returns client address and scheme of a request, as the application sees them."""
    found: list[tuple[str, str]] = []

    async def app(scope: Any, _receive: Any, _send: Any) -> None:
        found.append((scope["client"][0], scope["scheme"]))

    raw = [(name.lower().encode(), value.encode()) for name, value in headers.items()]
    scope: Any = {"type": "http", "client": (peer, 4711), "scheme": "http", "headers": raw}
    asyncio.run(ProxyHeadersMiddleware(app, TRUSTED.proxy_networks)(scope, None, None))  # type: ignore[arg-type]
    return found[0]


@pytest.mark.parametrize("peer", ["127.0.0.1", "10.9.8.7", "::1", "::ffff:127.0.0.1", "::ffff:10.9.8.7"])
def test_a_trusted_proxy_is_believed(peer: str) -> None:
    assert seen(peer, REPORT) == ("192.0.2.7", "https")
    assert TRUSTED.is_proxy(peer)


@pytest.mark.parametrize("peer", ["192.0.2.99", "2001:db8::1", "::ffff:192.0.2.99", "", "unix"])
def test_a_proxy_that_is_not_trusted_is_not_believed(peer: str) -> None:
    assert seen(peer, REPORT) == (peer, "http")
    assert not TRUSTED.is_proxy(peer)


@pytest.mark.parametrize(
    ("given", "client"),
    [
        ("6.6.6.6, 192.0.2.7", "192.0.2.7"),
        ("6.6.6.6, 192.0.2.7, 10.0.0.1", "192.0.2.7"),
        ("10.0.0.2, 10.0.0.1", "10.0.0.2"),
        ("[2001:db8::1]:4711", "2001:db8::1"),
        ("192.0.2.7:80", "192.0.2.7"),
        ("", "127.0.0.1"),
    ],
)
def test_the_client_is_the_last_address_that_is_no_trusted_proxy(given: str, client: str) -> None:
    assert seen("127.0.0.1", {"X-Forwarded-For": given})[0] == client

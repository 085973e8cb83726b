"""Settings of the server."""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal
from urllib.parse import urlsplit

from skiros_py.api.server import is_address, is_loopback
from skiros_py.errors import UsageError

Authentication = Literal["auto", "keys", "none"]

_NAME = re.compile(r"[a-z0-9_-]+(\.[a-z0-9_-]+)*\.?", re.IGNORECASE)
_ORIGIN = re.compile(r"([a-z][a-z0-9+.-]*)://(\[[0-9a-f:.]+\]|[a-z0-9_.-]+)(?::(\d+))?/?", re.IGNORECASE)
_PUBLIC_URL = re.compile(r"(https?://[^/]+)(?:/[\w.~-]+)*/?", re.ASCII | re.IGNORECASE)
_HIGHEST_PORT = 65_535
_USUAL_PORTS = {"http": 80, "https": 443}


@dataclass(frozen=True, slots=True)
class ServerSettings:
    """Settings of the server.

    Attributes:
        host: Address on which to listen.
        port: Port on which to listen; 0 for any free one.
        authentication: "keys": every request needs a key; "none": no request does; "auto": keys are needed as soon as
            there are any, and always if other machines can reach the server.
        allowed_hosts: Further names of the server, for the check of the Host header.
        allowed_origins: Origins of web pages (``https://mes.example``) that may use the API from a browser.
        public_url: Address under which a reverse proxy serves this server, perhaps with a path; empty for none.
        trusted_proxies: Addresses or networks of the proxies whose reports about their clients are believed.
        webhook_hosts: Hosts, optionally with a port, to which webhooks may be sent; if empty, none are sent.
        connections: Maximum number of open connections; lower if the limit of open files requires it.
        connections_of_one: Maximum number of open connections of one address, or of one /64 network for IPv6.
        header_seconds: Maximum time for a client to send a complete header [s].
        idle_seconds: Maximum time between two requests of a connection [s].
        stalled_seconds: Maximum time for which a client may read nothing of an answer [s].
        rate: Maximum number of requests of one caller per second.
        requests: Maximum number of concurrent requests, including streams.
        open_jobs: Maximum number of open jobs.
        streams: Maximum number of open event streams.
        body: Maximum length of a request body [bytes].
        kept_events: Number of events kept for replay.
        pages: Folder of the web pages; None for none.

    Raises:
        UsageError: Anyone could move the robots, or a host or origin can never match that of a request.
    """

    host: str = "127.0.0.1"
    port: int = 8000
    authentication: Authentication = "auto"
    allowed_hosts: tuple[str, ...] = ()
    allowed_origins: tuple[str, ...] = ()
    public_url: str = ""
    trusted_proxies: tuple[str, ...] = ()
    webhook_hosts: tuple[str, ...] = ()
    connections: int = 4096
    connections_of_one: int = 1024
    header_seconds: float = 10.0
    idle_seconds: int = 60
    stalled_seconds: float = 60.0
    rate: int = 1000
    requests: int = 500
    open_jobs: int = 50_000
    streams: int = 200
    body: int = 1 << 20
    kept_events: int = 20_000
    pages: Path | Literal["installed"] | None = "installed"

    def __post_init__(self) -> None:
        if self.authentication == "none" and not self.is_local:
            raise UsageError(
                f"everybody who reaches {self.reached_at} could move the robots: leave out '--auth none', and make keys"
                " with 'skiros key create'; without keys only 127.0.0.1 is served"
            )
        _check("--allow-host", self.allowed_hosts, _is_host, "a name or address alone, such as robot-1.plant.example")
        _check(
            "--allow-origin",
            self.allowed_origins,
            _is_origin,
            "scheme and host as browsers say them, and a port only where it is not the usual one, such as"
            " https://mes.example or http://10.1.2.3:8080",
        )
        _check(
            "--webhook-host",
            self.webhook_hosts,
            _is_host_with_port,
            f"HOST or HOST:PORT, the port from 1 to {_HIGHEST_PORT}, such as mes.example, 10.1.2.3:8080 or [::1]:8080",
        )
        _check(
            "--public-url",
            (self.public_url,) if self.public_url else (),
            _is_public_url,
            "the address in the browser, with a port only where it is not the usual one, such as"
            " https://robots.example/cell-1",
        )
        _check(
            "--trusted-proxy",
            self.trusted_proxies,
            _is_network,
            "an address or a network, such as 127.0.0.1, ::1 or 10.1.0.0/16",
        )

    @property
    def is_local(self) -> bool:
        """Whether only programs on this machine reach the server; a proxy passes requests of other machines on."""
        return is_loopback(self.host) and not self.public_url and not self.trusted_proxies

    @property
    def proxy_networks(self) -> list[str]:
        """Networks of the trusted proxies, those of IPv4 also in the form in which a socket for IPv6 reports them."""
        networks = [ipaddress.ip_network(one, strict=False) for one in self.trusted_proxies]
        mapped = (f"::ffff:{one.network_address}/{96 + one.prefixlen}" for one in networks if one.version == 4)
        return [*map(str, networks), *mapped]

    def is_proxy(self, address: str) -> bool:
        """Returns whether an address is that of a trusted proxy."""
        if not is_address(address):
            return False
        return any(ipaddress.ip_address(address) in ipaddress.ip_network(one) for one in self.proxy_networks)

    @property
    def reached_at(self) -> str:
        """Where other machines reach the server, for messages."""
        return self.public_url or self.host

    @property
    def public_origin(self) -> str:
        """Scheme, host and port of the public URL, as browsers send them; empty if there is none."""
        parts = urlsplit(self.public_url)
        return f"{parts.scheme}://{parts.netloc}".lower() if self.public_url else ""

    @property
    def prefix(self) -> str:
        """Path of the public URL, such as "/cell-1"; empty if there is none."""
        return urlsplit(self.public_url).path.rstrip("/")


def _check(option: str, values: tuple[str, ...], fits: Callable[[str], bool], right: str) -> None:
    for value in values:
        if not fits(value):
            raise UsageError(f"{option}: nothing can ever come as {value[:200]!r}; it takes {right}")


def _is_host(text: str) -> bool:
    return _is_bare_host(text[1:-1] if text.startswith("[") and text.endswith("]") else text)


def _is_bare_host(text: str) -> bool:
    return _NAME.fullmatch(text) is not None or is_address(text)


def _is_host_with_port(text: str) -> bool:
    host, colon, port = text.rpartition(":")
    return _is_host(text) or bool(colon and _is_host(host) and _is_port(port))


def _is_origin(text: str) -> bool:
    match = _ORIGIN.fullmatch(text)
    if match is None or not _is_host(match[2]):
        return False
    return match[3] is None or (_is_port(match[3]) and int(match[3]) != _USUAL_PORTS.get(match[1].lower()))


def _is_public_url(text: str) -> bool:
    match = _PUBLIC_URL.fullmatch(text)
    return match is not None and _is_origin(match[1])


def _is_network(text: str) -> bool:
    try:
        ipaddress.ip_network(text, strict=False)
    except ValueError:
        return False
    return True


def _is_port(text: str) -> bool:
    return re.fullmatch(r"[1-9]\d{0,4}", text) is not None and int(text) <= _HIGHEST_PORT

"""Settings of the server."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from skiros_py.api.server import is_address, is_loopback
from skiros_py.errors import UsageError

Authentication = Literal["auto", "keys", "none"]

_NAME = re.compile(r"[a-z0-9_-]+(\.[a-z0-9_-]+)*\.?", re.IGNORECASE)
_ORIGIN = re.compile(r"([a-z][a-z0-9+.-]*)://(\[[0-9a-f:.]+\]|[a-z0-9_.-]+)(?::(\d+))?/?", re.IGNORECASE)
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
        webhook_hosts: Hosts, optionally with a port, to which webhooks may be sent; if empty, none are sent.
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
    webhook_hosts: tuple[str, ...] = ()
    rate: int = 1000
    requests: int = 500
    open_jobs: int = 50_000
    streams: int = 200
    body: int = 1 << 20
    kept_events: int = 20_000
    pages: Path | Literal["installed"] | None = "installed"

    def __post_init__(self) -> None:
        if self.authentication == "none" and not is_loopback(self.host):
            raise UsageError(
                f"everybody who reaches {self.host} could move the robots: leave out '--auth none', and make keys with"
                " 'skiros key create'; without keys only 127.0.0.1 is served"
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
            f"HOST or HOST:PORT, the port from 1 to {_HIGHEST_PORT}, such as mes.example or 10.1.2.3:8080",
        )


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
    return _is_bare_host(text) or bool(colon and _is_bare_host(host) and _is_port(port))


def _is_origin(text: str) -> bool:
    match = _ORIGIN.fullmatch(text)
    if match is None or not _is_host(match[2]):
        return False
    return match[3] is None or (_is_port(match[3]) and int(match[3]) != _USUAL_PORTS.get(match[1].lower()))


def _is_port(text: str) -> bool:
    return re.fullmatch(r"[1-9]\d{0,4}", text) is not None and int(text) <= _HIGHEST_PORT

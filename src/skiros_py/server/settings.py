"""How the server is set up."""

from __future__ import annotations

import ipaddress
from dataclasses import dataclass
from typing import Literal

from skiros_py.errors import UsageError

__all__ = ["Authentication", "ServerSettings", "is_loopback"]

Authentication = Literal["auto", "keys", "none"]


@dataclass(frozen=True, slots=True)
class ServerSettings:
    """How the server is set up.

    Attributes:
        host: Address to listen at.
        port: Port to listen at; 0 for any free one.
        authentication: "keys": every request needs a key; "none": none does; "auto": as soon as there are keys,
            and always where other machines reach the server.
        allowed_hosts: Further names under which the server is reached, for the check of the Host header.
        allowed_origins: Origins of web pages (``https://mes.example``) that may use the API from a browser.
        webhook_hosts: Hosts, perhaps with a port, that webhooks may be sent to; none are where it is empty.
        rate: Requests in a second that one caller may make.
        requests: Requests that may be under way at the same time, streams included.
        open_jobs: Jobs that may be open at the same time.
        streams: Event streams that may be open at the same time.
        body: Longest body of a request [bytes].
        kept_events: Events that are kept for replay.
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

    def __post_init__(self) -> None:
        if self.authentication == "none" and not is_loopback(self.host):
            raise UsageError(
                f"everybody who reaches {self.host} could move the robots: leave out '--auth none', and make keys with"
                " 'skiros key create'; without keys only 127.0.0.1 is served"
            )


def is_loopback(host: str) -> bool:
    """Tells whether only programs on this machine reach an address."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False

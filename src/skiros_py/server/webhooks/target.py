"""Permitted targets of webhooks: allowed hosts, at the address that was checked."""

from __future__ import annotations

import ipaddress
import socket
from collections.abc import Collection
from dataclasses import dataclass
from urllib.parse import urlsplit, urlunsplit

from skiros_py.errors import UsageError

Address = ipaddress.IPv4Address | ipaddress.IPv6Address

_PORTS = {"http": 80, "https": 443}


@dataclass(frozen=True, slots=True)
class Target:
    """The target of a webhook.

    Attributes:
        scheme: "http" or "https".
        host: Name or address of the host.
        port: Its port.
        path: Path and query.
    """

    scheme: str
    host: str
    port: int
    path: str

    @property
    def name(self) -> str:
        """The value of the Host header."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return host if self.port == _PORTS[self.scheme] else f"{host}:{self.port}"

    def url_at(self, address: Address) -> str:
        """Returns the URL with the host replaced by its resolved address, so that it is not resolved again."""
        host = f"[{address}]" if address.version == 6 else str(address)
        return urlunsplit((self.scheme, f"{host}:{self.port}", *_path_and_query(self.path), ""))


def _path_and_query(path: str) -> tuple[str, str]:
    before, _, after = path.partition("?")
    return before, after


def target_of(url: str, allowed: Collection[str]) -> Target:
    """Parses a URL, and checks that its host is allowed.

    Args:
        url: The URL.
        allowed: Hosts, optionally with a port, to which webhooks may be sent.

    Raises:
        UsageError: The URL is not valid, or its host is not allowed; the text names the option that allows it.
    """
    try:
        parts = urlsplit(url)
        host, port = parts.hostname or "", parts.port
    except ValueError as error:
        raise UsageError(f"url: {error}: {url[:200]!r} is no address") from None
    if parts.scheme not in _PORTS or not host:
        raise UsageError(f"url: an address begins with https:// or http://, not as {url[:200]!r}")
    if parts.username is not None or parts.fragment or not url.isascii() or any(c <= " " for c in url):
        raise UsageError("url: user names, fragments, blanks and letters beyond ASCII have no place in the address")
    port = port or _PORTS[parts.scheme]
    if not {host, f"{host}:{port}"} & {name.lower() for name in allowed}:
        raise UsageError(
            f"url: webhooks to {host}:{port} are not allowed: start the server with --webhook-host {host}:{port}"
        )
    return Target(parts.scheme, host, port, f"{parts.path or '/'}{'?' + parts.query if parts.query else ''}")


def resolve(target: Target) -> Address:
    """Resolves a host once; the connection is made to this very address, even if the name resolves differently later.

    Raises:
        UsageError: The host is unknown, or no webhook may be sent to its address.
    """
    try:
        found = socket.getaddrinfo(target.host, target.port, type=socket.SOCK_STREAM)
    except OSError as error:
        raise UsageError(f"{target.host} is not known: {error.strerror or error}") from None
    addresses = [ipaddress.ip_address(str(where[0]).partition("%")[0]) for *_, where in found]
    refused = [address for address in addresses if _never(address)]
    if refused:
        raise UsageError(f"{target.host} is {refused[0]}, and no webhook goes there")
    return addresses[0]


def _never(address: Address) -> bool:
    """Link-local addresses serve the metadata of cloud machines; the others are not hosts at all."""
    mapped = getattr(address, "ipv4_mapped", None) or address
    return bool(mapped.is_link_local or mapped.is_multicast or mapped.is_unspecified or mapped.is_reserved)

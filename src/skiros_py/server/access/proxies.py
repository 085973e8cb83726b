"""Reverse proxies in front of the server: what a trusted one reports about a request replaces what the server sees."""

from __future__ import annotations

import ipaddress
import re
from collections.abc import Collection

from starlette.datastructures import Headers
from starlette.types import Scope

from skiros_py.api.server import is_address
from skiros_py.server.problems import Problem

_PAIR = re.compile(r'(\w+)=(?:"((?:[^"\\]|\\.)*)"|([^;,\s"]+))')
_ELEMENT = re.compile(r'(?:"(?:[^"\\]|\\.)*"|[^,"])+')
_PORT = re.compile(r"\[([0-9a-f:.]+)\](?::\d+)?|([0-9.]+):\d+", re.IGNORECASE)


class TrustedProxies:
    """The addresses of trusted proxies; the reports of all others are ignored.

    Args:
        networks: Addresses and networks of the proxies.
    """

    def __init__(self, networks: Collection[str]) -> None:
        self._networks = tuple(ipaddress.ip_network(one, strict=False) for one in networks)

    def __contains__(self, address: str) -> bool:
        if not self._networks or not is_address(address):
            return False
        number = ipaddress.ip_address(address)
        number = getattr(number, "ipv4_mapped", None) or number
        return any(number in network for network in self._networks)

    def apply(self, scope: Scope) -> Problem | None:
        """Replaces client address, scheme and Host header of a request by what trusted proxies report.

        Returns:
            Why the reports are not believed; None if they are, or if there are none.
        """
        if str((scope.get("client") or ("",))[0]) not in self:
            return None
        headers = Headers(scope=scope)
        reports = _standard(headers), _usual(headers)
        if all(any(report.values()) for report in reports):
            # One of them may be by the client, passed on by a proxy that sets the other.
            detail = "Forwarded and X-Forwarded-… exclude each other: let the proxy remove the one that it does not set"
            return Problem(400, "InvalidRequest", detail)
        for report in reports:
            self._believe(report, scope)
        return None

    def _believe(self, report: dict[str, list[str]], scope: Scope) -> None:
        """Believes the report of the outermost trusted proxy."""
        clients = [_without_port(one) for one in report["for"]]  # each proxy has appended its own client
        hops = next((n for n, one in enumerate(reversed(clients), 1) if one not in self), len(clients))
        if clients and is_address(clients[-hops]):
            scope["client"] = (clients[-hops], 0)
        scheme, host = (
            found[-min(hops or 1, len(found))] if found else "" for found in (report["proto"], report["host"])
        )
        if scheme.lower() in ("http", "https"):
            scope["scheme"] = scheme.lower()
        if host:
            others = [(name, value) for name, value in scope["headers"] if name != b"host"]
            scope["headers"] = [*others, (b"host", host.encode("latin-1"))]


def _usual(headers: Headers) -> dict[str, list[str]]:
    """Reads X-Forwarded-For, X-Forwarded-Proto and X-Forwarded-Host."""
    return {
        name: [part.strip() for part in ",".join(headers.getlist(f"x-forwarded-{name}")).split(",") if part.strip()]
        for name in ("for", "proto", "host")
    }


def _standard(headers: Headers) -> dict[str, list[str]]:
    """Reads Forwarded (RFC 7239)."""
    report: dict[str, list[str]] = {"for": [], "proto": [], "host": []}
    for element in _ELEMENT.findall(",".join(headers.getlist("forwarded"))):
        for name, quoted, plain in _PAIR.findall(element):
            if name.lower() in report:
                report[name.lower()].append(plain or re.sub(r"\\(.)", r"\1", quoted))
    return report


def _without_port(client: str) -> str:
    match = _PORT.fullmatch(client)
    return (match[1] or match[2]) if match else client

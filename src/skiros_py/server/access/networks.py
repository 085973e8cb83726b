"""Whom an address belongs to."""

from __future__ import annotations

import ipaddress


def network_of(address: str) -> str:
    """Returns what tells one stranger from another: the address, or of IPv6, where everybody has many, the network."""
    try:
        number = ipaddress.ip_address(address)
    except ValueError:
        return address
    if isinstance(number, ipaddress.IPv4Address):
        return str(number)
    if number.ipv4_mapped is not None:
        return str(number.ipv4_mapped)
    return str(ipaddress.ip_network((int(number), 64), strict=False))

"""Whom an address belongs to."""

from __future__ import annotations

import pytest

from skiros_py.server.access.networks import network_of


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        ("192.0.2.1", "192.0.2.1", True),
        ("192.0.2.1", "192.0.2.2", False),
        ("2001:db8::1", "2001:db8::ffff:2", True),
        ("2001:db8::1", "2001:db8:0:1::1", False),
        ("::ffff:192.0.2.1", "192.0.2.1", True),
        ("::ffff:192.0.2.1", "::ffff:192.0.2.2", False),
        ("fe80::1%eth0", "fe80::2%eth0", True),
        ("testclient", "testclient", True),
        ("", "testclient", False),
    ],
)
def test_addresses_of_one_stranger_are_told_from_those_of_others(one: str, other: str, same: bool) -> None:
    assert (network_of(one) == network_of(other)) is same

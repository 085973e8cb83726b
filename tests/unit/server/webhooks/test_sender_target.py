"""Where webhooks may go."""

import socket

import pytest

from skiros_py.errors import UsageError
from skiros_py.server.webhooks.sender import resolve, target_of


@pytest.mark.parametrize("allowed", ["mes.example", "mes.example:8443"])
def test_a_host_is_allowed_by_name_and_by_name_with_port(allowed):
    target = target_of("https://mes.example:8443/x?y=1", [allowed])

    assert (target.host, target.port, target.raw_path) == ("mes.example", 8443, b"/x?y=1")


@pytest.mark.parametrize(
    "url",
    [
        "https://other.example/",
        "https://mes.example.evil.example/",
        "https://mes.example@evil.example/",
        "https://user:word@mes.example/",
        "ftp://mes.example/",
        "//mes.example/",
        "file:///etc/passwd",
        "https://mes.example:99999/",
        "https://mes.example/#part",
        "https://mes.example/a b",
        "https://mes.example/\n",
        "https://[::1",
        "",
        "\x00",
    ],
)
def test_a_host_that_is_not_allowed_is_refused_with_a_message(url):
    with pytest.raises(UsageError, match=r"url: "):
        target_of(url, ["mes.example"])


def test_without_allowed_hosts_the_message_names_the_option_that_allows_them():
    with pytest.raises(UsageError, match=r"--webhook-host mes\.example:443"):
        target_of("https://mes.example/", [])


@pytest.mark.parametrize(
    "address", ["169.254.169.254", "0.0.0.0", "224.0.0.1", "240.0.0.1", "fe80::1", "::ffff:169.254.169.254"]
)
def test_addresses_that_cannot_be_a_factory_system_are_refused_even_if_their_host_is_allowed(address, monkeypatch):
    monkeypatch.setattr(
        socket, "getaddrinfo", lambda *_a, **_k: [(socket.AF_INET, socket.SOCK_STREAM, 6, "", (address, 443))]
    )
    with pytest.raises(UsageError, match="no webhook goes there"):
        resolve(target_of("https://mes.example/", ["mes.example"]))


def test_an_unknown_host_is_reported():
    with pytest.raises(UsageError, match="is not known"):
        resolve(target_of("https://no-such-host.invalid/", ["no-such-host.invalid"]))


def test_the_connection_goes_to_the_address_that_was_checked():
    target = target_of("http://localhost:81/x?y=1", ["localhost"])

    assert target.copy_with(host=str(resolve(target))) in ("http://127.0.0.1:81/x?y=1", "http://[::1]:81/x?y=1")
    assert target.netloc == b"localhost:81"


@pytest.mark.parametrize("allowed", ["::1", "[::1]", "[::1]:9000"])
def test_an_ipv6_address_is_allowed_as_an_ipv4_address_is(allowed):
    target = target_of("http://[::1]:9000/hook", [allowed])

    assert str(resolve(target)) == "::1"


def test_the_message_names_an_ipv6_address_as_the_option_takes_it():
    with pytest.raises(UsageError, match=r"--webhook-host \[2001:db8::1\]:80"):
        target_of("http://[2001:db8::1]/", ["::1"])

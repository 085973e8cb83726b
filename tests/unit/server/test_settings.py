"""How a server is set up: what can never do anything is refused."""

from __future__ import annotations

import pytest

from skiros_py.errors import UsageError
from skiros_py.server.serving import bind
from skiros_py.server.settings import ServerSettings


@pytest.mark.parametrize(
    "name", ["http://x/", "x:8000", "x/", "a b", "", "*", "bücher.example", "[::1", "x..y", "x@y", "[::1]:80"]
)
def test_an_impossible_host_name_is_refused_in_the_settings(name: str) -> None:
    with pytest.raises(UsageError, match=r"--allow-host: .* such as robot-1.plant.example"):
        ServerSettings(allowed_hosts=(name,))


@pytest.mark.parametrize("name", ["robot-1", "Robot_1.plant.example", "10.1.2.3", "::1", "[2001:db8::1]"])
def test_valid_host_names_and_addresses_are_accepted(name: str) -> None:
    assert ServerSettings(allowed_hosts=(name,)).allowed_hosts == (name,)


@pytest.mark.parametrize(
    "origin",
    ["x", "mes.example:80", "https://x/y", "https://x:443", "http://x:80/", "https://", "null", "*", "https://x:0", ""],
)
def test_an_impossible_origin_is_refused_in_the_settings(origin: str) -> None:
    with pytest.raises(UsageError, match=r"--allow-origin: .* such as https://mes.example"):
        ServerSettings(allowed_origins=(origin,))


@pytest.mark.parametrize(
    "origin", ["https://mes.example", "http://10.1.2.3:8080/", "http://[::1]:3000", "http://x:443"]
)
def test_valid_origins_are_accepted(origin: str) -> None:
    assert ServerSettings(allowed_origins=(origin,)).allowed_origins == (origin,)


@pytest.mark.parametrize("host", ["http://x:1/", "x:99999", "x:0", "x:", ":80", "x:http", "", "x/y", "[::1:80"])
def test_an_impossible_webhook_host_is_refused(host: str) -> None:
    with pytest.raises(UsageError, match=r"--webhook-host: .* such as mes.example"):
        ServerSettings(webhook_hosts=(host,))


@pytest.mark.parametrize("host", ["mes.example", "MES.example:8080", "10.1.2.3:65535", "::1", "::1:8080"])
def test_webhook_hosts_are_accepted_with_and_without_a_port(host: str) -> None:
    assert ServerSettings(webhook_hosts=(host,)).webhook_hosts == (host,)


@pytest.mark.parametrize("host", ["192.0.2.1", "999.1.1.1", f"{'a' * 64}.example"])
def test_binding_to_a_foreign_address_blames_the_host_and_not_the_port(host: str) -> None:
    with pytest.raises(UsageError, match="--host is no address of this machine") as told:
        bind(ServerSettings(host=host, port=0))

    assert "--port" not in str(told.value)


@pytest.mark.parametrize(
    "url", ["robots.example", "ftp://x", "https://x:443", "https://x/a?b", "https://x/a b", "https://"]
)
def test_an_impossible_public_url_is_refused(url: str) -> None:
    with pytest.raises(UsageError, match=r"--public-url: .* such as https://robots.example/cell-1"):
        ServerSettings(public_url=url)


@pytest.mark.parametrize(
    ("url", "origin", "prefix"),
    [
        ("https://Robots.example", "https://robots.example", ""),
        ("https://robots.example/cell-1/", "https://robots.example", "/cell-1"),
        ("http://[::1]:8080/a/b", "http://[::1]:8080", "/a/b"),
    ],
)
def test_a_public_url_has_an_origin_and_a_prefix(url: str, origin: str, prefix: str) -> None:
    settings = ServerSettings(public_url=url)
    assert (settings.public_origin, settings.prefix) == (origin, prefix)


@pytest.mark.parametrize("network", ["proxy.example", "10.0.0.0/99", ""])
def test_an_impossible_proxy_is_refused(network: str) -> None:
    with pytest.raises(UsageError, match="--trusted-proxy: "):
        ServerSettings(trusted_proxies=(network,))


def test_a_server_behind_a_proxy_needs_keys_although_it_listens_on_this_machine_only() -> None:
    assert ServerSettings().is_local
    assert not ServerSettings(trusted_proxies=("127.0.0.1",)).is_local
    with pytest.raises(UsageError, match=r"everybody who reaches https://robots\.example could move the robots"):
        ServerSettings(public_url="https://robots.example", authentication="none")


@pytest.mark.parametrize("host", ["[::1]:9000", "::1", "[2001:db8::1]", "10.1.2.3:80"])
def test_webhook_hosts_may_be_addresses_of_either_family(host: str) -> None:
    assert ServerSettings(webhook_hosts=(host,)).webhook_hosts == (host,)

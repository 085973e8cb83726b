"""What browsers say about the page that makes a request."""

from __future__ import annotations

import pytest
from starlette.datastructures import Headers

from skiros_py.server.access.origins import OriginPolicy
from skiros_py.server.problems import Problem
from skiros_py.server.settings import ServerSettings

_OURS = "http://127.0.0.1:8000"


def _origins(**settings) -> OriginPolicy:
    return OriginPolicy(ServerSettings(**settings))


@pytest.mark.parametrize(
    "host", ["127.0.0.1", "127.0.0.1:8000", "localhost:1", "LocalHost", "[::1]:8000", "robot.example:1"]
)
def test_own_host_names_are_accepted_with_any_port(host: str) -> None:
    _origins(allowed_hosts=("Robot.example",)).check_host(Headers({"host": host}))


@pytest.mark.parametrize(
    "host",
    [
        "",
        "evil.example",
        "127.0.0.1.evil.example",
        "127.0.0.1@evil.example",
        "localhost:80:80",
        "localhost/",
        "192.168.1.5",
    ],
)
def test_foreign_host_names_are_refused(host: str) -> None:
    with pytest.raises(Problem, match="not called"):
        _origins().check_host(Headers({"host": host}))


def test_a_server_on_all_interfaces_accepts_any_ip_address_but_no_host_name() -> None:
    places = _origins(host="0.0.0.0")
    places.check_host(Headers({"host": "192.168.1.5:8000"}))

    with pytest.raises(Problem):
        places.check_host(Headers({"host": "evil.example"}))


@pytest.mark.parametrize(
    "said",
    [
        {"origin": "https://evil.example"},
        {"origin": "null"},
        {"origin": "http://127.0.0.1:9000"},
        {"origin": "https://127.0.0.1:8000"},
        {"sec-fetch-site": "cross-site"},
        {"origin": _OURS, "sec-fetch-site": "cross-site"},
    ],
)
def test_foreign_origins_may_read_but_not_change(said: dict[str, str]) -> None:
    headers = Headers({"host": "127.0.0.1:8000", **said})

    with pytest.raises(Problem) as caught:
        _origins().check_origin("POST", "http", headers)

    assert caught.value.status == 403
    _origins().check_origin("GET", "http", headers)


@pytest.mark.parametrize("said", [{}, {"origin": _OURS}, {"origin": _OURS, "sec-fetch-site": "same-origin"}])
def test_own_pages_and_programs_may_change_things(said: dict[str, str]) -> None:
    _origins().check_origin("DELETE", "http", Headers({"host": "127.0.0.1:8000", **said}))


def test_only_allowed_origins_get_cors_headers() -> None:
    places = _origins(allowed_origins=("https://mes.example/",))
    theirs = Headers({"host": "127.0.0.1", "origin": "https://mes.example", "sec-fetch-site": "cross-site"})
    places.check_origin("POST", "http", theirs)

    assert places.answer(theirs)["Access-Control-Allow-Origin"] == "https://mes.example"
    assert "PATCH" in places.preflight(theirs)["Access-Control-Allow-Methods"]
    assert places.answer(Headers({"origin": "https://evil.example"})) == {}
    with pytest.raises(Problem):
        places.preflight(Headers({"origin": "https://evil.example"}))

"""Pages for people beside the API: open to everybody, but no way around the gate."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import httpx2
import pytest
from support.serving import Served, serving

from skiros_py.server.access.roles import Role
from skiros_py.server.settings import ServerSettings
from skiros_py.station.session import Options

INDEX = "<!doctype html><title>cell</title>"
WITH_KEYS = ServerSettings(authentication="keys", rate=5)


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pages")
    (folder / "assets").mkdir()
    (folder / "index.html").write_text(INDEX)
    (folder / "assets" / "index-1.js").write_text("1")
    return folder


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory, pages: Path) -> Iterator[Served]:
    with serving(
        "kitting", tmp_path_factory.mktemp("data"), Options(fake=True), replace(WITH_KEYS, pages=pages)
    ) as running:
        yield running


@pytest.fixture
def browser(served: Served) -> Iterator[httpx2.Client]:
    with httpx2.Client(base_url=served.url) as client:
        yield client


def test_pages_need_no_key_but_their_data_does(browser: httpx2.Client) -> None:
    assert browser.get("/").text == browser.get("/goal").text == INDEX
    assert browser.get("/assets/index-1.js").status_code == 200
    assert browser.get("/", headers={"Authorization": "Bearer wrong"}).status_code == 200
    assert browser.get("/api/v1/view").status_code == 401
    assert browser.get("/metrics").status_code == 401


def test_page_files_are_not_limited_by_the_request_rate(browser: httpx2.Client) -> None:
    answers = {browser.get("/assets/index-1.js").status_code for _ in range(10 * WITH_KEYS.rate)}

    assert answers == {200}


def test_foreign_pages_cannot_reach_the_server_under_their_own_host_name(browser: httpx2.Client) -> None:
    answer = browser.get("/", headers={"Host": "evil.example"})

    assert (answer.status_code, answer.json()["code"]) == (403, "HostRefused")


def test_unknown_api_paths_are_not_answered_with_a_page(served: Served) -> None:
    headers = {"X-API-Key": served.services.keys.local_token}
    with httpx2.Client(base_url=served.url, headers=headers) as client:
        for path in ("/api/v1/nothing", "/api/nothing", "/metrics/x"):
            answer = client.get(path)
            assert (answer.status_code, answer.headers["content-type"]) == (404, "application/problem+json")
        assert client.put("/api/v1/view").status_code == 405
        assert client.post("/goal").status_code == 404


def test_responses_for_pages_have_security_headers(browser: httpx2.Client) -> None:
    headers = browser.get("/").headers

    assert headers["x-content-type-options"] == "nosniff"
    assert headers["referrer-policy"] == "no-referrer"
    assert "script-src 'self';" in headers["content-security-policy"]


def test_logins_at_two_ports_of_one_host_do_not_replace_each_other(served: Served, tmp_path: Path) -> None:
    with (
        serving("kitting", tmp_path, Options(fake=True), replace(WITH_KEYS, rate=100)) as other,
        httpx2.Client() as browser,  # which keeps cookies by host, as browsers do
    ):
        for server in (served, other):
            _, key = server.services.keys.create("anna", Role.VIEWER)
            assert browser.post(f"{server.url}/api/v1/session", json={"key": key}).is_success

        assert [browser.get(f"{server.url}/api/v1/session").status_code for server in (served, other)] == [200, 200]


def test_without_installed_pages_the_root_explains_how_to_install_them(tmp_path: Path) -> None:
    settings = replace(WITH_KEYS, pages=None)
    with serving("kitting", tmp_path, Options(fake=True), settings) as server, httpx2.Client() as browser:
        page = browser.get(server.url)
        assert (page.status_code, "pip install skiros-web" in page.text) == (200, True)
        assert browser.get(f"{server.url}/goal").json()["code"] == "NotFound"
        assert browser.get(f"{server.url}/api/v1/view").status_code == 401

"""The recipe for a TLS proxy, tried with the real program: pages, login, orders and events through it."""

from __future__ import annotations

import json
import os
import re
import shutil
import socket
import ssl
import subprocess
import time
from collections.abc import Iterator
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from pathlib import Path

import httpx2
import pytest
from support.programs import needs
from support.serving import serving

from skiros_py.server.access.keys import KeyStore
from skiros_py.server.access.roles import Role
from skiros_py.server.settings import ServerSettings

NGINX = shutil.which("nginx", path=f"{os.environ.get('PATH', '')}:/usr/sbin:/sbin")
RECIPE = Path(__file__).parents[2] / "docs" / "how-to" / "proxy.md"
FRAME = """
daemon off; pid {folder}/pid; error_log {folder}/error.log; {user}
events {{}}
http {{
  access_log off;
  client_body_temp_path {folder}/body; proxy_temp_path {folder}/proxy; fastcgi_temp_path {folder}/fastcgi;
  uwsgi_temp_path {folder}/uwsgi; scgi_temp_path {folder}/scgi;
  {server}
}}
"""

pytestmark = needs(NGINX, "nginx is not installed")


@dataclass(frozen=True, slots=True)
class Behind:
    """A server behind a proxy.

    Attributes:
        url: Its public address.
        direct: Its own address.
        key: A key of an administrator.
        trust: The certificate of the proxy.
    """

    url: str
    direct: str
    key: str
    trust: ssl.SSLContext

    def client(self, **more: str) -> httpx2.Client:
        """Returns a browser-like client on another address than the proxy."""
        transport = httpx2.HTTPTransport(verify=self.trust, local_address="127.0.0.2")
        origin = re.sub(r"/cell-1$", "", self.url)
        return httpx2.Client(base_url=self.url, transport=transport, headers={"Origin": origin, **more}, timeout=30)


@pytest.fixture(scope="module")
def behind(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Behind]:
    folder, data = tmp_path_factory.mktemp("nginx"), tmp_path_factory.mktemp("data")
    certificate, private = folder / "robots.crt", folder / "robots.key"
    subject = ["-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost"]
    command = ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", *subject]
    subprocess.run([*command, "-keyout", private, "-out", certificate], check=True, capture_output=True)
    with closing(socket.create_server(("127.0.0.1", 0))) as free:
        port = free.getsockname()[1]
    url = f"https://localhost:{port}/cell-1"
    with closing(KeyStore(data)) as keys:
        _, key = keys.create("anna", Role.ADMIN, None)
    settings = replace(ServerSettings(), public_url=url, trusted_proxies=("127.0.0.1",))
    with serving("kitting", data, settings=settings) as served:
        block = re.search(r"```nginx\n(.*?)```", RECIPE.read_text(encoding="utf-8"), re.DOTALL)
        assert block is not None
        server = block[1].replace("listen 443 ", f"listen 127.0.0.1:{port} ").replace("robots.example", "localhost")
        server = server.replace("http://127.0.0.1:8000", served.url).replace("/etc/nginx", str(folder))
        user = "user root;" if os.geteuid() == 0 else ""
        (folder / "nginx.conf").write_text(FRAME.format(folder=folder, user=user, server=server), encoding="utf-8")
        assert NGINX is not None
        with subprocess.Popen([NGINX, "-p", folder, "-c", folder / "nginx.conf", "-e", "stderr"]) as proxy:
            try:
                found = Behind(url, served.url, key, ssl.create_default_context(cafile=str(certificate)))
                _wait(found)
                yield found
            finally:
                proxy.terminate()


def _wait(behind: Behind) -> None:
    deadline = time.monotonic() + 30
    with behind.client() as client:
        while time.monotonic() < deadline:
            with suppress(httpx2.TransportError):
                client.get("/healthz").raise_for_status()
                return
            time.sleep(0.05)
    raise TimeoutError("the proxy does not answer")


@pytest.fixture
def browser(behind: Behind) -> Iterator[httpx2.Client]:
    with behind.client() as client:
        client.post("/api/v1/session", json={"key": behind.key}).raise_for_status()
        yield client


def test_a_person_logs_in_and_the_cookie_is_secure_and_belongs_to_the_prefix(behind: Behind) -> None:
    with behind.client() as client:
        answer = client.post("/api/v1/session", json={"key": behind.key})
    assert answer.status_code == 200, answer.text
    cookie = answer.headers["set-cookie"].lower()
    assert "secure" in cookie
    assert "path=/cell-1;" in f"{cookie};"


def test_the_page_and_the_api_reference_load(browser: httpx2.Client) -> None:
    assert browser.get("/").status_code == 200
    page = browser.get("/api/v1/docs").raise_for_status()
    for link in re.findall(r"(?:href|src)=\"([^\"]+)\"", page.text):
        assert browser.get(str(page.url.join(link))).status_code == 200, link
    assert page.url.join("openapi.json").path == "/cell-1/api/v1/openapi.json"


def test_the_description_names_the_public_address(behind: Behind, browser: httpx2.Client) -> None:
    assert browser.get("/api/v1/openapi.json").json()["servers"] == [{"url": behind.url}]


def test_an_order_is_followed_through_the_proxy(browser: httpx2.Client) -> None:
    with browser.stream("GET", "/api/v1/events", params={"kind": "job"}) as events:
        lines = events.iter_lines()
        next(lines)  # unbuffered: it arrives before anything happens
        ordered = browser.put("/api/v1/jobs/through", json={"goal": "EmptyHanded(gripper_1)"})
        assert ordered.status_code == 202, ordered.text
        assert ordered.headers["location"] == "/cell-1/api/v1/jobs/through"
        states = (json.loads(line[5:]) for line in lines if line.startswith("data:"))
        assert next(one for one in states if one["subject"] == "through")
    assert browser.get(ordered.headers["location"].removeprefix("/cell-1")).status_code == 200


def test_the_audit_log_names_the_client_not_the_proxy(behind: Behind, browser: httpx2.Client) -> None:
    browser.put("/api/v1/jobs/audited", json={"goal": "EmptyHanded(gripper_1)"}).raise_for_status()
    entry = browser.get("/api/v1/audit").json()["items"][0]
    assert (entry["path"], entry["address"]) == ("/api/v1/jobs/audited", "127.0.0.2")


def test_a_client_cannot_name_another_address(behind: Behind) -> None:
    with behind.client(**{"X-Forwarded-For": "6.6.6.6", "Forwarded": "for=6.6.6.6"}) as client:
        client.post("/api/v1/session", json={"key": behind.key}).raise_for_status()
        assert client.get("/api/v1/audit").json()["items"][0]["address"] == "127.0.0.2"


def test_a_foreign_page_is_refused_behind_the_proxy(behind: Behind) -> None:
    with behind.client(Origin="https://evil.example") as client:
        assert client.post("/api/v1/session", json={"key": behind.key}).json()["code"] == "OriginRefused"

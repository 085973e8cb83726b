"""Cases 18 and 19: strangers and tricks at the door, and what webhooks of a real server meet."""

from __future__ import annotations

import base64
import json
import logging
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import httpx2
import pytest
from standardwebhooks import Webhook
from support.server_process import ServerProcess
from support.serving import Served, serving

from skiros_py.server.access.roles import Role
from skiros_py.server.settings import ServerSettings

from .hard import HOLDS, STARTER, api_of, over, until

# ------------------------------------------------------------------ case 18: the door


@pytest.fixture(scope="module")
def locked(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("data")) as served:
        served.services.keys.create("chief", Role.ADMIN)
        yield served


def b64(data: object) -> str:
    return base64.urlsafe_b64encode(json.dumps(data).encode()).decode().rstrip("=")


JWT = f"{b64({'alg': 'none'})}.{b64({'sub': 'admin', 'role': 'admin', 'exp': 4e9})}."


def test_expired_and_revoked_keys_give_no_access(locked: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    keys = locked.services.keys
    _, short = keys.create("short", Role.ADMIN, expires=(datetime.now(UTC) + timedelta(hours=1)).timestamp())
    revoked, secret = keys.create("gone", Role.ADMIN)
    with api_of(locked, short) as api, api_of(locked, secret) as other:
        assert (api.get("/jobs").status_code, other.get("/jobs").status_code) == (200, 200)
        keys.revoke(revoked.id)
        real = time.time
        monkeypatch.setattr(time, "time", lambda: real() + 3601.0)
        assert (api.get("/jobs").status_code, other.get("/jobs").status_code) == (401, 401)


@pytest.mark.parametrize(
    "type_", ["text/plain", "application/x-www-form-urlencoded", "multipart/form-data; boundary=x"]
)
def test_a_form_on_a_foreign_page_changes_nothing_even_with_the_cookie_of_the_browser(
    locked: Served, type_: str
) -> None:
    _, secret = locked.services.keys.create("anna", Role.ADMIN)
    with api_of(locked) as api:
        assert api.post("/session", json={"key": secret}).status_code == 200
        before = len(api.get("/keys").json()["items"])
        body = b'{"name": "a", "role": "admin"}'
        page = {"Origin": "https://evil.example", "Sec-Fetch-Site": "cross-site", "Content-Type": type_}
        assert api.post("/keys", content=body, headers=page).status_code in (403, 415)
        assert api.post("/keys", content=body, headers={"Content-Type": type_}).status_code in (403, 415, 422)
        assert len(api.get("/keys").json()["items"]) == before


@pytest.mark.parametrize(
    "host", ["evil.example", "127.0.0.1.evil.example", "localhost.evil.example:80", "[::2]", "x@y"]
)
@pytest.mark.parametrize("path", ["/api/v1/jobs", "/api/v1/events", "/api/v1/docs", "/healthz", "/api/v1/stop"])
def test_a_foreign_host_name_for_this_machine_is_refused(locked: Served, host: str, path: str) -> None:
    with httpx2.Client(base_url=locked.url) as client:
        answer = client.get(path, headers={"Host": host})
    assert answer.status_code in (400, 403)


def test_a_key_in_a_url_is_neither_accepted_nor_logged(locked: Served, caplog: pytest.LogCaptureFixture) -> None:
    _, secret = locked.services.keys.create("careless", Role.ADMIN)
    with caplog.at_level(logging.DEBUG), api_of(locked) as api:
        for query in (f"key={secret}", f"api_key={secret}", f"token={secret}", f"access_token={secret}"):
            assert api.get(f"/jobs?{query}").status_code in (400, 401, 422)
    ours = [
        one.getMessage() for one in caplog.records if one.name.startswith(("skiros_py", "uvicorn.error", "asyncio"))
    ]
    assert secret[12:] not in "\n".join(ours)


# These come last, for the door is closed to who guesses.


@pytest.mark.parametrize(
    "headers",
    [
        {},
        {"Authorization": f"Bearer {JWT}"},
        {"Authorization": "Basic YWRtaW46YWRtaW4="},
        {"Authorization": "Bearer x"},
        {"X-API-Key": ""},
        {"X-API-Key": "' OR 1=1 --"},
        {"X-Skiros-User": "chief"},
        {"X-Forwarded-For": "127.0.0.1", "X-Real-IP": "127.0.0.1", "Forwarded": "for=127.0.0.1"},
        {"Cookie": "skiros_session=chief"},
        {"X-HTTP-Method-Override": "GET"},
    ],
)
def test_only_valid_keys_give_access(locked: Served, headers: dict[str, str]) -> None:
    with api_of(locked) as api:
        answers = [
            api.get("/jobs", headers=headers),
            api.put("/jobs/x", json=HOLDS, headers=headers),
            api.get("/events", headers=headers),
            api.get("/robots/state/stream", headers=headers),
            api.post("/stop", headers=headers),
            api.get("/openapi.json", headers=headers),
        ]
    assert {answer.status_code for answer in answers} <= {401, 429}
    assert not locked.services.station.session.cycle.halted


# ------------------------------------------------------------------ case 19: webhooks


class Target:
    """A factory system that listens, and answers as it is told to.

    Attributes:
        events: What it took.
        answer: Gives the status for an event; 0 for none at all.
    """

    def __init__(self) -> None:
        self.events: list[dict[str, Any]] = []
        self.headers: list[dict[str, str]] = []
        self.bodies: list[bytes] = []
        self.answer: Callable[[dict[str, Any]], int] = lambda _event: 200
        target = self

        class Handler(BaseHTTPRequestHandler):
            def do_POST(self) -> None:
                body = self.rfile.read(int(self.headers["content-length"]))
                status = target.answer(json.loads(body))
                if status == 200:
                    target.bodies.append(body)
                    target.headers.append({name.lower(): value for name, value in self.headers.items()})
                    target.events.append(json.loads(body))
                self.send_response(status)
                if status == 302:
                    self.send_header("Location", "http://169.254.169.254/latest")
                self.send_header("Content-Length", str(10_000_000 if status == 201 else 0))
                self.end_headers()

            def log_message(self, *_args: object) -> None:
                pass

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._server.daemon_threads = True
        threading.Thread(target=self._server.serve_forever, args=(0.02,), daemon=True).start()
        self.url = f"http://127.0.0.1:{self._server.server_port}/hook"

    def states(self, job: str) -> list[str]:
        """The states of a job in the order in which they were told, each once."""
        told = {one["id"]: one["data"]["job"]["state"]["text"] for one in self.events if one["subject"] == job}
        return list(told.values())

    def close(self) -> None:
        self._server.shutdown()
        self._server.server_close()


@pytest.fixture
def target() -> Iterator[Target]:
    made = Target()
    yield made
    made.close()


WHOLE_LIFE = ["AllowedToStart", "Running", "Ended"]


def test_a_target_that_fails_at_first_gets_all_messages_in_order_and_a_slow_one_delays_no_job(
    target: Target, tmp_path: Path
) -> None:
    settings, lets_go, failures = replace(ServerSettings(), webhook_hosts=("127.0.0.1",)), threading.Event(), []

    def badly(event: dict[str, Any]) -> int:
        if event["subject"] == "slow":
            lets_go.wait(30)
        elif len(failures) < 2:
            failures.append(event)
            return (500, 302)[len(failures) - 1]
        return 200

    target.answer = badly
    with serving("kitting", tmp_path / "data", settings=settings) as served, api_of(served) as api:
        hook = api.post("/webhooks", json={"url": target.url}).raise_for_status().json()
        api.put("/jobs/slow", json=HOLDS).raise_for_status()
        assert over(api, "slow")["outcome"] == "goal already satisfied"
        api.put("/jobs/kit", json=STARTER).raise_for_status()
        assert over(api, "kit")["outcome"] == "succeeded"
        until(lambda: target.states("kit") == WHOLE_LIFE)
        lets_go.set()
        until(lambda: target.states("slow") == WHOLE_LIFE)
        for body, headers in zip(target.bodies, target.headers, strict=True):
            Webhook(hook["secret"]).verify(body.decode(), headers)
        assert hook["secret"] not in api.get("/webhooks").text
    assert len(failures) == 2


@pytest.mark.parametrize(
    "url",
    ["http://169.254.169.254/x", "http://localhost:9/x", "http://[::1]:9/", "file:///etc/passwd", "http://evil.example/",
     "http://127.0.0.1@evil.example/", "gopher://127.0.0.1/", "http://0177.0.0.1/", "http://2130706433/", "http://"],
)  # fmt: skip
def test_a_webhook_reaches_only_allowed_hosts(open_: Served, url: str) -> None:
    with api_of(open_) as api:
        refused = api.post("/webhooks", json={"url": url})
        assert refused.status_code == 422, refused.text
        assert api.get("/webhooks").json()["items"] == []


@pytest.fixture(scope="module")
def open_(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    settings = replace(ServerSettings(), webhook_hosts=("mes.example",))
    with serving("kitting", tmp_path_factory.mktemp("data"), settings=settings) as served:
        yield served


def test_messages_undelivered_at_a_kill_of_the_server_are_delivered_afterwards_in_order(
    target: Target, tmp_path: Path
) -> None:
    target.answer = lambda _event: 503
    start = ("--fake", "--webhook-host", "127.0.0.1")
    with ServerProcess("kitting", *start, data=tmp_path) as server, server.client() as client:
        client.http.post("/webhooks", json={"url": target.url}).raise_for_status()
        client.http.put("/jobs/kit", json=HOLDS).raise_for_status()
        over(client.http, "kit")
        server.kill()
    target.answer = lambda _event: 200
    with ServerProcess(*start, data=tmp_path) as server, server.client() as client:
        until(lambda: target.states("kit") == WHOLE_LIFE)
        until(lambda: client.http.get("/webhooks").json()["items"][0]["pending"] == 0)
    numbers = [one["sequence"] for one in target.events]
    assert numbers == sorted(set(numbers))

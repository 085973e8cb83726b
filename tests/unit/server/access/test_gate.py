"""The gate, in front of a small application."""

from __future__ import annotations

import asyncio
import errno
import json
import logging
from collections.abc import AsyncIterator, Iterable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import httpx2
import pytest
from fastapi import FastAPI, Request
from fastapi.responses import StreamingResponse
from pydantic import BaseModel, Field
from starlette.responses import JSONResponse
from starlette.testclient import TestClient
from starlette.types import Receive, Scope, Send

from skiros_py.errors import FileError
from skiros_py.server.access import audit as audit_module
from skiros_py.server.access.audit import AuditLog, note
from skiros_py.server.access.authenticator import Authenticator
from skiros_py.server.access.gate import Gate
from skiros_py.server.access.keys import KeyStore
from skiros_py.server.access.roles import Anybody, Operator, OperatorOrMes, Role, Viewer
from skiros_py.server.monitoring import Metrics
from skiros_py.server.problems import Problem, add_problem_handlers
from skiros_py.server.services import set_up_access
from skiros_py.server.settings import ServerSettings
from skiros_py.station.control import ControlThread
from skiros_py.station.events.log import EventLog


class _Thing(BaseModel):
    name: str = Field(max_length=10)


@dataclass(frozen=True)
class _Guarded:
    settings: ServerSettings
    keys: KeyStore
    authenticator: Authenticator
    audit: AuditLog
    metrics: Metrics


@dataclass(frozen=True)
class _Door:
    client: TestClient
    guarded: _Guarded

    def key(self, role: Role = Role.ADMIN) -> dict[str, str]:
        """Makes a key, and returns the header that shows it."""
        return {"X-API-Key": self.guarded.keys.create(f"the {role}", role)[1]}


class _Doors:
    def __init__(self, data: Path, stack: ExitStack) -> None:
        self._data, self._stack = data, stack

    def __call__(self, **settings: Any) -> _Door:
        """Opens a door."""
        chosen = replace(ServerSettings(), **settings)
        metrics = Metrics(ControlThread(lambda: pytest.fail("is not opened")), EventLog(1))
        guarded = _Guarded(chosen, *set_up_access(chosen, self._data, self._stack), metrics)
        app = _application()
        app.add_middleware(Gate, guarded)
        return _Door(TestClient(app, base_url="http://127.0.0.1:8000", raise_server_exceptions=False), guarded)


@pytest.fixture
def door(tmp_path: Path) -> Iterator[_Doors]:
    with ExitStack() as stack:
        yield _Doors(tmp_path, stack)


def _application() -> FastAPI:
    app = FastAPI()
    add_problem_handlers(app)

    @app.get("/caller")
    def caller(act: Viewer) -> dict[str, str]:
        return {"name": act.caller.name, "role": act.caller.role}

    @app.post("/things")
    def things(act: Operator, thing: _Thing, request: Request) -> _Thing:
        note(request, job="kit-1", comment="because")
        return thing

    @app.post("/api/v1/stop")
    async def stop(act: OperatorOrMes) -> dict[str, bool]:
        return {"stopped": True}

    @app.get("/broken")
    def broken(act: Viewer) -> None:
        raise RuntimeError("the secret recipe")

    @app.get("/faulty")
    def faulty(act: Viewer) -> None:
        raise FileError(Path("plant/of_anna/jobs.db"), "another program uses plant/of_anna/jobs.db")

    @app.get("/full")
    def full(act: Viewer) -> None:
        raise FileError(Path("plant/of_anna/jobs.db"), "no room") from OSError(errno.ENOSPC, "no room")

    @app.get("/jobs/{job_id}")
    def job(act: Viewer, job_id: str) -> None:
        raise Problem(404, "UnknownJobOrderID", "there is no such job")

    @app.get("/varied")
    def varied(act: Anybody) -> None:
        act.response.headers["Vary"] = "Accept-Language"

    @app.get("/stream")
    async def stream(act: Viewer) -> StreamingResponse:
        return StreamingResponse(_beats(), media_type="text/event-stream")

    return app


async def _beats() -> AsyncIterator[bytes]:
    while True:
        yield b": beat\n\n"
        await asyncio.sleep(0.01)


def test_every_response_has_an_id_and_restrictive_browser_headers(door: _Doors) -> None:
    client = door().client

    ours, theirs = client.get("/caller"), client.get("/caller", headers={"X-Request-Id": "mes-17"})

    assert len(ours.headers["X-Request-Id"]) == 16
    assert theirs.headers["X-Request-Id"] == "mes-17"
    assert ours.headers["Cache-Control"] == "no-store"
    assert ours.headers["X-Content-Type-Options"] == "nosniff"


@pytest.mark.parametrize("text", ["a\x7fb", "x" * 65, "../x", "sk_12345678_" + "a" * 43])
def test_a_request_id_that_could_corrupt_a_log_is_replaced(door: _Doors, text: str) -> None:
    assert door().client.get("/caller", headers={"X-Request-Id": text}).headers["X-Request-Id"] != text


def test_a_request_with_a_foreign_host_name_is_refused(door: _Doors) -> None:
    answer = door().client.get("/caller", headers={"Host": "evil.example"})

    assert (answer.status_code, answer.json()["code"]) == (403, "HostRefused")


@pytest.mark.parametrize(
    "kind", ["text/plain", "application/x-www-form-urlencoded", "multipart/form-data; boundary=x", ""]
)
def test_a_body_without_a_json_content_type_is_refused(door: _Doors, kind: str) -> None:
    headers = {"Content-Type": kind} if kind else {}

    answer = door().client.post("/things", content=b'{"name": "a"}', headers=headers)

    assert (answer.status_code, answer.json()["code"]) == (415, "UnsupportedMediaType")


def test_a_foreign_page_cannot_change_anything(door: _Doors) -> None:
    at = door()

    answer = at.client.post("/things", json={"name": "a"}, headers={"Origin": "https://evil.example"})

    assert (answer.status_code, answer.json()["code"]) == (403, "OriginRefused")
    assert "access-control-allow-origin" not in answer.headers


def test_an_allowed_page_is_answered_and_needs_a_key(door: _Doors) -> None:
    at = door(allowed_origins=("https://mes.example",))
    page = {"Origin": "https://mes.example"}
    key = at.key(Role.OPERATOR)

    asked = at.client.options("/things", headers={**page, "Access-Control-Request-Method": "POST"})
    without = at.client.post("/things", json={"name": "a"}, headers=page)
    answered = at.client.post("/things", json={"name": "a"}, headers={**page, **key})

    assert (asked.status_code, without.status_code, answered.status_code) == (204, 401, 200)
    assert answered.headers["Access-Control-Allow-Origin"] == "https://mes.example"
    assert "access-control-allow-credentials" not in asked.headers


def test_what_an_answer_varies_with_is_kept_beside_the_origin_of_an_allowed_page(door: _Doors) -> None:
    at = door(allowed_origins=("https://mes.example",))

    theirs = at.client.get("/varied", headers={"Origin": "https://mes.example"})

    assert {one.strip() for one in theirs.headers["Vary"].split(",")} == {"Accept-Language", "Origin"}
    assert at.client.get("/varied").headers["Vary"] == "Accept-Language"


def test_a_page_that_is_not_allowed_gets_no_cors_headers(door: _Doors) -> None:
    asked = {"Origin": "https://evil.example", "Access-Control-Request-Method": "POST"}

    answer = door().client.options("/things", headers=asked)

    assert answer.status_code == 403
    assert not [name for name in answer.headers if name.startswith("access-control")]


@pytest.mark.parametrize(
    "place", ["/caller?api_key={}", "/caller?access_token=x", "/caller?q={}", "/x/{}", "/caller?X-API-Key=a"]
)
def test_a_key_in_a_url_is_refused_and_never_logged(door: _Doors, place: str, caplog: pytest.LogCaptureFixture) -> None:
    at = door()
    key = at.key()["X-API-Key"]

    with caplog.at_level(logging.DEBUG):
        answer = at.client.get(place.format(key))

    told = answer.text + json.dumps([str(entry) for entry in at.guarded.audit.page().items])
    assert (answer.status_code, answer.json()["code"]) == (400, "KeyInAddress")
    assert key[12:] not in told
    assert not [record for record in caplog.records if key[12:] in record.getMessage() and "skiros" in record.name]


def test_too_long_urls_and_headers_are_refused(door: _Doors) -> None:
    client = door().client

    assert client.get("/caller?q=" + "x" * 9000).status_code == 414
    assert client.get("/caller", headers={"X-Long": "x" * 40_000}).status_code == 431
    assert client.get("/caller?q=%00").status_code == 400


@pytest.mark.parametrize("announced", [True, False])
def test_a_body_that_is_too_long_is_answered_with_a_problem_document(door: _Doors, announced: bool) -> None:
    body: Any = b"x" * 2000
    client = door(body=1000).client

    answer = client.post(
        "/things",
        content=body if announced else (body[i : i + 100] for i in range(0, 2000, 100)),
        headers={"Content-Type": "application/json"},
    )

    assert (answer.status_code, answer.json()["code"]) == (413, "BodyTooLong")
    assert answer.headers["Content-Type"] == "application/problem+json"


@pytest.mark.parametrize(
    "body", [b"[" * 1_000_000, rb'{"name": "\ud800"}', b'{"name": NaN}', rb'{"\udfff": "\u0000"}', b"{", b"\xff"]
)
def test_an_invalid_body_is_answered_with_a_problem_document(door: _Doors, body: bytes) -> None:
    answer = door().client.post("/things", content=body, headers={"Content-Type": "application/json"})

    assert answer.status_code in {400, 422}
    assert answer.json()["code"] == "InvalidRequest"


def test_a_fault_in_a_field_is_reported_with_its_place(door: _Doors) -> None:
    problem = door().client.post("/things", json={"name": "x" * 11}).json()

    assert problem["errors"][0]["field"] == "body.name"
    assert "at most 10" in problem["detail"]


def test_a_caller_over_its_rate_limit_must_wait_but_may_still_stop_everything(door: _Doors) -> None:
    at = door(rate=5)
    operator, other = at.key(Role.OPERATOR), at.key(Role.VIEWER)

    answers = [at.client.get("/caller", headers=operator) for _ in range(20)]

    refused = next(answer for answer in answers if answer.status_code == 429)
    assert refused.headers["Retry-After"] == "1"
    assert at.client.post("/api/v1/stop", headers=operator).status_code == 200
    assert at.client.get("/caller", headers=other).status_code == 200


def test_excess_concurrent_requests_must_wait_but_a_stop_need_not(door: _Doors) -> None:
    at = door(requests=0)

    busy = at.client.get("/caller")

    assert (busy.status_code, busy.json()["code"], busy.headers["Retry-After"]) == (503, "Busy", "1")
    assert at.client.post("/api/v1/stop").status_code == 200


def test_an_internal_error_is_answered_without_details_and_logged_with_the_request(
    door: _Doors, caplog: pytest.LogCaptureFixture
) -> None:
    answer = door().client.get("/broken", headers={"X-Request-Id": "mes-17"})

    assert (answer.status_code, answer.json()["instance"]) == (500, "mes-17")
    assert "recipe" not in answer.text
    assert "Traceback" not in answer.text
    assert any("mes-17" in record.getMessage() and record.exc_info for record in caplog.records)


@pytest.mark.parametrize(("path", "status", "code"), [("/faulty", 503, "FileFault"), ("/full", 507, "DiskFull")])
def test_a_file_error_is_answered_without_its_path_which_is_logged(
    door: _Doors, caplog: pytest.LogCaptureFixture, path: str, status: int, code: str
) -> None:
    answer = door().client.get(path)

    assert (answer.status_code, answer.json()["code"]) == (status, code)
    assert answer.json()["detail"].startswith("jobs.db: ")
    assert "anna" not in answer.text
    assert ("Retry-After" in answer.headers) == (status == 503)
    assert any("plant/of_anna/jobs.db" in record.getMessage() for record in caplog.records)


def test_only_problems_of_jobs_have_a_return_status(door: _Doors) -> None:
    client = door().client

    assert client.get("/jobs/x").json()["return_status"] == 2
    assert "return_status" not in client.get("/nothing").json()


def test_a_stream_ends_when_the_key_of_its_reader_is_revoked(door: _Doors) -> None:
    """Read by hand: the client for tests would wait for the end of the stream before it gives anything."""
    at = door()
    key, text = at.guarded.keys.create("anna", Role.VIEWER)
    sent: list[bytes] = []

    async def send(message: Any) -> None:
        sent.append(message.get("body", b""))
        if len(sent) == 5:
            at.guarded.keys.revoke(key.id)

    asyncio.run(_read_stream(at.client.app, text, send))

    assert len(sent) == 6
    assert sent[-1] == b""


async def _read_stream(app: Any, key: str, send: Any) -> None:
    headers = [(b"host", b"127.0.0.1"), (b"x-api-key", key.encode())]
    scope = {
        "type": "http", "method": "GET", "path": "/stream", "raw_path": b"/stream", "query_string": b"",
        "scheme": "http", "headers": headers, "client": ("127.0.0.1", 1), "server": ("127.0.0.1", 8000),
        "http_version": "1.1",
    }  # fmt: skip

    async def receive() -> Any:
        await asyncio.sleep(60)

    await asyncio.wait_for(app(scope, receive, send), 20)


def test_changes_and_refusals_are_logged_with_their_caller(door: _Doors) -> None:
    at = door()
    operator, viewer = at.key(Role.OPERATOR), at.key(Role.VIEWER)
    at.client.get("/caller", headers=viewer)
    at.client.post("/things", json={"name": "secret"}, headers=operator)
    at.client.post("/things", json={"name": "a"}, headers=viewer)
    at.client.get("/caller", headers={"X-API-Key": "wrong"})

    refused, forbidden, done = at.guarded.audit.page().items

    assert (done.caller, done.operation, done.status, done.job, done.comment) == (
        "the operator", "things", 200, "kit-1", "because",
    )  # fmt: skip
    assert (forbidden.caller, forbidden.role, forbidden.status) == ("the viewer", "viewer", 403)
    assert (refused.caller, refused.role, refused.status) == ("", "", 401)
    assert "secret" not in str(done)


def _refusals(at: _Door, addresses: Iterable[str]) -> int:
    """Is refused from some addresses, and returns how much of that was written down."""
    for address in addresses:
        client = TestClient(at.client.app, base_url="http://127.0.0.1:8000", client=(address, 1))
        client.get("/caller", headers={"X-API-Key": "wrong"})
    return len(at.guarded.audit.page(limit=1000).items)


def test_a_stop_begins_before_other_requests_that_came_in_the_same_moment(door: _Doors) -> None:
    at, begun = door(), list[str]()

    async def app(scope: Scope, receive: Receive, send: Send) -> None:
        begun.append(scope["path"])
        await JSONResponse({})(scope, receive, send)

    async def ask() -> None:
        transport = httpx2.ASGITransport(Gate(app, at.guarded))
        async with httpx2.AsyncClient(transport=transport, base_url="http://127.0.0.1:8000") as client:
            others = [client.get("/caller") for _ in range(50)] + [client.post("/things", json={}) for _ in range(50)]
            await asyncio.gather(*others, client.post("/api/v1/stop"))

    asyncio.run(ask())
    assert len(begun) == 101
    assert begun.index("/api/v1/stop") == 0


def test_refused_requests_cannot_fill_the_audit_log(door: _Doors) -> None:
    assert _refusals(door(), ["192.0.2.1"] * 100) == 10  # refused with 401, then with 429


def test_refused_requests_of_a_key_are_counted(door: _Doors, monkeypatch: pytest.MonkeyPatch) -> None:
    at = door()
    viewer = at.key(Role.VIEWER)
    for number in range(80):
        assert at.client.post("/things", json={"name": str(number)}, headers=viewer).status_code == 403
    assert [entry.count for entry in at.guarded.audit.page().items] == [1] * 5

    monkeypatch.setattr(audit_module, "_MINUTE", 0.0)
    at.guarded.audit._count_refusals()

    counted, *listed = at.guarded.audit.page().items
    assert (counted.caller, counted.status, counted.count) == ("the viewer", 403, 75)
    assert len(listed) == 5


def test_requests_from_many_addresses_of_one_network_cannot_fill_the_audit_log(door: _Doors) -> None:
    assert _refusals(door(), [f"2001:db8::{number:x}" for number in range(100)]) == 10


def test_requests_from_many_networks_cannot_fill_the_audit_log(door: _Doors, monkeypatch: pytest.MonkeyPatch) -> None:
    at = door()
    assert _refusals(at, [f"192.0.{number // 200}.{number % 200}" for number in range(400)]) == 300
    monkeypatch.setattr(audit_module, "_MINUTE", 0.0)
    at.guarded.audit._count_refusals()
    newest = at.guarded.audit.page(limit=1).items[0]
    assert (newest.address, newest.status, newest.count) == ("", 401, 100)


def test_a_websocket_is_refused_before_it_opens(door: _Doors) -> None:
    sent: list[Any] = []

    async def send(message: Any) -> None:
        sent.append(message)

    asyncio.run(door().client.app({"type": "websocket", "path": "/", "headers": []}, None, send))  # type: ignore[arg-type]

    assert [message["type"] for message in sent] == ["websocket.close"]

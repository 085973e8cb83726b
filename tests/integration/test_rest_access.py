"""Strangers, guessers and pages of others before a real server; keys and logins of those who may come in."""

from __future__ import annotations

import json
import logging
import socket
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path
from urllib.parse import urlsplit

import httpx2
import pytest
from support.serving import Served, serving

from skiros_py.api.server import KeyOrder
from skiros_py.client.client import Client
from skiros_py.server.access.roles import Role


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    with serving("kitting", tmp_path_factory.mktemp("access") / "data") as running:
        running.services.keys.create("the first", Role.ADMIN)
        yield running


@pytest.fixture
def admin(served: Served) -> Iterator[httpx2.Client]:
    headers = {"Authorization": f"Bearer {served.services.keys.local_token}"}
    with httpx2.Client(base_url=f"{served.url}/api/v1", headers=headers) as client:
        yield client


@pytest.fixture
def stranger(served: Served) -> Iterator[httpx2.Client]:
    with httpx2.Client(base_url=f"{served.url}/api/v1") as client:
        yield client


def _raw(served: Served, request: bytes) -> bytes:
    """Sends bytes, and returns the first that come back."""
    address = urlsplit(served.url)
    with socket.create_connection((address.hostname, address.port), timeout=20) as connection:
        connection.sendall(request)
        return connection.recv(65_536)


def test_an_administrator_creates_lists_and_revokes_a_key(admin: httpx2.Client, stranger: httpx2.Client) -> None:
    made = admin.post("/keys", json={"name": "line 1", "role": "mes", "expires": "2099-01-01T00:00:00Z"})
    key, secret = made.json()["key"], made.json()["secret"]
    theirs = {"X-API-Key": secret}

    assert (made.status_code, made.headers["Location"]) == (201, f"/api/v1/keys/{key['id']}")
    assert key in admin.get("/keys").json()["items"]
    assert secret not in admin.get("/keys").text
    assert stranger.get("/session", headers=theirs).json()["role"] == "mes"
    assert admin.delete(f"/keys/{key['id']}").json()["valid"] is False
    assert stranger.get("/session", headers=theirs).status_code == 401
    assert admin.get(f"/keys/{key['id']}").json()["revoked"] is not None
    assert admin.delete("/keys/nothing").status_code == 404


def test_the_client_creates_and_revokes_keys(served: Served) -> None:
    from skiros_py.client.topics import Audit, Keys, Session

    with Client(served.url, served.services.keys.local_token) as client:
        made = client.send(Keys.create(KeyOrder(name="anna", role="viewer")))
        assert client.send(Keys.get(made.key.id)) == made.key
        assert made.key in client.send(Keys.list()).items
        with Client(served.url, made.secret) as anna:
            assert anna.send(Session.get()).name == "anna"
        assert not client.send(Keys.revoke(made.key.id)).valid
        done = client.send(Audit.list(limit=1)).items[0]

    assert (done.operation, done.path) == ("revoke_key", f"/api/v1/keys/{made.key.id}")


@pytest.mark.parametrize(
    "order",
    [
        {"name": "", "role": "admin"},
        {"name": "a", "role": "king"},
        {"name": "a\n", "role": "admin"},
        {"name": "a", "role": "admin", "expires": "1999-01-01T00:00:00Z"},
        {"name": "a", "role": "admin", "expires": "9998-01-01T00:00:00Z"},
        {"name": "a", "role": "admin", "secret": "mine"},
        {"name": ["a"], "role": None},
        [],
    ],
)
def test_an_invalid_request_for_a_key_is_refused(admin: httpx2.Client, order: object) -> None:
    answer = admin.post("/keys", json=order)

    assert answer.status_code == 422
    assert answer.json()["detail"]


def test_a_page_logs_in_with_a_cookie_that_scripts_cannot_read(
    served: Served, admin: httpx2.Client, stranger: httpx2.Client
) -> None:
    made = admin.post("/keys", json={"name": "anna", "role": "operator"}).json()

    login = stranger.post("/session", json={"key": made["secret"]})

    cookie = login.headers["set-cookie"]
    assert login.json()["name"] == "anna"
    assert all(word in cookie for word in ("HttpOnly", "SameSite=strict", "Path=/", "Max-Age=43200"))
    assert made["secret"] not in cookie
    assert stranger.get("/session").json()["key"] == made["key"]["id"]
    foreign = {"Origin": "http://127.0.0.1:1", "Sec-Fetch-Site": "same-site"}
    assert stranger.delete("/session", headers=foreign).status_code == 403
    admin.delete(f"/keys/{made['key']['id']}")
    assert stranger.get("/session").status_code == 401


def test_a_page_has_no_access_after_logging_out(admin: httpx2.Client, stranger: httpx2.Client) -> None:
    secret = admin.post("/keys", json={"name": "anna", "role": "operator"}).json()["secret"]
    stranger.post("/session", json={"key": secret})
    kept = dict(stranger.cookies)

    assert stranger.delete("/session").status_code == 204
    ((name, text),) = kept.items()
    assert stranger.get("/session", headers={"Cookie": f"{name}={text}"}).status_code == 401


def test_a_session_lists_only_the_operations_that_its_role_may_use(
    admin: httpx2.Client, stranger: httpx2.Client
) -> None:
    secret = admin.post("/keys", json={"name": "anna", "role": "viewer"}).json()["secret"]

    theirs = stranger.get("/session", headers={"X-API-Key": secret}).json()
    ours = admin.get("/session").json()

    assert theirs["keys_needed"]
    assert "get_session" in theirs["operations"]
    assert "create_key" not in theirs["operations"]
    assert "create_key" in ours["operations"]


def test_the_access_log_with_urls_is_off(served: Served) -> None:
    assert not logging.getLogger("uvicorn.access").propagate


def test_keys_appear_in_no_log(served: Served, admin: httpx2.Client, caplog: pytest.LogCaptureFixture) -> None:
    secret = admin.post("/keys", json={"name": "anna", "role": "viewer"}).json()["secret"]
    with caplog.at_level(logging.DEBUG), httpx2.Client(base_url=served.url) as client:
        for path in ("/api/v1/session", f"/{secret}", f"/api/v1/session?api_key={secret}", f"/api/v1/keys/{secret}"):
            client.get(path, headers={"X-API-Key": secret})
    ours = [record.getMessage() for record in caplog.records if record.name.partition(".")[0] == "skiros_py"]

    assert secret[12:] not in "\n".join(ours)
    assert secret[12:] not in admin.get("/audit?limit=1000").text


def test_guessing_keys_is_slowed_down_without_affecting_other_callers(served: Served, admin: httpx2.Client) -> None:
    with httpx2.Client(base_url=f"{served.url}/api/v1") as guesser:
        answers = [guesser.post("/session", json={"key": f"sk_12345678_{number:043}"}) for number in range(15)]

    assert answers[-1].status_code == 429
    assert int(answers[-1].headers["Retry-After"]) >= 1
    assert admin.get("/session").status_code == 200


def test_the_audit_log_is_read_page_by_page(admin: httpx2.Client) -> None:
    for name in ("a", "b", "c"):
        admin.post("/keys", json={"name": name, "role": "viewer"})

    first = admin.get("/audit", params={"limit": 2}).json()
    second = admin.get("/audit", params={"limit": 2, "cursor": first["next"]}).json()

    numbers = [item["number"] for item in (*first["items"], *second["items"])]
    assert numbers == sorted(numbers, reverse=True)
    assert first["items"][0]["operation"] == "create_key"
    assert admin.get("/audit", params={"cursor": "x"}).status_code == 422


def test_a_request_with_two_host_headers_is_refused(served: Served) -> None:
    answer = _raw(served, b"GET /healthz HTTP/1.1\r\nHost: localhost\r\nHost: evil.example\r\n\r\n")

    assert answer.startswith(b"HTTP/1.1 40")


def test_a_request_for_a_foreign_host_name_is_refused(served: Served) -> None:
    answer = _raw(served, b"GET /healthz HTTP/1.1\r\nHost: evil.example\r\n\r\n")

    assert answer.startswith(b"HTTP/1.1 403")
    assert b"HostRefused" in answer


def test_a_request_without_a_host_name_is_refused(served: Served) -> None:
    assert _raw(served, b"GET /healthz HTTP/1.0\r\n\r\n").split()[1] in {b"400", b"403"}


def test_a_body_longer_than_its_content_length_is_cut_off(served: Served, admin: httpx2.Client) -> None:
    token = served.services.keys.local_token.encode()
    head = (
        b"POST /api/v1/keys HTTP/1.1\r\nHost: localhost\r\nX-API-Key: "
        + token
        + b"\r\nContent-Type: application/json\r\n"
    )
    keys = len(admin.get("/keys").json()["items"])

    answer = _raw(served, head + b'Content-Length: 2\r\n\r\n{}{"name": "a", "role": "admin"}')

    assert answer.split()[1] in {b"400", b"422"}
    assert len(admin.get("/keys").json()["items"]) == keys


def test_slow_logins_of_strangers_take_no_slots_of_other_callers(served: Served, admin: httpx2.Client) -> None:
    address = urlsplit(served.url)
    head = (
        b"POST /api/v1/session HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
        b"Content-Length: 100\r\n\r\n"
    )
    with ExitStack() as stack:
        slow = [
            stack.enter_context(socket.create_connection((address.hostname, address.port), timeout=20))
            for _ in range(served.services.settings.requests + 10)
        ]
        for connection in slow:
            connection.sendall(head)
        answers = {connection.recv(65_536).split()[1] for connection in slow[20:]}
        assert admin.get("/session").status_code == 200

    assert answers <= {b"503", b"408"}
    assert b"503" in answers


def test_a_login_body_longer_than_any_key_is_refused(served: Served) -> None:
    with httpx2.Client(base_url=f"{served.url}/api/v1") as client:
        assert client.post("/session", json={"key": "x" * 5000}).status_code == 413


def test_health_and_cycle_free_requests_are_answered_while_many_requests_wait_for_the_cycle(
    served: Served, admin: httpx2.Client
) -> None:
    held, go_on = threading.Event(), threading.Event()
    served.services.station.control.soon(lambda _: (held.set(), go_on.wait(20)))
    assert held.wait(20)
    try:
        with ThreadPoolExecutor(60) as pool:
            waiting = [pool.submit(admin.get, "/managers") for _ in range(60)]
            while sum(one.done() for one in waiting) < 20:  # so many at least have no place
                threading.Event().wait(0.01)
            health = httpx2.get(f"{served.url}/healthz")
            keys = admin.get("/keys")
            unanswered = not all(one.done() for one in waiting)
            go_on.set()
            statuses = {one.result().status_code for one in waiting}
    finally:
        go_on.set()

    assert (health.status_code, keys.status_code, unanswered) == (200, 200, True)
    assert statuses == {200, 503}


def test_two_keys_with_the_same_name_do_not_share_locks(admin: httpx2.Client, served: Served) -> None:
    made = [admin.post("/keys", json={"name": "anna", "role": "engineer"}).json()["secret"] for _ in range(2)]
    with ExitStack() as stack:
        one, other = [
            stack.enter_context(httpx2.Client(base_url=f"{served.url}/api/v1", headers={"X-API-Key": secret}))
            for secret in made
        ]
        (lock,) = one.post("/locks", json={"elements": ["kit_1"], "seconds": 60}).json()["items"]
        refused = other.patch("/elements/kit_1", json={"label": "x"}, headers={"If-Match": "*"})
        other.delete("/locks", params={"owner": "anna"})
        kept = [lock["owner"] for lock in one.get("/locks").json()["items"]]
        written = one.patch("/elements/kit_1", json={"label": "kit_1"}, headers={"If-Match": "*"})
        admin.delete("/locks", params={"owner": "anna"})

    assert lock["owner"] == "anna"
    assert (refused.status_code, written.status_code) == (423, 200)
    assert refused.json()["locks"][0]["owner"] == "anna"
    assert kept == ["anna"]
    assert admin.get("/locks").json()["items"] == []


def test_if_match_with_two_versions_is_refused(admin: httpx2.Client) -> None:
    answer = admin.post("/jobs/nothing/start", headers={"If-Match": '"1", "7"'})

    assert (answer.status_code, answer.json()["code"]) == (400, "InvalidRequest")
    assert admin.post("/jobs/nothing/start", headers={"If-Match": '"1"'}).status_code == 404


def test_a_body_declared_too_long_is_refused_without_being_read(served: Served) -> None:
    token = served.services.keys.local_token.encode()
    head = (
        b"POST /api/v1/keys HTTP/1.1\r\nHost: localhost\r\nX-API-Key: "
        + token
        + b"\r\nContent-Type: application/json\r\n"
    )

    answer = _raw(served, head + b"Content-Length: 99999999999999999999999\r\n\r\n")

    assert answer.split()[1] in {b"400", b"413"}


def test_a_stream_without_a_key_is_refused(stranger: httpx2.Client) -> None:
    assert stranger.get("/events", headers={"Accept": "text/event-stream"}).status_code == 401


def test_a_websocket_is_refused(served: Served) -> None:
    handshake = (
        b"GET /api/v1/events HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
    )

    assert _raw(served, handshake).split()[1] in {b"401", b"403"}


def test_without_keys_local_programs_have_access_and_foreign_pages_do_not(tmp_path: Path) -> None:
    with serving("kitting", tmp_path / "data") as open_, httpx2.Client(base_url=f"{open_.url}/api/v1") as client:
        me = client.get("/session", headers={"X-Skiros-User": "anna"}).json()
        page = {"Origin": "https://evil.example"}
        refused = client.post("/keys", json={"name": "a", "role": "admin"}, headers=page)
        form = client.post(
            "/keys", content=json.dumps({"name": "a", "role": "admin"}), headers={"Content-Type": "text/plain"}
        )
        wrong = client.get("/session", headers={"X-API-Key": "wrong"})
        key = client.post("/keys", json={"name": "a", "role": "admin"}).json()
        locked = client.get("/session")
        client.delete(f"/keys/{key['key']['id']}", headers={"X-API-Key": key["secret"]})
        still_locked = client.get("/keys")
        again = client.get("/keys", headers={"X-API-Key": open_.services.keys.local_token})

    assert (me["name"], me["role"], me["keys_needed"]) == ("anna", "admin", False)
    assert (refused.status_code, form.status_code, wrong.status_code, locked.status_code) == (403, 415, 401, 401)
    assert (still_locked.status_code, again.status_code) == (401, 200)

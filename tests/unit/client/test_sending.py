"""Both clients send again what got lost, over real connections that break."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import pytest

from skiros_py.client import AsyncClient, Client, ProblemError, Unreachable
from skiros_py.client.request import Call

READ = Call("GET", "/jobs", Any)
ORDER = Call("POST", "/jobs", Any, json={"goal": "x"})
ONCE = Call("POST", "/jog", Any, repeatable=False)


class Unreliable(ThreadingHTTPServer):
    """Cuts, or refuses, the first requests that come, and answers the next."""

    def __init__(self, cuts: int = 0, refusals: int = 0) -> None:
        self.cuts, self.refusals = cuts, refusals
        self.seen: list[dict[str, str]] = []
        super().__init__(("127.0.0.1", 0), _Handler)

    def handle_error(self, request, client_address) -> None:
        """What a cut connection leads to is no news."""


class _Handler(BaseHTTPRequestHandler):
    server: Unreliable

    def do_GET(self) -> None:
        self.server.seen.append(dict(self.headers))
        self.rfile.read(int(self.headers.get("Content-Length", 0)))
        seen = len(self.server.seen)
        if seen <= self.server.cuts:
            self.connection.close()
            return
        refused = seen <= self.server.cuts + self.server.refusals
        body = b'{"title": "Busy", "status": 503, "detail": "later"}' if refused else b'{"fine": true}'
        self.send_response(503 if refused else 200)
        if refused:
            self.send_header("Retry-After", "0")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    do_POST = do_GET  # noqa: N815 - the name that http.server looks for

    def log_message(self, *arguments: object) -> None:
        """It tells nobody."""


@contextmanager
def unreliable(**faults: int) -> Iterator[tuple[str, Unreliable]]:
    with Unreliable(**faults) as server:
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_address[1]}", server
        finally:
            server.shutdown()
            thread.join()


def send(url: str, call: Call, *, later: bool, key: str | None = None, tries: int = 4) -> object:
    if not later:
        with Client(url, key, tries=tries) as client:
            return client.send(call)

    async def run() -> object:
        async with AsyncClient(url, key, tries=tries) as client:
            return await client.send(call)

    return asyncio.run(run())


both = pytest.mark.parametrize("later", [False, True], ids=["blocking", "asynchronous"])


@both
def test_a_lost_request_is_sent_again(later: bool) -> None:
    with unreliable(cuts=2) as (url, server):
        assert send(url, READ, later=later) == {"fine": True}
    assert len(server.seen) == 3


@both
def test_all_tries_of_an_order_have_the_same_idempotency_key(later: bool) -> None:
    with unreliable(cuts=1, refusals=1) as (url, server):
        send(url, ORDER, later=later)
        send(url, ORDER, later=later)
    keys = [headers["Idempotency-Key"] for headers in server.seen]
    assert keys[0] == keys[1] == keys[2] != keys[3]


@both
def test_a_request_that_must_not_be_repeated_is_sent_once(later: bool) -> None:
    with unreliable(cuts=1) as (url, server), pytest.raises(Unreachable):
        send(url, ONCE, later=later)
    assert len(server.seen) == 1


@both
def test_after_the_last_try_the_message_of_the_server_is_raised(later: bool) -> None:
    with unreliable(refusals=9) as (url, server), pytest.raises(ProblemError, match="later"):
        send(url, READ, later=later, tries=3)
    assert len(server.seen) == 3


@both
def test_the_key_is_sent_in_a_header(later: bool) -> None:
    with unreliable() as (url, server):
        send(url, READ, later=later, key="sk_a_b")
    assert server.seen[0]["Authorization"] == "Bearer sk_a_b"


@both
def test_an_unreachable_server_is_reported_with_its_address(later: bool) -> None:
    with unreliable() as (url, _):
        pass
    with pytest.raises(Unreachable, match=url):
        send(url, READ, later=later, tries=2)

"""The gate: every request passes it and is either assigned a caller or answered with the reason for its refusal."""

from __future__ import annotations

import asyncio
import logging
import re
import secrets
import time
from collections.abc import Iterable
from contextlib import ExitStack
from typing import Any
from urllib.parse import unquote

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import Request
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from skiros_py.server.access.bodies import read_body, replayed
from skiros_py.server.access.keys import without_keys
from skiros_py.server.access.limiters import Rates, Slots, network_of
from skiros_py.server.access.origins import SAFE, OriginPolicy
from skiros_py.server.access.roles import Caller, Role
from skiros_py.server.monitoring import request_id
from skiros_py.server.pages import is_page
from skiros_py.server.problems import Problem, problem_response
from skiros_py.server.services import Services
from skiros_py.station.jobs.intake import MOST_WAITING

_log = logging.getLogger(__name__)

_API = "/api/v1"
_HEALTH = frozenset((method, path) for method in ("GET", "HEAD") for path in ("/healthz", "/readyz"))
_LOGIN = ("POST", f"{_API}/session")
OPEN = _HEALTH | {_LOGIN}
"""Methods and paths that need no key."""
_STOP = ("POST", f"{_API}/stop")
"""The request to stop: it always passes, regardless of the load; so do requests for the server's health."""
_ORDER = re.compile(rf"POST {_API}/jobs|PUT {_API}/jobs/[^/]+")
_LONGEST_LOGIN = 4 << 10
_LOGINS = 50
_LOGINS_OF_ONE = 10
"""Maximum number of concurrent logins, in total and from one network."""
_PATIENCE = 30.0
_PATIENCE_WITH_ORDERS = 5.0
_PATIENCE_WITH_STRANGERS = 2.0
"""Maximum time until a body has arrived [s]; while an order waits for it, it may keep others away."""
_NOBODY = Caller("", Role.VIEWER)

_LONGEST_URL = 8 << 10
_LONGEST_HEADERS = 32 << 10
_REQUEST_ID = re.compile(r"[A-Za-z0-9._-]{1,64}")
_KEY_IN_URL = re.compile(rb"(?:^|&)(?:x-)?(?:api[_-]?key|access_token|authorization)=", re.IGNORECASE)
_HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store",
}
"""Headers of answers for browsers, unless the route sets others."""


class Gate:
    """ASGI middleware that refuses requests without permission.

    Args:
        app: The application behind the gate.
        services: The server that it guards; some of its services exist only after it was started.
        pages: Application that serves the web pages, which contain no data and need no key; None for none.
    """

    def __init__(self, app: ASGIApp, services: Services, pages: ASGIApp | None = None) -> None:
        self._app = app
        self._pages = pages
        self._services = services
        self._origins = OriginPolicy(services.settings)
        self._rates = Rates(services.settings.rate, 1.0)
        self._requests = Slots("requests", services.settings.requests, services.settings.requests)
        self._logins = Slots("logins", _LOGINS, _LOGINS_OF_ONE)
        self._orders = Slots("orders", MOST_WAITING, MOST_WAITING, refusal=(429, "UnableToAcceptJobOrder"))
        self._turns = asyncio.Lock()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answers a request, or passes it on."""
        if scope["type"] == "websocket":  # there are no WebSocket routes, and none must get past the gate
            await send({"type": "websocket.close", "code": 1008})
        elif scope["type"] != "http":
            await self._app(scope, receive, send)
        else:
            await self._answer(scope, receive, send)

    async def _answer(self, scope: Scope, receive: Receive, send: Send) -> None:
        headers = Headers(scope=scope)
        request = Request(scope)
        request.state.id = _request_id(headers)
        request_id.set(request.state.id)
        request.state.caller = _NOBODY
        answer = _Answer(send, request, self._origins.answer(headers), self._services)
        begun = time.perf_counter()
        try:
            await self._pass(request, headers, receive, answer)
        except Problem as problem:
            await problem_response(request, problem)(scope, receive, answer)
        except Exception as error:
            if answer.revoked:
                return
            _log.exception("request %s broke: %s", request.state.id, error)
            if answer.status:  # the answer has begun: it can only be cut off
                raise
            await problem_response(request, _broken(request.state.id))(scope, receive, answer)
        finally:
            self._keep(request, answer.status)
            if not answer.stream:  # a stream lasts as long as the client listens
                seconds = time.perf_counter() - begun
                self._services.metrics.took(request, answer.status or 500, seconds)

    async def _pass(self, request: Request, headers: Headers, receive: Receive, answer: _Answer) -> None:
        scope, what = request.scope, (request.method, request.scope["path"])
        _check_size(scope)
        self._origins.check_host(headers)
        if request.method == "OPTIONS" and "access-control-request-method" in headers:
            await Response(status_code=204, headers=self._origins.preflight(headers))(scope, receive, answer)
            return
        self._origins.check_origin(request.method, scope["scheme"], headers)
        _check_url(scope)
        if self._pages is not None and is_page(*what):
            await self._pages(scope, receive, answer)
            return
        if what == _LOGIN:
            with self._logins.take(network_of(_address(scope))):
                body = await read_body(headers, receive, _LONGEST_LOGIN, _PATIENCE_WITH_STRANGERS)
                await self._app(scope, replayed(body, receive), answer)
            return
        if what not in OPEN:
            request.state.caller = self._services.authenticator.caller(headers, _address(scope))
        if what in OPEN or what == _STOP:  # a stop is executed whatever its body is, and before the body has arrived
            await self._app(scope, receive, answer)
            return
        self._check_rate(request.state.caller)
        patience = _PATIENCE
        with ExitStack() as place:
            if _ORDER.fullmatch(" ".join(what)):  # refused at once, before it waits for its turn and its body is read
                place.enter_context(self._orders.take(""))
                request.state.place = place
                patience = _PATIENCE_WITH_ORDERS
            with self._requests.take(""):
                if request.method not in SAFE:
                    body = await read_body(headers, receive, self._services.settings.body, patience)
                    receive = replayed(body, receive)
                await self._turn()
                await self._app(scope, receive, answer)

    async def _turn(self) -> None:
        """Waits for its turn: one request begins in a round of the event loop, so that many do not delay a stop."""
        async with self._turns:
            await asyncio.sleep(0)

    def _check_rate(self, caller: Caller) -> None:
        if not self._rates.take(caller.key or caller.name):
            detail = f"more than {self._services.settings.rate} requests in a second"
            raise Problem(429, "TooManyRequests", detail, headers={"Retry-After": "1"})

    def _keep(self, request: Request, status: int) -> None:
        """Records requests that were to change something, and those refused, in the audit log."""
        caller = request.state.caller
        changes = request.method not in SAFE and caller is not _NOBODY
        if status in _REFUSED or (changes and status >= 400):
            who = caller.key or caller.name or network_of(_address(request.scope))
            self._services.audit.append_refusal(who, _entry(request, status))
        elif changes:
            self._services.audit.append(_entry(request, status))


_REFUSED = frozenset({400, 401, 403, 429})


class _Answer:
    """Sends an answer: adds the common headers, and ends a stream whose reader has lost permission."""

    def __init__(self, send: Send, request: Request, more: dict[str, str], services: Services) -> None:
        self.status = 0
        self.revoked = False
        self.stream = False
        self._send = send
        self._request = request
        self._more = more
        self._services = services

    async def __call__(self, message: Message) -> None:
        if message["type"] == "http.response.start":
            self._begin(message)
        elif self.stream and not self._services.authenticator.recheck(self._request.state.caller):
            self.revoked = True
            await self._send({"type": "http.response.body", "body": b"", "more_body": False})
            raise ConnectionAbortedError("the reader's key was revoked")
        await self._send(message)

    def _begin(self, message: Message) -> None:
        self.status = message["status"]
        message.setdefault("headers", [])
        headers = MutableHeaders(raw=message["headers"])
        headers["X-Request-Id"] = self._request.state.id
        for name, value in _HEADERS.items():
            headers.setdefault(name, value)
        vary = headers.get("Vary")
        headers.update(self._more)
        if vary is not None and "Vary" in self._more:
            headers.add_vary_header(vary)
        message["headers"] = headers.raw
        self.stream = headers.get("content-type", "").startswith("text/event-stream")


def _request_id(headers: Headers) -> str:
    given = headers.get("x-request-id", "")
    return given if _REQUEST_ID.fullmatch(given) and without_keys(given) == given else secrets.token_hex(8)


def _address(scope: Scope) -> str:
    return str((scope.get("client") or ("",))[0])


def _check_size(scope: Scope) -> None:
    if len(scope.get("raw_path", b"")) + len(scope["query_string"]) > _LONGEST_URL:
        raise Problem(414, "AddressTooLong", f"an address may have {_LONGEST_URL} bytes at most")
    raw: Iterable[tuple[bytes, bytes]] = scope["headers"]
    if sum(len(name) + len(value) for name, value in raw) > _LONGEST_HEADERS:
        raise Problem(431, "HeadersTooLong", f"headers may have {_LONGEST_HEADERS} bytes at most")


def _check_url(scope: Scope) -> None:
    query: bytes = scope["query_string"]
    url = scope["path"] + "?" + query.decode("latin-1")
    if _KEY_IN_URL.search(query) or without_keys(url) != url:
        raise Problem(
            400,
            "KeyInAddress",
            "keys do not belong into addresses, which are written down on their way: send them in a header,"
            " 'Authorization: Bearer sk_…', and revoke this one",
        )
    try:
        unquote(scope.get("raw_path", b""), errors="strict")
    except UnicodeDecodeError:  # different addresses would become the same name
        raise Problem(400, "InvalidRequest", "the address is not percent-encoded UTF-8") from None
    if "\0" in url or "%00" in url:
        raise Problem(400, "InvalidRequest", "there is a NUL in the address")


def _broken(request: str) -> Problem:
    return Problem(500, "Fault", f"internal server error; the log of the server has it as request {request}")


def _entry(request: Request, status: int) -> dict[str, Any]:
    scope, caller = request.scope, request.state.caller
    said = getattr(request.state, "audit", {})
    path = scope["path"]
    job = said.get("job") or (str(scope.get("path_params", {}).get("id", "")) if f"{_API}/jobs/" in path else "")
    stranger = caller is _NOBODY
    return {
        "wall": time.time(),
        "caller": caller.name,
        "role": "" if stranger else caller.role.value,
        "key": caller.key,
        "address": _address(scope),
        "method": request.method[:20],
        "path": without_keys(path)[:500],
        "operation": getattr(scope.get("endpoint"), "__name__", ""),
        "status": status,
        "request": request.state.id,
        "job": job[:200],
        "comment": said.get("comment", ""),
    }

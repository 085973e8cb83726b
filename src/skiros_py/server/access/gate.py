"""The gate: every request passes it and is either assigned a caller or answered with the reason of its refusal."""

from __future__ import annotations

import logging
import re
import secrets
import time
from collections.abc import Iterable
from typing import Protocol

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import Request
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from skiros_py.server.access.audit import AuditEntry, AuditLog
from skiros_py.server.access.authenticator import Authenticator
from skiros_py.server.access.bodies import read_body, replayed
from skiros_py.server.access.keys import without_keys
from skiros_py.server.access.limits import Load, Rates, network_of
from skiros_py.server.access.origin_policy import SAFE, OriginPolicy
from skiros_py.server.access.roles import Caller, Role
from skiros_py.server.logs import request_id
from skiros_py.server.pages import is_page
from skiros_py.server.problems import Problem, problem_response
from skiros_py.server.settings import ServerSettings

_log = logging.getLogger(__name__)

_API = "/api/v1"
_HEALTH = frozenset((method, path) for method in ("GET", "HEAD") for path in ("/healthz", "/readyz"))
_LOGIN = ("POST", f"{_API}/session")
OPEN = _HEALTH | {_LOGIN}
"""Methods and paths that need no key."""
_STOP = ("POST", f"{_API}/stop")
"""The request to stop: it always passes, regardless of the load; so do requests for the server's health."""
_LONGEST_LOGIN = 4 << 10
_PATIENCE = 30.0
_PATIENCE_WITH_STRANGERS = 2.0
"""Maximum time until a body has arrived [s]."""
_NOBODY = Caller("", Role.VIEWER)

_LONGEST_URL = 8 << 10
_LONGEST_HEADERS = 32 << 10
_REQUEST_ID = re.compile(r"[A-Za-z0-9._-]{1,64}")
_KEY_IN_URL = re.compile(rb"(?:^|&)(?:x-)?(?:api[_-]?key|access_token|authorization)=", re.IGNORECASE)
_REFUSALS = 30
_REFUSALS_OF_ALL = 300
"""Refusals recorded in the audit log per minute, of one address and of all: refusals must not fill it."""
_HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store",
}
"""Headers of answers for browsers, unless the route sets others."""


class Guarded(Protocol):
    """The parts of the server that the gate needs; some of them exist only after the server was started."""

    @property
    def settings(self) -> ServerSettings:
        """Settings of the server."""
        ...

    @property
    def authenticator(self) -> Authenticator:
        """Identifies the caller of a request."""
        ...

    @property
    def audit(self) -> AuditLog:
        """The log of changes and refusals."""
        ...


class Gate:
    """ASGI middleware that refuses requests without permission.

    Args:
        app: The application behind the gate.
        services: The server that it guards.
        pages: Application that serves the web pages, which contain no data and need no key; None for none.
    """

    def __init__(self, app: ASGIApp, services: Guarded, pages: ASGIApp | None = None) -> None:
        self._app = app
        self._pages = pages
        self._services = services
        self._origins = OriginPolicy(services.settings)
        self._rates = Rates(services.settings.rate, 1.0)
        self._refusals = Rates(_REFUSALS, 60.0)
        self._refusals_of_all = Rates(_REFUSALS_OF_ALL, 60.0)
        self._load = Load(services.settings.requests)

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
            with self._load.stranger(_address(scope)):
                body = await read_body(headers, receive, _LONGEST_LOGIN, _PATIENCE_WITH_STRANGERS)
                await self._app(scope, replayed(body, receive), answer)
            return
        if what not in OPEN:
            request.state.caller = self._services.authenticator.caller(headers, _address(scope))
        if what in OPEN or what == _STOP:  # a stop is executed whatever its body is, and before the body has arrived
            await self._app(scope, receive, answer)
            return
        self._check_rate(request.state.caller)
        with self._load.known():
            if request.method not in SAFE:
                body = await read_body(headers, receive, self._services.settings.body, _PATIENCE)
                receive = replayed(body, receive)
            await self._app(scope, receive, answer)

    def _check_rate(self, caller: Caller) -> None:
        if not self._rates.take(caller.key or caller.name):
            detail = f"more than {self._services.settings.rate} requests in a second"
            raise Problem(429, "TooManyRequests", detail, headers={"Retry-After": "1"})

    def _keep(self, request: Request, status: int) -> None:
        """Records requests that changed something, and those refused, in the audit log."""
        changed = request.method not in SAFE and request.state.caller is not _NOBODY and status != 429
        if changed or (status in _REFUSED and self._may_fill_log(_address(request.scope))):
            self._services.audit.append(_entry(request, status))

    def _may_fill_log(self, address: str) -> bool:
        return self._refusals.take(network_of(address)) and self._refusals_of_all.take("")


_REFUSED = frozenset({400, 401, 403, 429})


class _Answer:
    """Sends an answer: adds the common headers, and ends a stream whose reader has lost permission."""

    def __init__(self, send: Send, request: Request, more: dict[str, str], services: Guarded) -> None:
        self.status = 0
        self.revoked = False
        self._send = send
        self._request = request
        self._more = more
        self._services = services
        self._stream = False

    async def __call__(self, message: Message) -> None:
        if message["type"] == "http.response.start":
            self._begin(message)
        elif self._stream and not self._services.authenticator.still(self._request.state.caller):
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
        for name, value in self._more.items():
            headers[name] = value
        message["headers"] = headers.raw
        self._stream = headers.get("content-type", "").startswith("text/event-stream")


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
    if "\0" in url or "%00" in url:
        raise Problem(400, "InvalidRequest", "there is a NUL in the address")


def _broken(request: str) -> Problem:
    return Problem(500, "Fault", f"something broke inside the server; its log has it as request {request}")


def _entry(request: Request, status: int) -> AuditEntry:
    scope, caller = request.scope, request.state.caller
    said = getattr(request.state, "audit", {})
    path = scope["path"]
    job = said.get("job") or (str(scope.get("path_params", {}).get("id", "")) if f"{_API}/jobs/" in path else "")
    stranger = caller is _NOBODY
    return AuditEntry(
        wall=time.time(),
        caller=caller.name,
        role="" if stranger else caller.role.value,
        key=caller.key,
        address=_address(scope),
        method=request.method[:20],
        path=without_keys(path)[:500],
        operation=getattr(scope.get("endpoint"), "__name__", ""),
        status=status,
        request=request.state.id,
        job=job[:200],
        comment=said.get("comment", ""),
    )

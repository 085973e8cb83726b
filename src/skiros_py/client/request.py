"""Requests: a call as a value, its errors, when it is retried, and its result for both clients."""

from __future__ import annotations

import json
import re
import threading
import uuid
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from types import FunctionType
from typing import Any, Generic, TypeVar
from urllib.parse import quote

import httpx2
from pydantic import ValidationError

from skiros_py.api.server import is_loopback
from skiros_py.api.wire import ProblemDetails, adapter_of
from skiros_py.errors import DeviceError, SkirosError, UsageError

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Call(Generic[T]):
    """One request, and how its response is parsed.

    Attributes:
        method: HTTP method.
        path: Path below ``/api/v1``, already quoted.
        read: What a successful response is: a type that its JSON is validated as, str for its text, bytes for its
            content, None for nothing; or a function that reads it.
        query: Query parameters; None leaves one out.
        json: Body, as plain data; None for none.
        content: Raw body instead of ``json``; the headers give its type.
        headers: Further headers; None leaves one out.
        repeatable: True if repeating the request is safe, so that it may be sent again when the connection breaks.
    """

    method: str
    path: str
    read: Any
    query: Mapping[str, Any] = field(default_factory=dict)
    json: Any = None
    headers: Mapping[str, str | None] = field(default_factory=dict)
    repeatable: bool = True
    content: bytes | None = None


_READERS: dict[Any, Callable[[httpx2.Response], Any]] = {
    None: lambda _response: None,
    str: lambda response: response.text,
    bytes: lambda response: response.content,
}


_PART = re.compile(r"[^/\x00-\x1f\ud800-\udfff]{1,300}")


def path_of(*parts: str | int) -> str:
    """Returns a resource path below ``/api/v1``; each part is quoted.

    Raises:
        UsageError: A part can be no id or name.
    """
    for part in map(str, parts):
        if not _PART.fullmatch(part):
            raise UsageError(f"{part[:80]!r} can be no id: that has 1 to 300 characters, without '/'")
    return "".join(f"/{quote(str(part), safe='')}" for part in parts)


_LONGEST_SHOWN = 200
_LONGEST_NUMBER = 5


class ProblemError(SkirosError):
    """The server refused a request and gave the reason.

    Attributes:
        problem: The problem document.
        retry_after: When to retry [s]; None if not given.
    """

    def __init__(self, problem: ProblemDetails, retry_after: float | None = None) -> None:
        self.problem = problem
        self.retry_after = retry_after
        super().__init__(problem.detail or problem.title)

    @property
    def status(self) -> int:
        """The HTTP status: 404 for not found, 409 for a conflict with the current state, 412 for a stale version, …."""
        return self.problem.status

    @property
    def code(self) -> str:
        """The kind of problem, for programs ("UnknownJobOrderID"); empty if it did not come from a SkiROS server."""
        return self.problem.code

    @property
    def detail(self) -> str:
        """What is wrong with this request, and how to correct it."""
        return self.problem.detail


class Unreachable(DeviceError):
    """The server does not answer; whether a request that was sent took effect is unknown.

    Attributes:
        url: The URL that was tried.
    """

    def __init__(self, url: str, why: str) -> None:
        self.url = url
        super().__init__(
            f"no server answers at {url}: {why}; 'skiros serve SCENE --data DIR' starts one, and prints its address"
        )


class TookTooLong(SkirosError):
    """The awaited condition did not become true in time; it may later."""


def problem_of(response: httpx2.Response) -> ProblemError:
    """Parses the server's refusal; other responses (such as a proxy's) are shown as they are."""
    later = _retry_after(response)
    try:
        problem = ProblemDetails.model_validate_json(response.content)
        return ProblemError(problem.model_copy(update={"status": response.status_code}), later)
    except ValidationError:
        said = " ".join(response.text[:_LONGEST_SHOWN].split())
        title = f"{response.status_code} {response.reason_phrase}".rstrip()
        detail = f"{response.url} answered {title}{f': {said}' if said else ''}"
        return ProblemError(ProblemDetails(title=title, status=response.status_code, detail=detail), later)


def _retry_after(response: httpx2.Response) -> float | None:
    text = response.headers.get("retry-after", "").strip()
    return float(text) if text.isascii() and text.isdecimal() and len(text) <= _LONGEST_NUMBER else None


_FIRST, _LONGEST = 0.1, 5.0
"""First and longest wait between two attempts [s]."""
_APART = 0.1
"""Maximum random time added to each wait [s]: keeps many clients from retrying at the same moment."""
_LONGEST_ASKED = 30.0
"""If the server asks for a longer wait [s], the error is raised to the caller instead."""
_TOO_MANY_REQUESTS, _UNAVAILABLE = 429, 503


def retries(call: Call[Any], tries: int) -> dict[str, Any]:
    """Returns the arguments of ``stamina.retry_context`` for a call; the last attempt raises its error.

    Args:
        call: The call.
        tries: How often it is sent at most.
    """
    waits = {"wait_initial": _FIRST, "wait_max": _LONGEST, "wait_jitter": _APART}
    return {"on": lambda error: wait_after(error, call), "attempts": tries, "timeout": None, **waits}


def wait_after(error: Exception, call: Call[Any]) -> bool | float:
    """Returns whether a call is sent again: True after the usual wait, False for no, a number to wait that long [s].

    Args:
        error: The error of the last attempt.
        call: The call.
    """
    if isinstance(error, ProblemError):
        return _asked_wait(error, call)
    if not isinstance(error, Unreachable):
        return False
    broken = error.__cause__
    # A request that never reached the server had no effect: it may always be sent again.
    never_arrived = isinstance(broken, httpx2.ConnectError | httpx2.ConnectTimeout | httpx2.PoolTimeout)
    return (call.repeatable or never_arrived) and not isinstance(broken, httpx2.UnsupportedProtocol)


def _asked_wait(problem: ProblemError, call: Call[Any]) -> bool | float:
    """Returns the wait the server asks for [s]; False if there is none, or it is too long."""
    refused = problem.status == _TOO_MANY_REQUESTS  # the request had no effect
    if not refused and not (call.repeatable and problem.status == _UNAVAILABLE):
        return False
    seconds = problem.retry_after
    return False if seconds is None or seconds > _LONGEST_ASKED else seconds


_PREFIX = "/api/v1"
_DOTS = {".": "%2E", "..": "%2E%2E"}


def settings_for(url: str, key: str | None, timeout: float | None) -> dict[str, Any]:
    """Returns the settings of an HTTP client for a server.

    Args:
        url: Address of the server.
        key: Key; None if none is needed.
        timeout: How long an answer may take [s]; None for any time.

    Raises:
        UsageError: The URL, the key or the timeout is malformed.
    """
    parsed = _address(url)
    if timeout is not None and not (isinstance(timeout, int | float) and 0.0 < timeout <= threading.TIMEOUT_MAX):
        raise UsageError(f"timeout: a positive time [s], not {timeout!r}")
    if key is not None and (not key.isascii() or not key.isprintable() or " " in key):
        raise UsageError("the key has characters that no key has; give it as 'skiros key create' printed it")
    return {
        "base_url": f"{str(parsed).rstrip('/')}{_PREFIX}",
        "headers": {} if key is None else {"Authorization": f"Bearer {key}"},
        "timeout": timeout,
        # A proxy for internet access must not be used between two programs on one machine.
        "trust_env": not is_loopback(parsed.host),
        **({"verify": False} if parsed.scheme == "http" else {}),  # certificates take 20 ms to load; https only
    }


def _address(url: str) -> httpx2.URL:
    try:
        parsed = httpx2.URL(url)
    except (httpx2.InvalidURL, TypeError) as error:
        raise UsageError(f"'{url}' is no address of a server, as http://127.0.0.1:8000 is: {error}") from None
    if parsed.scheme not in ("http", "https") or not parsed.host or parsed.query or parsed.fragment:
        raise UsageError(f"'{url}' is no address of a server, as http://127.0.0.1:8000 is")
    if parsed.userinfo:
        raise UsageError("a key does not belong into the address, where logs show it: give it apart")
    return parsed


def arguments_of(call: Call[Any]) -> dict[str, Any]:
    """Returns the HTTP client arguments for a call.

    Raises:
        UsageError: The body is not plain data that JSON can carry.
    """
    # "." and ".." are valid ids, but would be resolved as relative paths.
    path = "/".join(_DOTS.get(part, part) for part in call.path.split("/"))
    return {
        "method": call.method,
        "url": path,
        "params": {name: value for name, value in call.query.items() if value is not None},
        "content": call.content if call.json is None else _json(call.json),
        "headers": _headers_of(call),
    }


def _json(data: object) -> bytes:
    try:
        return json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()
    except (TypeError, ValueError) as error:
        raise UsageError(f"a request carries plain data with finite numbers: {error}") from None


def _headers_of(call: Call[Any]) -> dict[str, str]:
    headers = {name: value for name, value in call.headers.items() if value is not None}
    if call.json is not None:
        headers.setdefault("Content-Type", "application/json")
    if call.method == "POST" and call.repeatable:  # one key for all tries: lets the server recognize them
        headers.setdefault("Idempotency-Key", str(uuid.uuid4()))
    return headers


@contextmanager
def reaching(url: str) -> Iterator[None]:
    """Translates connection errors of the HTTP client for the duration of the block.

    Args:
        url: Address of the server.

    Raises:
        Unreachable: The server did not answer.
    """
    try:
        yield
    except httpx2.RequestError as error:
        late = isinstance(error, httpx2.TimeoutException)
        raise Unreachable(url, "it took too long" if late else str(error) or type(error).__name__) from error


def result_of(call: Call[T], response: httpx2.Response) -> T:
    """Returns the result of a call.

    Raises:
        ProblemError: The server refused.
        SkirosError: The response cannot be parsed.
    """
    if not response.is_success:
        raise problem_of(response)
    read = _READERS.get(call.read, call.read)
    try:
        result: T = (
            read(response) if isinstance(read, FunctionType) else adapter_of(read).validate_json(response.content)
        )
        return result
    except ValueError as error:
        raise SkirosError(
            f"this client cannot parse the response of {response.url}; server and client may be of different"
            f" versions: {error}"
        ) from error

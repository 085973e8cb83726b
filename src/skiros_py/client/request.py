"""Turns calls into requests and responses into results, for both clients."""

from __future__ import annotations

import ipaddress
import uuid
from typing import Any, TypeAlias, TypeVar

import httpx2

from skiros_py.client.call import Call
from skiros_py.client.errors import Unreachable, problem_of
from skiros_py.errors import SkirosError, UsageError

T = TypeVar("T")
Outcome: TypeAlias = httpx2.Response | httpx2.TransportError
"""The outcome of sending a request: a response, or a connection error."""

_PREFIX = "/api/v1"
_DOTS = {".": "%2E", "..": "%2E%2E"}


def settings_for(url: str, key: str | None, timeout: float) -> dict[str, Any]:
    """Returns the settings of an HTTP client for a server.

    Args:
        url: Address of the server.
        key: Key; None if none is needed.
        timeout: How long an answer may take [s].

    Raises:
        UsageError: The URL or the key is malformed.
    """
    parsed = _address(url)
    if key is not None and (not key.isascii() or not key.isprintable() or " " in key):
        raise UsageError("the key has characters that no key has; give it as 'skiros key create' printed it")
    return {
        "base_url": f"{str(parsed).rstrip('/')}{_PREFIX}",
        "headers": {} if key is None else {"Authorization": f"Bearer {key}"},
        "timeout": timeout,
        # A proxy for internet access must not be used between two programs on one machine.
        "trust_env": not _is_here(parsed.host),
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


def _is_here(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def arguments_of(call: Call[Any]) -> dict[str, Any]:
    """Returns the HTTP client arguments for a call."""
    # "." and ".." are valid ids, but would be resolved as relative paths.
    path = "/".join(_DOTS.get(part, part) for part in call.path.split("/"))
    return {
        "method": call.method,
        "url": path,
        "params": {name: value for name, value in call.query.items() if value is not None},
        "json": call.json,
        "content": call.content,
        "headers": _headers_of(call),
    }


def _headers_of(call: Call[Any]) -> dict[str, str]:
    headers = {name: value for name, value in call.headers.items() if value is not None}
    if call.method == "POST" and call.repeatable:  # one key for all tries: lets the server recognize them
        headers.setdefault("Idempotency-Key", str(uuid.uuid4()))
    return headers


def result_of(call: Call[T], outcome: Outcome, url: str) -> T:
    """Returns the result of a call.

    Raises:
        ProblemError: The server refused.
        Unreachable: The server did not answer.
        SkirosError: The answer cannot be understood.
    """
    if isinstance(outcome, httpx2.TransportError):
        raise Unreachable(url, _why(outcome)) from outcome
    if not outcome.is_success:
        raise problem_of(outcome)
    try:
        return call.result(outcome)
    except ValueError as error:
        raise SkirosError(
            f"{outcome.url} answered what this client does not understand; server and client may be of different"
            f" versions: {error}"
        ) from error


def _why(error: httpx2.TransportError) -> str:
    if isinstance(error, httpx2.TimeoutException):
        return "it took too long"
    return str(error) or type(error).__name__

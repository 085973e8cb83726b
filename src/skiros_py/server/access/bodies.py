"""Bodies of requests: read within a time and a length, and checked for what the platform cannot handle."""

from __future__ import annotations

import asyncio
import json
import re
from typing import Any

from starlette.datastructures import Headers
from starlette.types import Message, Receive

from skiros_py.files import RDF_TYPES
from skiros_py.server.problems import Problem

_DEEPEST = 64
"""Maximum nesting depth of lists and objects."""
_LARGEST = 2**63
"""Integers must be smaller: databases and other languages do not support larger ones."""
_FORMS = frozenset({"", "text/plain", "application/x-www-form-urlencoded", "multipart/form-data"})
"""Content types that any web page may have a browser send to any server without a preflight request."""
_OUTSIDE_TEXTS = re.compile(rb'"[^"\\]*(?:\\.[^"\\]*)*"?|[^\[\]{}"]+', re.DOTALL)
_SUSPICIOUS = re.compile(rb"NaN|Infinity|\xed[\xa0-\xbf]|\\u(?:0000|[dD][89a-fA-F])|[eE]\+?\d{3}|\d{19}")
_NOT_TEXT = re.compile("[\0\ud800-\udfff]")


async def read_body(headers: Headers, receive: Receive, longest: int, seconds: float) -> bytes:
    """Reads and checks the body of a request that can change something.

    Args:
        headers: The request's headers.
        receive: Yields the body in chunks.
        longest: Maximum length [bytes].
        seconds: Maximum time until it has arrived [s].

    Raises:
        Problem: It is too long (413), too slow (408), of a content type of forms (415), or invalid JSON (400).
    """
    announced = headers.get("content-length", "0")
    if not announced.isdecimal() or len(announced) > 18 or int(announced) > longest:
        raise _too_long(longest)
    try:
        async with asyncio.timeout(seconds):
            body = await _whole(receive, longest)
    except TimeoutError:
        raise Problem(408, "BodyTooSlow", f"the body did not arrive within {seconds:g} s") from None
    if body:
        _check(headers.get("content-type", ""), body)
    return body


def replayed(body: bytes, receive: Receive) -> Receive:
    """Returns a receive function that yields a body already read, followed by the next messages."""
    given = False

    async def again() -> Message:
        nonlocal given
        if given:
            return await receive()
        given = True
        return {"type": "http.request", "body": body, "more_body": False}

    return again


async def _whole(receive: Receive, longest: int) -> bytes:
    body = bytearray()
    while True:
        message = await receive()
        if message["type"] == "http.disconnect":
            raise Problem(400, "InvalidRequest", "the connection was lost before the body was complete")
        body += message.get("body", b"")
        if len(body) > longest:
            raise _too_long(longest)
        if not message.get("more_body", False):
            return bytes(body)


def _too_long(longest: int) -> Problem:
    return Problem(413, "BodyTooLong", f"a body may have {longest} bytes at most", headers={"Connection": "close"})


def _check(content_type: str, body: bytes) -> None:
    kind = content_type.partition(";")[0].strip().lower()
    if kind in _FORMS:
        triples = ", ".join(dict.fromkeys(RDF_TYPES.values()))
        said = f"send JSON as application/json, or triples, where they are taken, as {triples}; not {kind or 'nothing'}"
        raise Problem(415, "UnsupportedMediaType", said)
    if kind == "application/json" or kind.endswith("+json"):
        check_json(body)


def check_json(body: bytes) -> None:
    """Checks that a JSON text contains nothing that the platform cannot handle.

    These are excessive nesting, numbers that are not finite, and characters that cannot be encoded (NUL, unpaired
    surrogates). Whether the text is JSON at all is left to its parser.

    Raises:
        Problem: It contains such a thing.
    """
    if b"\0" in body:
        raise _bad("JSON is written in UTF-8, and holds no NUL")
    if body.count(b"[") + body.count(b"{") > _DEEPEST and _too_deep(body):
        raise _bad(f"lists and objects are nested deeper than {_DEEPEST}, or not closed")
    if _SUSPICIOUS.search(body):
        try:
            value = json.loads(body, parse_constant=_constant, parse_float=_float, parse_int=_int)
        except ValueError:
            return  # not JSON: the parser reports that, with line and column
        _check_texts(value)


def _too_deep(body: bytes) -> bool:
    """Returns whether a text is nested too deep or has unclosed brackets; runs in C, not bracket by bracket."""
    brackets = _OUTSIDE_TEXTS.sub(b"", body).translate(_SAME_BRACKETS)
    for _ in range(_DEEPEST):
        shorter = brackets.replace(b"[]", b"")  # the innermost ones
        if len(shorter) == len(brackets):
            break
        brackets = shorter
    return b"[" in brackets


_SAME_BRACKETS = bytes.maketrans(b"{}", b"[]")


def _constant(text: str) -> float:
    raise _bad(f"{text} is no number")


def _float(text: str) -> float:
    value = float(text)
    if value in (float("inf"), float("-inf")):
        raise _bad(f"{text[:30]} is too large a number")
    return value


def _int(text: str) -> int:
    if len(text) > 20 or not -_LARGEST <= int(text) < _LARGEST:
        raise _bad(f"{text[:30]} is too large a number")
    return int(text)


def _check_texts(value: Any) -> None:
    # The depth was limited above, so recursion is safe.
    if isinstance(value, str):
        if _NOT_TEXT.search(value):
            raise _bad(f"{value[:60]!a} holds a character that cannot be written down")
    elif isinstance(value, list):
        for item in value:
            _check_texts(item)
    elif isinstance(value, dict):
        for name, item in value.items():
            _check_texts(name)
            _check_texts(item)


def _bad(what: str) -> Problem:
    return Problem(400, "InvalidRequest", f"the body cannot be taken: {what}")

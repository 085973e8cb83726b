"""Versions of resources: ETag and If-Match, so that no change is overwritten unseen."""

from __future__ import annotations

import re
from typing import Annotated, Any, Protocol, TypeVar

from fastapi import Depends, Header, Response

from skiros_py.api.problem import ProblemDetails
from skiros_py.server.problems import Problem
from skiros_py.station.requests import Seen


class _Versioned(Protocol):
    @property
    def version(self) -> int: ...


V = TypeVar("V", bound=_Versioned)

_TAG = re.compile(r'(?:W/)?"(\d{1,18})"')


async def _if_match(
    if_match: Annotated[
        str | None,
        Header(description="Version that was seen: the ETag of an answer; * for whichever it is.", examples=['"17"']),
    ] = None,
) -> Seen | None:
    return None if if_match is None else Seen(expected_version(if_match))


SeenDep = Annotated[Seen | None, Depends(_if_match)]
"""For routes: the version in If-Match; None if there is no such header."""

NEEDS_VERSION: dict[int | str, dict[str, Any]] = {
    428: {
        "model": ProblemDetails,
        "description": "If-Match is missing: say which version you have seen.",
        "content": {"application/problem+json": {}},
    }
}
"""Answers of a route that requires a version for each write; for ``responses=``."""


def tagged(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """Returns the documentation of answers that carry an ETag; for ``responses=``.

    Args:
        statuses: Status codes of these answers; 200 if omitted.
    """
    header = {"description": "The present version, for If-Match.", "schema": {"type": "string", "examples": ['"17"']}}
    return {status: {"headers": {"ETag": header}} for status in statuses or (200,)}


def etag(version: int) -> str:
    """Returns the ETag of a version."""
    return f'"{version}"'


def with_etag(found: V, response: Response) -> V:
    """Returns the resource and puts its version into the headers of the answer."""
    response.headers["ETag"] = etag(found.version)
    return found


def expected_version(given: str | None) -> int | None:
    """Returns the version in If-Match; None if there is no such header, or it accepts any version ("*").

    Args:
        given: Value of If-Match.

    Raises:
        Problem: The header is not an ETag of this server (412: no such version existed), or has several (400).
    """
    if given is None or given.strip() == "*":
        return None
    tags = {tag.strip() for tag in given.split(",")}
    if len(tags) > 1:
        raise Problem(400, "InvalidRequest", f"If-Match: name the one version that you have seen, not {given[:100]}")
    match = _TAG.fullmatch(tags.pop())
    if match is None:
        raise Problem(412, "StaleVersion", f'If-Match takes an ETag of this API such as "17", or *, not {given[:100]}')
    return int(match[1])

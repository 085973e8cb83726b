"""Versions of what can be changed: ETag and If-Match, so that nobody overwrites what they have not seen."""

from __future__ import annotations

import re

from fastapi import Request

from skiros_py.server.problems import Problem

__all__ = ["etag", "expected_version", "require_version"]

_TAG = re.compile(r'(?:W/)?"(\d{1,18})"')


def etag(version: int) -> str:
    """Returns the ETag of a version."""
    return f'"{version}"'


def expected_version(request: Request) -> int | None:
    """Returns the version that If-Match names; None where there is no such header, or it takes any version ("*").

    Raises:
        Problem: The header is no ETag of ours (412: that version never was), or names several (400).
    """
    given = request.headers.get("if-match")
    if given is None or given.strip() == "*":
        return None
    tags = {tag.strip() for tag in given.split(",")}
    if len(tags) > 1:
        raise Problem(400, "InvalidRequest", f"If-Match: name the one version that you have seen, not {given[:100]}")
    match = _TAG.fullmatch(tags.pop())
    if match is None:
        raise Problem(412, "StaleVersion", f'If-Match takes an ETag of this API such as "17", or *, not {given[:100]}')
    return int(match[1])


def require_version(request: Request, now: int) -> None:
    """Sees that the caller has seen the present version.

    Args:
        request: The request.
        now: The present version.

    Raises:
        Problem: If-Match is missing (428), or names another version (412).
    """
    if "if-match" not in request.headers:
        raise Problem(428, "VersionMissing", f'say which version you have seen: If-Match: "{now}" is the present one')
    seen = expected_version(request)
    if seen is not None and seen != now:
        raise Problem(
            412,
            "StaleVersion",
            f"version {seen} is not the present one: it was changed since; look again",
            headers={"ETag": etag(now)},
        )

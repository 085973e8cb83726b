"""Problem documents: every failed request is answered in the same form (RFC 9457); and versions of resources (ETag)."""

from __future__ import annotations

import errno
import json
import logging
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from datetime import UTC, datetime, timedelta
from typing import Annotated, Any

from fastapi import APIRouter, Depends, FastAPI, Header, Request, Response
from fastapi.exceptions import RequestValidationError
from fastapi.routing import iter_route_contexts
from starlette.exceptions import HTTPException

from skiros_py import errors
from skiros_py.api.wire import ProblemDetails, fault_limit, fault_words
from skiros_py.messages import cut, joined, messages_in
from skiros_py.station.requests import Seen

_log = logging.getLogger(__name__)

PREFIX = "/api/v1"
"""Path prefix of the API."""

_TYPE = "urn:skiros:problem:"
"""Problem types are names, not addresses: they must not look like something to fetch."""


class Problem(Exception):
    """A request cannot be fulfilled; raised by routes and answered as a problem document.

    Args:
        status: HTTP status.
        code: The kind of problem, for programs.
        detail: Describes the fault, and what would be correct.
        headers: Further headers of the answer.
        extra: Further members of the problem document.
    """

    def __init__(
        self, status: int, code: str, detail: str, *, headers: Mapping[str, str] | None = None, **extra: Any
    ) -> None:
        super().__init__(detail)
        self.status = status
        self.code = code
        self.detail = detail
        self.headers = dict(headers or {})
        self.extra = extra


_REFUSED = {
    "Forgotten": 410,
    "JobOrderRemoved": 410,
    "NoModel": 404,
    "NoReplay": 404,
    "LearnedBroken": 422,
    "NotFound": 404,
    "NotSaved": 507,
    "SceneUnreadable": 422,
    "UnsupportedMediaType": 415,
    "VersionMissing": 428,
}
"""HTTP status of a refusal by its code; 409 for all others."""
_NAMES = {"SceneUnreadable": "SceneBroken"}
"""Codes of refusals that are answered with the same code but another status."""


_KINDS: tuple[tuple[type[errors.SkirosError], int, str], ...] = (
    (errors.NotFound, 404, ""),
    (errors.WrongState, 409, "WrongState"),
    (errors.StaleVersion, 412, "StaleVersion"),
    (errors.Locked, 423, "Locked"),
    (errors.WorldError, 422, "WorldRefused"),
    (errors.GoalSyntaxError, 422, "GoalSyntax"),
    (errors.UnknownName, 422, "UnknownName"),
    (errors.UsageError, 422, "InvalidRequest"),
    (errors.Busy, 503, "Busy"),
    (errors.SkirosError, 500, "Fault"),
)
"""Status and code of each fault of the platform; the first match counts."""
_JOB_KINDS: tuple[tuple[type[errors.SkirosError], int, str], ...] = (
    (errors.KeyReused, 422, "IdempotencyKeyReused"),
    (errors.Removed, 410, "JobOrderRemoved"),
    (errors.WrongState, 409, "InvalidJobOrderStatus"),
    (errors.Overloaded, 429, "UnableToAcceptJobOrder"),
    (errors.Busy, 503, "UnableToAcceptJobOrder"),
    *_KINDS,
)
"""The same for orders and jobs, with the codes of the standard (OPC 10031-4 v2.00, annex B.2)."""
_JOB_TOPICS = ("jobs", "goals", "previews")
"""First part of the paths of routes for orders and jobs."""


def _answer_fault(request: Request, error: Exception) -> Response:
    assert isinstance(error, errors.SkirosError)
    problem = _of(error, _JOB_KINDS if _is_about_jobs(request) else _KINDS)
    if problem.status == 500 or isinstance(error, errors.FileError):
        trace = None if isinstance(error, errors.DiskFault) else error
        _log.error("request %s: %s", getattr(request.state, "id", ""), error, exc_info=trace)
    return problem_response(request, problem)


def _is_about_jobs(request: Request) -> bool:
    return request.url.path.removeprefix(PREFIX).lstrip("/").partition("/")[0] in _JOB_TOPICS


def _of(error: errors.SkirosError, kinds: Sequence[tuple[type[errors.SkirosError], int, str]]) -> Problem:
    if isinstance(error, errors.FileError):
        return _of_file(error)
    if isinstance(error, errors.Refused):
        refused = Problem(_REFUSED.get(error.code, 409), _NAMES.get(error.code, error.code), str(error))
        refused.extra.update(error.data)
        return refused
    status, code = next((status, code) for kind, status, code in kinds if isinstance(error, kind))
    extra: dict[str, Any] = {}
    if isinstance(error, errors.NotFound):
        code = error.code
    elif isinstance(error, errors.UnknownName) and error.kind == "job" and kinds is _JOB_KINDS:
        status, code = 404, "UnknownJobOrderID"
    if isinstance(error, errors.UnknownName):
        extra = {"known": list(error.known[:20]), "nearest": error.nearest}
    if isinstance(error, errors.GoalSyntaxError):
        extra = {"column": error.column}
    if isinstance(error, errors.DocumentError):
        extra = {"faults": [asdict(fault) for fault in error.faults[:100]]}
    if isinstance(error, errors.Locked):
        extra = {"locks": [_lock(*lock) for lock in error.locks]}
    if isinstance(error, errors.StaleVersion) and error.present is not None:
        return Problem(status, code, str(error), headers={"ETag": f'"{error.present}"'})
    headers = {"Retry-After": f"{max(1, round(error.retry_after))}"} if isinstance(error, errors.Busy) else {}
    return Problem(status, code, str(error), headers=headers, **extra)


def _lock(element: str, owner: str, seconds: float) -> dict[str, str]:
    until = datetime.now(UTC) + timedelta(seconds=max(0.0, seconds))
    return {"element": element, "owner": owner, "until": until.isoformat()}


def _of_file(error: errors.FileError) -> Problem:
    """Handles faults in files of the server itself; faults in a caller's file are reported where it is read."""
    detail = f"{error.path.name}: {error.reason.replace(str(error.path.parent), '…')}"
    cause = error.__cause__
    full = getattr(cause, "sqlite_errorname", "").startswith("SQLITE_FULL")
    if full or getattr(cause, "errno", None) in (errno.ENOSPC, errno.EDQUOT):
        return Problem(507, "DiskFull", detail)
    return Problem(503, "FileFault", detail, headers={"Retry-After": "5"})


def problem_response(request: Request, problem: Problem) -> Response:
    """Returns the answer to a request that cannot be fulfilled."""
    details = ProblemDetails(
        type=_TYPE + problem.code,
        title=_title(problem.code),
        status=problem.status,
        detail=problem.detail,
        code=problem.code,
        instance=getattr(request.state, "id", ""),
        **{"return_status": _return_status(request, problem), **problem.extra},
        texts=messages_in((problem.detail, problem.extra)),
    )
    # In ASCII, since a refused text may contain characters that cannot be encoded in UTF-8.
    content = json.dumps(details.model_dump(exclude_none=True), default=str)
    return Response(content, problem.status, problem.headers, media_type="application/problem+json")


_BITS = {
    "UnknownJobOrderID": 1,
    "InvalidJobOrderStatus": 3,
    "UnableToAcceptJobOrder": 4,
    "JobOrderRemoved": 4,
    "Busy": 4,
}
_INVALID_REQUEST = 32


def _return_status(request: Request, problem: Problem) -> int | None:
    """Returns the ISA-95 return status of a problem with jobs (OPC 10031-4 v2.00, annex B.2); None for others."""
    if not _is_about_jobs(request) or (problem.status >= 500 and problem.code not in _BITS):
        return None
    return 1 << _BITS.get(problem.code, _INVALID_REQUEST)


def _title(code: str) -> str:
    """Returns a code as words: "UnknownJobOrderID" becomes "Unknown job order ID"."""
    words = "".join(f" {c}" if c.isupper() and code[max(0, i - 1)].islower() else c for i, c in enumerate(code))
    first, *rest = words.split() or ["Problem"]
    return " ".join([first, *(word if word.isupper() else word.lower() for word in rest)])


def add_problem_handlers(app: FastAPI) -> None:
    """Installs handlers that answer every exception with a problem document."""

    def answering(make: Callable[[Any], Problem]) -> Callable[[Request, Exception], Response]:
        return lambda request, error: problem_response(request, make(error))

    app.add_exception_handler(Problem, answering(lambda error: error))
    app.add_exception_handler(errors.SkirosError, _answer_fault)
    app.add_exception_handler(HTTPException, _answer_http)
    app.add_exception_handler(RequestValidationError, answering(_of_validation))


_HTTP = {
    400: "InvalidRequest",
    401: "KeyNeeded",
    404: "NotFound",
    405: "MethodNotAllowed",
    413: "BodyTooLong",
    415: "UnsupportedMediaType",
}


def _answer_http(request: Request, error: Exception) -> Response:
    """Answers a request that no route takes; for a wrong method, with the methods of all routes of that address."""
    assert isinstance(error, HTTPException)
    headers = dict(error.headers or {})
    if error.status_code == 405:
        headers["Allow"] = ", ".join(sorted(_methods(request) | {"OPTIONS"}))
        if request.method == "OPTIONS":
            return Response(status_code=204, headers=headers)
    return problem_response(request, _of_http(error, headers))


def _methods(request: Request) -> set[str]:
    """Returns the methods of all routes of an address."""
    found: set[str] = set()
    for route in iter_route_contexts(request.app.routes):
        pattern = getattr(route, "path_regex", None)
        if pattern is not None and pattern.match(request.url.path):
            found |= route.methods or set()
    return found


def _of_http(error: HTTPException, headers: Mapping[str, str]) -> Problem:
    code = _HTTP.get(error.status_code, "InvalidRequest")
    return Problem(error.status_code, code, str(error.detail), headers=headers)


def _of_validation(error: RequestValidationError) -> Problem:
    fields = [_field(one) for one in error.errors()[:100]]
    detail = joined("; ", (joined(": ", (one["field"], one["message"])) for one in fields[:10]))
    return Problem(422, "InvalidRequest", cut(detail, _LONGEST), errors=fields)


def _field(fault: Mapping[str, Any]) -> dict[str, Any]:
    """Describes the fault of one field; kind and limit allow a page to translate the message."""
    limit = fault_limit(fault)
    field = ".".join(map(str, fault["loc"]))[:200]
    said = {"field": field, "message": cut(fault_words(fault), _LONGEST), "kind": str(fault["type"])}
    return said if limit is None else {**said, "limit": limit}


_LONGEST = 4000
"""Maximum length of messages about wrong fields; names of fields may be as long as the body."""


# By reference: for a model, FastAPI builds a validator per route and status, which took most of the start-up time.
_CONTENT = {"application/problem+json": {"schema": {"$ref": f"#/components/schemas/{ProblemDetails.__name__}"}}}
PROBLEMS: dict[int | str, dict[str, Any]] = {
    status: {"description": words, "content": _CONTENT}
    for status, words in {
        400: "The request cannot be understood.",
        401: "A valid key is needed.",
        403: "The caller's role, host or origin does not allow it.",
        404: "There is no such thing.",
        408: "The body did not arrive in time.",
        409: "It cannot be done in the current state.",
        412: "It was changed since: If-Match names an old version.",
        413: "The body is too long.",
        415: "The body is of another media type.",
        422: "The request is invalid; the text says what would be valid.",
        423: "Another author has locked it.",
        414: "The address is too long.",
        429: "Too many requests; Retry-After says when to retry.",
        503: "Overloaded or not ready; Retry-After says when to retry.",
        507: "The disk is full: nothing was changed.",
    }.items()
}
"""Problem answers common to all routes; for ``responses=``."""


def topic_router(topic: str, path: str = "", responses: dict[int | str, Any] | None = None) -> APIRouter:
    """Returns a router for the routes of a topic.

    Its routes are complete, and shared by all applications: ``include_router`` would make each of them again.

    Args:
        topic: Under which the documentation shows them.
        path: With which their paths begin, after the prefix of the API.
        responses: Answers that all of them document, besides the common problems.
    """
    return APIRouter(
        prefix=PREFIX + path,
        tags=[topic],
        responses=PROBLEMS | (responses or {}),
        generate_unique_id_function=lambda route: route.name,
    )


_TAG = re.compile(r'(?:W/)?"(\d{1,18})"')


async def _if_match(
    if_match: Annotated[
        str | None,
        Header(description="The version that was seen: ETag of a response; * for any.", examples=['"17"']),
    ] = None,
) -> Seen | None:
    return None if if_match is None else Seen(expected_version(if_match))


SeenDep = Annotated[Seen | None, Depends(_if_match)]
"""For routes: the version in If-Match; None if there is no such header."""


def also_refused(status: int, why: str) -> dict[int | str, dict[str, Any]]:
    """Returns the documentation of a refusal by some routes only; for ``responses=``."""
    return {status: {"description": why, "content": _CONTENT}}


NEEDS_VERSION = also_refused(428, "If-Match is missing: it names the version that was seen.")
"""Answers of a route that requires a version for each write; for ``responses=``."""


def tagged(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """Returns the documentation of answers that carry an ETag; for ``responses=``.

    Args:
        statuses: Status codes of these answers; 200 if omitted.
    """
    header = {"description": "The current version, for If-Match.", "schema": {"type": "string", "examples": ['"17"']}}
    return {status: {"headers": {"ETag": header}} for status in statuses or (200,)}


def etag(version: int) -> str:
    """Returns the ETag of a version."""
    return f'"{version}"'


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

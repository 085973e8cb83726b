"""What goes wrong with jobs, in the words and numbers of the standard (OPC 10031-4 v2.00, annex B.2)."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from skiros_py.errors import (
    Busy,
    GoalSyntaxError,
    KeyReused,
    NotFound,
    Removed,
    SkirosError,
    StaleVersion,
    UnknownName,
    UsageError,
    WrongState,
)
from skiros_py.server.problems import Problem

UNKNOWN_ID, INVALID_STATUS, UNABLE_TO_ACCEPT, INVALID_REQUEST = 1 << 1, 1 << 3, 1 << 4, 1 << 32
"""Bits of the return status."""


@contextmanager
def job_faults() -> Iterator[None]:
    """Answers with the codes of the standard what goes wrong with a job, or with its goal."""
    try:
        yield
    except SkirosError as error:
        problem = _problem(error)
        if problem is None:
            raise
        raise problem from None


def _problem(error: SkirosError) -> Problem | None:
    match error:
        case UnknownName(kind="job"):
            return Problem(404, "UnknownJobOrderID", str(error), return_status=UNKNOWN_ID)
        case NotFound():
            return None
        case KeyReused():
            return _invalid("IdempotencyKeyReused", error)
        case Removed():
            return Problem(410, "JobOrderRemoved", str(error), return_status=UNABLE_TO_ACCEPT)
        case WrongState():
            return Problem(409, "InvalidJobOrderStatus", str(error), return_status=INVALID_STATUS)
        case StaleVersion():
            return Problem(412, "StaleVersion", str(error), return_status=INVALID_REQUEST)
        case Busy(retry_after=after):
            headers = {"Retry-After": f"{max(1, round(after))}"}
            return Problem(503, "UnableToAcceptJobOrder", str(error), headers=headers, return_status=UNABLE_TO_ACCEPT)
        case GoalSyntaxError(column=column):
            return _invalid("GoalSyntax", error, column=column)
        case UnknownName(known=known, nearest=nearest):
            return _invalid("UnknownName", error, known=list(known[:20]), nearest=nearest)
        case UsageError():
            return _invalid("InvalidRequest", error)
    return None


def _invalid(code: str, error: SkirosError, **extra: Any) -> Problem:
    return Problem(422, code, str(error), return_status=INVALID_REQUEST, **extra)

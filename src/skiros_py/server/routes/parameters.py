"""Parameters that several routes take."""

from __future__ import annotations

import re
from typing import Annotated, Any

from fastapi import Path, Query

from skiros_py.api.problem import ProblemDetails
from skiros_py.errors import UsageError

Limit = Annotated[int, Query(ge=1, le=1000, description="How many at most.")]
ChangeLimit = Annotated[int, Query(ge=1, le=200, description="How many at most.")]
Cursor = Annotated[str | None, Query(max_length=300, description="Where to read on: `next` of the page before.")]
ElementPath = Annotated[
    str, Path(max_length=300, description="Id of the element.", examples=["starter_1", "learned:taught_grasp_1"])
]
NamePath = Annotated[str, Path(max_length=300, description="A name of the ontology.", examples=["kitting:Starter"])]
WhyQuery = Annotated[str, Query(max_length=1000, description="Why, for people.", examples=["delivered this morning"])]


def also_refused(status: int, why: str) -> dict[int | str, dict[str, Any]]:
    """Documents a refusal that only some routes know; for ``responses=``."""
    return {status: {"model": ProblemDetails, "description": why, "content": {"application/problem+json": {}}}}


_NUMBER = re.compile(r"\d{1,18}", re.ASCII)


def number_cursor(cursor: str | None, first: int = 0) -> int:
    """Reads a cursor that is a number.

    Args:
        cursor: The cursor.
        first: What it is for the first page.

    Raises:
        UsageError: It is none of ours.
    """
    if cursor is None:
        return first
    if not _NUMBER.fullmatch(cursor):
        raise UsageError(f"'{cursor[:50]}' is no cursor of this list: give 'next' of the page before, as it is")
    return int(cursor)

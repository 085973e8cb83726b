"""Parameters that several routes take."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import Path, Query

from skiros_py.api.problem import ProblemDetails

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

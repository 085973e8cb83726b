"""The routes of the API, one module for each topic."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter

from skiros_py.server.problems import PROBLEMS

PREFIX = "/api/v1"


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

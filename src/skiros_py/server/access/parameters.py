"""Unknown query parameters: ``?strt=false`` must not start a robot."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any
from weakref import WeakKeyDictionary

from fastapi import Request
from fastapi.dependencies.models import Dependant
from fastapi.routing import APIRoute

from skiros_py.errors import UnknownName
from skiros_py.server.problems import Problem


def check_query(request: Request) -> None:
    """Checks that the route has all query parameters of a request.

    Raises:
        Problem: A parameter is unknown (422); the text names the most similar known one.
    """
    if not request.query_params:
        return
    route: APIRoute = request.scope["route"]
    known = _KNOWN.get(route.endpoint)
    if known is None:
        known = _KNOWN.setdefault(route.endpoint, frozenset(_names(route.dependant)))
    for name in request.query_params:
        if name not in known:
            raise Problem(422, "InvalidRequest", str(UnknownName("query parameter", name, known)))


_KNOWN: WeakKeyDictionary[Callable[..., Any], frozenset[str]] = WeakKeyDictionary()
"""The parameters of a route's function; determined at its first request."""


def _names(dependant: Dependant) -> Iterator[str]:
    yield from (field.alias for field in dependant.query_params)
    for dependency in dependant.dependencies:
        yield from _names(dependency)

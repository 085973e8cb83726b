"""Each route calls one use case of the station, which command line and library reach as well."""

from __future__ import annotations

import ast
import inspect
import re
import textwrap
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from fastapi.routing import APIRoute, iter_route_contexts
from pydantic import BaseModel

from skiros_py.cli.call import operations
from skiros_py.server.app import create_app
from skiros_py.server.services import Services
from skiros_py.server.settings import ServerSettings
from skiros_py.station.station import Station

OWN = {
    "change_webhook", "create_key", "create_webhook", "delete_webhook", "export_audit", "get_health", "get_key",
    "get_metrics", "get_readiness", "get_session", "get_webhook", "list_audit", "list_dead_letters", "list_deliveries",
    "list_keys", "list_webhooks", "login", "logout", "ping_webhook", "redeliver", "revoke_key",
}  # fmt: skip
"""About the server itself: its keys, logins, audit log, webhooks and health."""
STREAMS = {"list_events", "stream_events", "stream_state"}
"""Each listener has a position of its own in the log of events, or a rate of its own."""
FOLLOWED = {"stream_events", "stream_job_events", "stream_state"}
"""Endless: the client follows them (``Client.follow``); on the command line ``skiros job watch`` does."""
MONITORING = {"get_health", "get_metrics", "get_readiness"}
"""For programs that monitor servers, outside of the API's prefix; each is an address without arguments."""
SEVERAL = {
    "answer_alarm": "who may answer depends on the alarm",
    "read_view": "the view is made only where its tag is another one",
    "state_relation": "the version of the element afterwards",
    "take_back_relation": "the version of the element afterwards",
}
"""Routes with more than one call, and why."""


def routes(folder: Path) -> list[APIRoute]:
    app = create_app(Services(lambda: pytest.fail("is not opened"), folder, ServerSettings()))
    found = [context.original_route for context in iter_route_contexts(app.routes)]
    return [route for route in found if isinstance(route, APIRoute) and route.include_in_schema]


def calls(endpoint: Any) -> list[str]:
    """Returns the use cases that a route calls, as "topic.method"."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(endpoint)))
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            chain = ast.unparse(node.func).removeprefix("act.").removeprefix("services.").split(".")
            if chain[0] == "station" and len(chain) == 3:
                found.append(".".join(chain[1:]))
    return found


def test_each_route_calls_one_use_case(tmp_path: Path) -> None:
    wrong = {}
    for route in routes(tmp_path):
        name = route.endpoint.__name__
        found = calls(route.endpoint)
        if name not in OWN | STREAMS and name not in SEVERAL and len(found) != 1:
            wrong[name] = found

    assert wrong == {}


def test_exactly_one_route_is_marked_as_truth_and_calls_the_use_case_that_returns_the_truth(tmp_path: Path) -> None:
    marked = [route for route in routes(tmp_path) if (route.openapi_extra or {}).get("x-truth")]

    assert [calls(route.endpoint) for route in marked] == [["simulation.true_bodies"]]


def test_every_listed_exception_is_still_needed(tmp_path: Path) -> None:
    single = {route.endpoint.__name__ for route in routes(tmp_path) if len(calls(route.endpoint)) == 1}
    names = {route.endpoint.__name__ for route in routes(tmp_path)}

    assert single.isdisjoint(OWN | STREAMS | SEVERAL.keys())
    assert (OWN | STREAMS | SEVERAL.keys()) - names == set()


def test_each_use_case_that_a_route_calls_is_a_public_method_of_the_station(tmp_path: Path) -> None:
    station = Station(lambda: pytest.fail("is not opened"), tmp_path)
    for route in routes(tmp_path):
        for call in calls(route.endpoint):
            topic, method = call.split(".")
            assert callable(getattr(getattr(station, topic), method)), call
            assert not method.startswith("_")


def requests() -> Iterator[tuple[str, str]]:
    """Yields method and path of a call of each operation of the client."""
    for _, operation in operations():
        needed = [p for p in operation.signature.parameters.values() if p.default is p.empty]
        call = operation(**{p.name: argument(p) for p in needed if p.kind is not p.VAR_POSITIONAL})
        yield call.method, f"/api/v1{call.path}"


def argument(parameter: inspect.Parameter) -> Any:
    kind = parameter.annotation
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        return kind.model_construct()
    return {int: 1, float: 1.0, Sequence[float]: (0.0, 0.0, 0.0)}.get(kind, "x")


def test_each_route_is_an_operation_of_the_client_and_of_skiros_call(tmp_path: Path) -> None:
    app = create_app(Services(lambda: pytest.fail("is not opened"), tmp_path, ServerSettings()))
    asked = set(requests())

    names = set()
    for context in iter_route_contexts(app.routes):
        if isinstance(context.original_route, APIRoute) and context.original_route.include_in_schema:
            path = re.sub(r"\{[^}]+\}", "[^/]+", context.path_format or "")
            if not any(method in (context.methods or ()) and re.fullmatch(path, own) for method, own in asked):
                names.add(context.original_route.endpoint.__name__)

    assert names == FOLLOWED | MONITORING

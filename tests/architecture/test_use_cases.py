"""Each route calls one use case of the station, which command line and library reach as well."""

from __future__ import annotations

import ast
import inspect
import textwrap
from pathlib import Path
from typing import Any

import pytest
from fastapi.routing import APIRoute

from skiros_py.server.app import create_app
from skiros_py.server.services import Services
from skiros_py.server.settings import ServerSettings
from skiros_py.station.station import Station

OWN = {
    "create_webhook", "list_webhooks", "get_webhook", "change_webhook", "remove_webhook", "ping_webhook",
    "list_dead_letters", "list_deliveries", "redeliver", "create_key", "list_keys", "revoke_key", "list_audit",
    "get_session", "login", "logout", "get_health", "get_readiness", "get_metrics",
}  # fmt: skip
"""About the server itself: its keys, logins, audit log, webhooks and health."""
STREAMS = {"list_events", "stream_events", "stream_job_events", "stream_state", "get_state"}
"""Events are read from the log of the station, live state from its snapshot."""
SEVERAL = {
    "order_job": "the order, and waiting for it (Prefer: wait)",
    "put_job": "the order, and waiting for it (Prefer: wait)",
    "answer_alarm": "who may answer depends on the alarm",
    "read_view": "the view is made only where its tag is another one",
    "state_relation": "the version of the element afterwards",
    "take_back_relation": "the version of the element afterwards",
    "get_job_replay": "the recording of a job lies with the server",
}
"""Routes with more than one call, and why."""


def routes(folder: Path) -> list[APIRoute]:
    app = create_app(Services(lambda: pytest.fail("is not opened"), folder, ServerSettings()))
    found = [route for route in app.routes if isinstance(route, APIRoute)]
    return [route for route in found if route.include_in_schema]


def calls(endpoint: Any) -> list[str]:
    """Returns the use cases that a route calls, as "topic.method"."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(endpoint)))
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            chain = ast.unparse(node.func).removeprefix("services.").split(".")
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


def test_the_exceptions_are_needed(tmp_path: Path) -> None:
    single = {route.endpoint.__name__ for route in routes(tmp_path) if len(calls(route.endpoint)) == 1}
    names = {route.endpoint.__name__ for route in routes(tmp_path)}

    assert single.isdisjoint(OWN | STREAMS | SEVERAL.keys())
    assert names >= OWN | STREAMS | SEVERAL.keys()


def test_each_use_case_that_a_route_calls_is_a_public_method_of_the_station(tmp_path: Path) -> None:
    station = Station(lambda: pytest.fail("is not opened"), tmp_path)
    for route in routes(tmp_path):
        for call in calls(route.endpoint):
            topic, method = call.split(".")
            assert callable(getattr(getattr(station, topic), method)), call
            assert not method.startswith("_")

"""The application is quickly made."""

from __future__ import annotations

from pathlib import Path

import pytest
from fastapi.routing import APIRoute

from skiros_py.server.app import create_app
from skiros_py.server.services import Services
from skiros_py.server.settings import ServerSettings


def test_the_routes_of_the_api_are_built_once_for_all_applications(tmp_path: Path) -> None:
    one, other = (
        create_app(Services(lambda: pytest.fail("is not opened"), tmp_path / name, ServerSettings()))
        for name in ("one", "other")
    )

    routes = [route for route in one.routes if isinstance(route, APIRoute)]
    assert {route.path for route in routes} >= {"/api/v1/jobs", "/api/v1/stop", "/healthz"}
    assert [id(route) for route in routes] == [id(route) for route in other.routes if isinstance(route, APIRoute)]

"""Versions over REST: what needs one says so in the API's description, and takes no other."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from skiros_py.errors import Refused, StaleVersion
from skiros_py.server.app import create_app
from skiros_py.server.problems import Problem, expected_version
from skiros_py.server.services import Services
from skiros_py.server.settings import ServerSettings
from skiros_py.station.requests import ANY_VERSION, Seen, require_seen

Operations = dict[tuple[str, str], dict[str, Any]]


@pytest.fixture(scope="module")
def operations(tmp_path_factory: pytest.TempPathFactory) -> Operations:
    folder = tmp_path_factory.mktemp("none")
    description = create_app(Services(lambda: pytest.fail("is not opened"), folder, ServerSettings())).openapi()
    assert "ProblemDetails" in description["components"]["schemas"]
    paths = description["paths"]
    return {(method, path): said for path, item in paths.items() for method, said in item.items()}


def taking(operations: Operations) -> Iterator[tuple[str, str]]:
    """Yields the operations that declare If-Match."""
    for name, said in operations.items():
        if "if-match" in {one["name"] for one in said.get("parameters", ()) if one["in"] == "header"}:
            yield name


def test_problems_are_described_under_the_media_type_that_is_sent(operations: Operations) -> None:
    for name, said in operations.items():
        for status, answer in said["responses"].items():
            content = answer.get("content", {})
            if "ProblemDetails" in str(content):
                assert "ProblemDetails" not in str(content.get("application/json")), (name, status)
                assert "ProblemDetails" in str(content["application/problem+json"]), (name, status)
            elif int(status) >= 400:
                assert name[1] in ("/healthz", "/readyz"), (name, status)


def test_no_parameter_has_the_name_that_generated_clients_give_the_body(operations: Operations) -> None:
    for name, said in operations.items():
        assert "body" not in {one["name"] for one in said.get("parameters", ())}, name


def test_exactly_the_operations_that_need_a_version_declare_if_match(operations: Operations) -> None:
    refused = {name for name, said in operations.items() if "428" in said["responses"]}
    optional = {("delete", "/api/v1/scenes/{name}")}
    declared = {(method, path) for method, path in taking(operations) if not path.startswith("/api/v1/jobs/")}

    assert len(refused) > 10
    assert refused == declared - optional


def test_every_operation_that_needs_a_version_has_a_response_that_returns_it(operations: Operations) -> None:
    tagged = {
        path
        for (_, path), said in operations.items()
        if any("ETag" in answer.get("headers", ()) for answer in said["responses"].values())
    }
    elsewhere = {"/api/v1/scenes": "/api/v1/scene", "/api/v1/learned/{element}": "/api/v1/elements/{element}"}

    assert {elsewhere.get(path, path) for _, path in taking(operations)} <= tagged


def test_a_missing_version_and_a_wrong_version_are_refused() -> None:
    with pytest.raises(Refused) as missing:
        require_seen(None, 17)
    with pytest.raises(StaleVersion) as stale:
        require_seen(Seen(16), 17)

    assert missing.value.code == "VersionMissing"
    assert stale.value.present == 17
    for given, status in (("17", 412), ('"16", "17"', 400)):
        with pytest.raises(Problem) as refused:
            expected_version(given)
        assert refused.value.status == status


def test_the_current_version_and_a_star_are_accepted() -> None:
    for seen in (Seen(17), ANY_VERSION):
        require_seen(seen, 17)
    assert [expected_version(given) for given in ('"17"', 'W/"17"', "*", None)] == [17, 17, None, None]

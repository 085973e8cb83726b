"""Who may do what over REST: every operation, by everybody, against a table that was written by hand."""

from __future__ import annotations

import re
import secrets
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import httpx2
import pytest
from support.serving import serving

from skiros_py.server.access.openapi import operations
from skiros_py.server.access.roles import Role
from skiros_py.server.app import create_app
from skiros_py.server.services import Services
from skiros_py.server.settings import ServerSettings
from skiros_py.station.session import Options

from .role_table import OPEN, ROLES

_METHODS = {"get", "put", "post", "patch", "delete"}


@dataclass(frozen=True)
class _Operation:
    method: str
    path: str
    said: dict[str, Any]

    @property
    def url(self) -> str:
        """Its address, with names that nothing has in place of what it is about."""
        return re.sub(r"\{[^}]+\}", lambda _match: f"nothing-{secrets.token_hex(4)}", self.path)


@pytest.fixture(scope="module")
def app(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return create_app(Services(lambda: pytest.fail("is not opened"), tmp_path_factory.mktemp("none"), ServerSettings()))


@pytest.fixture(scope="module")
def all_operations(app: Any) -> list[_Operation]:
    paths = app.openapi()["paths"]
    return [
        _Operation(method.upper(), path, said)
        for path, item in paths.items()
        for method, said in item.items()
        if method in _METHODS
    ]


@dataclass(frozen=True)
class _Station:
    url: str
    keys: dict[str, str]
    revoked: str
    expired: str


@pytest.fixture(scope="module")
def station(tmp_path_factory: pytest.TempPathFactory) -> Iterator[_Station]:
    data: Path = tmp_path_factory.mktemp("roles") / "data"
    settings = replace(ServerSettings(), rate=100_000)
    with serving("kitting", data, Options(fake=True), settings) as served:
        keys = served.services.keys
        made = {role.value: keys.create(role.value, role)[1] for role in Role}
        key, revoked = keys.create("gone", Role.ADMIN)
        keys.revoke(key.id)
        yield _Station(served.url, made, revoked, _expired(keys))


def _expired(keys: Any) -> str:
    key, text = keys.create("late", Role.ADMIN, 9e9)
    with keys._writes.transaction() as connection:
        connection.execute("UPDATE keys SET expires = 1 WHERE id = ?", (key.id,))
    return str(text)


def test_every_operation_declares_its_roles_exactly_once(app: Any) -> None:
    asked = {id_: needs for id_, needs in operations(app).items() if len(needs) != 1}
    public = {"get_health", "get_readiness", "login"}

    assert public == set(asked), f"ask none, or twice: {set(asked) - public}"


def test_every_operation_has_a_unique_id_and_a_description(all_operations: list[_Operation]) -> None:
    ids = [one.said["operationId"] for one in all_operations]
    wanting = [one.path for one in all_operations if not one.said.get("summary") or not one.said.get("description")]

    assert sorted(ids) == sorted(set(ids))
    assert not wanting, f"without summary or description: {wanting}"


def test_every_parameter_of_a_query_is_described(all_operations: list[_Operation]) -> None:
    wanting = [
        f"{one.path}: {parameter['name']}"
        for one in all_operations
        for parameter in one.said.get("parameters", ())
        if parameter["in"] == "query" and not parameter.get("description")
    ]

    assert wanting == []


def test_every_body_in_json_comes_with_an_example(app: Any, all_operations: list[_Operation]) -> None:
    schemas = app.openapi()["components"]["schemas"]
    wanting = []
    for one in all_operations:
        body = one.said.get("requestBody", {}).get("content", {}).get("application/json")
        if body is not None and not _has_example(body, schemas):
            wanting.append(f"{one.method} {one.path}")

    assert not wanting, f"no example: {wanting}"


def _has_example(body: dict[str, Any], schemas: dict[str, Any]) -> bool:
    if "example" in body or "examples" in body:
        return True
    schema = body["schema"]
    options = schema.get("anyOf", []) + schema.get("oneOf", []) + schema.get("allOf", [])
    if options:
        return any(_has_example({"schema": option}, schemas) for option in options)
    resolved = schemas[schema["$ref"].rpartition("/")[2]] if "$ref" in schema else schema
    fields = resolved.get("properties", {}).values()
    return "examples" in resolved or any("examples" in field or "example" in field for field in fields)


def test_the_openapi_document_declares_the_security_scheme_and_the_roles_of_operations(
    app: Any, all_operations: list[_Operation]
) -> None:
    assert app.openapi()["components"]["securitySchemes"]["key"]["scheme"] == "bearer"
    said = {(one.method, one.path): frozenset(one.said["x-roles"]) for one in all_operations}
    wrong = {what: roles for what, roles in said.items() if what not in OPEN and roles != ROLES.get(what)}

    assert not wrong, f"not as in the table: {wrong}"


def test_every_operation_is_in_the_table_of_roles_and_nothing_else_is(all_operations: list[_Operation]) -> None:
    assert {(one.method, one.path) for one in all_operations} == OPEN | ROLES.keys()


def test_only_the_operations_marked_open_in_the_table_need_no_key(all_operations: list[_Operation]) -> None:
    assert {(one.method, one.path) for one in all_operations if one.said.get("security") == []} == OPEN


def test_every_operation_takes_exactly_the_roles_of_the_table(
    station: _Station, all_operations: list[_Operation]
) -> None:
    wrong = []
    with httpx2.Client(base_url=station.url, timeout=60.0) as client:
        for one in _calls(all_operations):
            for role, key in station.keys.items():
                status = _status(client, one, {"Authorization": f"Bearer {key}"})
                allowed = ROLES.get((one.method, one.path), frozenset())
                if (status == 403) == (role in allowed) or status in {401, 429}:
                    wrong.append(f"{role}: {one.method} {one.path} -> {status}, for {sorted(allowed)}")

    assert not wrong, "\n".join(wrong)


def test_no_operation_is_executed_without_a_valid_key(station: _Station, all_operations: list[_Operation]) -> None:
    wrong = []
    shown: dict[str, dict[str, str]] = {
        "none": {},
        "revoked": {"Authorization": f"Bearer {station.revoked}"},
        "expired": {"X-API-Key": station.expired},
        "cookie": {"Cookie": "skiros_session=guess"},
    }
    with httpx2.Client(base_url=station.url, timeout=60.0) as client:
        for one in _calls(all_operations):
            for kind, headers in shown.items():
                status = _status(client, one, headers)
                if status not in {401, 429}:
                    wrong.append(f"{kind}: {one.method} {one.path} -> {status}")

    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("path", ["/api/v1/docs", "/api/v1/openapi.json", "/metrics", "/api/nothing"])
def test_unknown_paths_need_a_key_too(station: _Station, path: str) -> None:
    with httpx2.Client(base_url=station.url, timeout=60.0) as client:
        assert client.get(path).status_code == 401
        assert client.get(path, headers={"X-API-Key": station.keys["viewer"]}).status_code in {200, 404}


@pytest.mark.parametrize("path", ["/healthz", "/readyz"])
def test_health_is_answered_without_a_key_for_get_and_head(station: _Station, path: str) -> None:
    assert httpx2.get(f"{station.url}{path}", timeout=60.0).status_code == 200
    head = httpx2.head(f"{station.url}{path}", timeout=60.0)
    assert (head.status_code, head.content) == (200, b"")


def _calls(all_operations: list[_Operation]) -> Iterator[_Operation]:
    """Yields operations that can be called in a row, each alone: not those that need no key, or end a login."""
    return (one for one in all_operations if (one.method, one.path) not in OPEN)


def _status(client: httpx2.Client, one: _Operation, headers: dict[str, str]) -> int:
    """Calls an operation with a body that is wrong everywhere, so that whoever may call it changes nothing."""
    body = {} if one.method == "GET" else {"content": b"[]", "headers": {**headers, "Content-Type": "application/json"}}
    with client.stream(one.method, one.url, **{"headers": headers, **body}) as response:
        return response.status_code


def test_the_first_paragraph_of_a_docstring_is_the_title_of_its_operation(app: Any) -> None:
    for _ in range(2):  # the second description is the kept one
        listed = app.openapi()["paths"]["/api/v1/tasks"]["get"]

    assert listed["summary"] == "List the tasks"
    assert (
        listed["description"] == "Lists the tasks of jobs and others, newest first; the last 100 ended tasks are kept."
    )
    described = {parameter["name"]: parameter["description"] for parameter in listed["parameters"]}
    assert described == {"active": "Only active tasks, or only ended ones.", "limit": "Maximum number of entries."}

"""Every list that the API answers has one form: `items`, and `next`, the cursor of the next page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest

from skiros_py.server.app import create_app
from skiros_py.server.services import Services
from skiros_py.server.settings import ServerSettings

OTHERS = {
    "read_change": "one change; those of its edits that are missing are read in pages",
    "read_tree": "one element as a tree; those of its children that are missing are read in pages",
}
"""Operations whose answer is no list although it has a cursor, and why."""
NEXT = [{"anyOf": [{"type": "string"}, {"type": "null"}]}, {"type": "string"}]
"""The cursor; events have one at the end, too, since more of them will come."""


@pytest.fixture(scope="module")
def described(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("data")
    return create_app(Services(lambda: pytest.fail("is not opened"), folder, ServerSettings())).openapi()


def test_every_list_has_its_entries_as_items_and_the_next_cursor(described: dict[str, Any]) -> None:
    lists, others = set[str](), set[str]()
    for path, operations in described["paths"].items():
        if "get" not in operations:
            continue
        name, schema = operations["get"]["operationId"], answer_of(operations["get"], described)
        if is_list(name, schema):
            (lists if has_the_form(schema) else others).add(name)
        assert "type" in schema, path
    assert others == OTHERS.keys()
    assert {"list_jobs", "list_robots", "get_job_trace", "get_job_plan", "list_document_kinds"} <= lists


def answer_of(operation: Mapping[str, Any], described: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the schema of an answer in JSON; that of a text for one in another format."""
    content = operation["responses"]["200"].get("content", {})
    schema: dict[str, Any] = content.get("application/json", {}).get("schema") or {"type": "string"}
    if "$ref" in schema:
        schema = described["components"]["schemas"][schema["$ref"].rpartition("/")[2]]
    return schema


def is_list(name: str, schema: Mapping[str, Any]) -> bool:
    """Returns whether an answer is a list: it is named as one, has a cursor or entries, or holds one array only."""
    fields = schema.get("properties", {})
    arrays = [one for one in fields.values() if one.get("type") == "array"]
    alone = len(fields) == len(arrays) == 1
    return schema["type"] == "array" or name.startswith("list_") or {"items", "next"} & fields.keys() != set() or alone


def has_the_form(schema: Mapping[str, Any]) -> bool:
    fields = {name: without_prose(one) for name, one in schema.get("properties", {}).items()}
    return (
        fields.get("items", {}).get("type") == "array"
        and fields.get("next") in NEXT
        and {"items", "next"} <= set(schema["required"])
    )


def without_prose(field: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in field.items() if key not in ("title", "description", "examples")}

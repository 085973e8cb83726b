"""Writes the OpenAPI document of the server, without its prose, for the types of the pages: ``openapi.json``."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Any

from skiros_py.server.app import create_app
from skiros_py.server.services import Services
from skiros_py.server.settings import ServerSettings

_PROSE = ("description", "examples", "example", "summary", "title")


def document() -> dict[str, Any]:
    """Returns the OpenAPI document of a server, without starting it."""
    with tempfile.TemporaryDirectory() as folder:
        return create_app(Services(_no_station, Path(folder), ServerSettings())).openapi()


def _no_station() -> Any:
    raise AssertionError("nothing is opened for a document")


def without_prose(node: Any, *, names: bool = False) -> Any:
    """Returns a document without its texts for people.

    Args:
        node: Any part of the document.
        names: True for an object whose keys are names that somebody chose.
    """
    if isinstance(node, list):
        return [without_prose(item) for item in node]
    if not isinstance(node, dict):
        return node
    kept = {key: value for key, value in node.items() if names or key not in _PROSE}
    return {key: without_prose(value, names=key in ("properties", "schemas")) for key, value in kept.items()}


def with_one_problem(document: dict[str, Any]) -> dict[str, Any]:
    """Returns the document with one problem answer for each operation, since all have the same form."""
    problem = {"content": {"application/problem+json": {"schema": {"$ref": "#/components/schemas/ProblemDetails"}}}}
    for path in document["paths"].values():
        for operation in path.values():
            answers = operation["responses"]
            good = {status: answer for status, answer in answers.items() if status < "400"}
            operation["responses"] = good | {"default": problem}
    return document


if __name__ == "__main__":
    text = json.dumps(without_prose(with_one_problem(document())))
    Path(__file__).with_name("openapi.json").write_text(text)

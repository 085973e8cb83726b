"""Access in the OpenAPI description: how keys are sent, and which roles may call which operation."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from fastapi import FastAPI
from fastapi.dependencies.models import Dependant
from fastapi.routing import iter_route_contexts

from skiros_py.api.wire import ProblemDetails
from skiros_py.server.access.authenticator import COOKIE
from skiros_py.server.access.gate import OPEN
from skiros_py.server.access.roles import Need, Role

_SCHEMES = {
    "key": {"type": "http", "scheme": "bearer", "description": "A key: Authorization: Bearer sk_…"},
    "keyHeader": {"type": "apiKey", "in": "header", "name": "X-API-Key", "description": "A key, for older systems."},
    "login": {
        "type": "apiKey",
        "in": "cookie",
        "name": COOKIE,
        "description": f"Of web pages: POST /session. At an address with a port its name is {COOKIE}_PORT.",
    },
}


class GuardedApi(FastAPI):
    """An API whose description lists the permitted roles of each operation as ``x-roles``.

    The first paragraph of a route's docstring is the title of the operation, the rest its description; a last section
    "Parameters:" describes its parameters.
    """

    def openapi(self) -> dict[str, Any]:
        """Returns the description."""
        if self.openapi_schema is not None:
            return self.openapi_schema
        schema = super().openapi()
        components = schema.setdefault("components", {})
        components["securitySchemes"] = _SCHEMES
        # Routes refer to it by name, so that FastAPI does not see it.
        components["schemas"][ProblemDetails.__name__] = ProblemDetails.model_json_schema()
        schema["security"] = [{name: []} for name in _SCHEMES]
        asked = {(method, path): need for method, path, _, need in _asked(self)}
        for path, item in schema.get("paths", {}).items():
            for method, operation in item.items():
                if (method.upper(), path) in OPEN:
                    operation["security"] = []
                text, _, described = operation.pop("description").partition("\n\nParameters:\n")
                title, _, text = text.partition("\n\n")
                _describe(operation.get("parameters", ()), described)
                operation |= {"summary": title.rstrip("."), "description": text} if text else {"summary": title}
                operation["x-roles"] = _roles(asked.get((method.upper(), path), ()))
        return schema


_LISTS = {"limit": "Maximum number of entries.", "cursor": "`next` of the previous page."}
"""Parameters of all lists."""


def _describe(parameters: Iterable[dict[str, Any]], text: str) -> None:
    """Describes the parameters of an operation, from lines such as "rate: Maximum rate [Hz]."."""
    words = {name: what for name, _, what in (line.strip().partition(": ") for line in text.splitlines())}
    for parameter in parameters:
        name = parameter["name"]
        if name in words or name in _LISTS:
            parameter.setdefault("description", words.get(name) or _LISTS[name])


def operations(app: FastAPI) -> Mapping[str, tuple[Need, ...]]:
    """Returns the requirements of each operation, by its id in the OpenAPI description."""
    return {operation: needs for _, _, operation, needs in _asked(app)}


def _asked(app: FastAPI) -> Iterator[tuple[str, str, str, tuple[Need, ...]]]:
    for route in iter_route_contexts(app.routes):
        if getattr(route, "include_in_schema", False) and hasattr(route.original_route, "dependant"):
            needs = tuple(_needs(route.dependant))
            for method in route.methods or ():
                yield method, route.path_format or "", route.operation_id or route.unique_id, needs


def _needs(dependant: Dependant) -> Iterator[Need]:
    for dependency in dependant.dependencies:
        if isinstance(dependency.call, Need):
            yield dependency.call


def _roles(needs: tuple[Need, ...]) -> list[str]:
    return [role.value for role in Role if all(need.allows(role) for need in needs)]

"""The client can ask for everything that the server offers."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx2
from support.serving import serving

from skiros_py.client import calls

ELSEWHERE = {"get_health", "get_readiness", "get_metrics", "openapi"}
"""For programs that watch servers: they are outside of the API, and need no client."""


class Anything:
    """Stands for whatever data a call takes: only the address counts here."""

    def __getattr__(self, name: str) -> Any:
        return lambda *arguments, **options: {}


def functions() -> Iterator[Any]:
    for found in pkgutil.iter_modules(calls.__path__):
        module = importlib.import_module(f"{calls.__name__}.{found.name}")
        public = (value for name, value in vars(module).items() if not name.startswith("_"))
        yield from (v for v in public if inspect.isfunction(v) and v.__module__ == module.__name__)


def argument(parameter: inspect.Parameter) -> Any:
    kind = str(parameter.annotation)
    if kind.startswith("str"):
        return "x"
    if kind.startswith("Sequence[float"):
        return (0.0, 0.0, 0.0)
    if kind.startswith("Sequence"):
        return ()
    return 1 if kind.startswith(("int", "float")) else Anything()


def address(function: Any) -> tuple[str, str]:
    needed = [p for p in inspect.signature(function).parameters.values() if p.default is p.empty]
    plain = {p.name: argument(p) for p in needed if p.kind is p.KEYWORD_ONLY}
    made = function(*(argument(p) for p in needed if p.kind is not p.KEYWORD_ONLY), **plain)
    return getattr(made, "method", "GET"), made.path


def test_each_operation_of_the_server_has_a_call(tmp_path: Path) -> None:
    with serving("kitting", tmp_path) as server:
        paths = httpx2.get(f"{server.url}/api/v1/openapi.json", timeout=60.0).json()["paths"]
    offered = {
        (method.upper(), path.removeprefix("/api/v1")): operation["operationId"]
        for path, methods in paths.items()
        for method, operation in methods.items()
        if path.startswith("/api/v1")
    }
    made = {address(function) for function in functions()}
    missing = [
        name
        for (method, path), name in offered.items()
        if not any(method == own and re.fullmatch(re.sub(r"\{[^}]+\}", "[^/]+", path), asked) for own, asked in made)
    ]
    assert len(offered) > 50
    assert sorted(set(missing) - ELSEWHERE) == []

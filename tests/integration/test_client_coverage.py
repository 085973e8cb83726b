"""The client can ask for everything that the server offers."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import httpx2
from pydantic import BaseModel
from support.serving import serving

from skiros_py.cli.call import operations
from skiros_py.client.streams import stream_events, stream_job_events, stream_state

ELSEWHERE = {"get_health", "get_readiness", "get_metrics", "openapi"}
"""For programs that watch servers: they are outside of the API, and need no client."""


STREAMS = (stream_events(), stream_job_events("x"), stream_state())


def addresses() -> Iterator[tuple[str, str]]:
    yield from (("GET", stream.path) for stream in STREAMS)
    for _, method in operations():
        needed = [p for p in method.signature.parameters.values() if p.default is p.empty]
        plain = {p.name: argument(p) for p in needed if p.kind is p.KEYWORD_ONLY}
        made = method(*(argument(p) for p in needed if p.kind is not p.KEYWORD_ONLY), **plain)
        yield made.method, made.path


def argument(parameter: inspect.Parameter) -> Any:
    kind = parameter.annotation
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        return kind.model_construct()
    return {int: 1, float: 1.0, Sequence[float]: (0.0, 0.0, 0.0)}.get(kind, "x")


def test_each_operation_of_the_server_has_a_call(tmp_path: Path) -> None:
    with serving("kitting", tmp_path) as server:
        paths = httpx2.get(f"{server.url}/api/v1/openapi.json", timeout=60.0).json()["paths"]
    offered = {
        (method.upper(), path.removeprefix("/api/v1")): operation["operationId"]
        for path, methods in paths.items()
        for method, operation in methods.items()
        if path.startswith("/api/v1")
    }
    made = set(addresses())
    missing = [
        name
        for (method, path), name in offered.items()
        if not any(method == own and re.fullmatch(re.sub(r"\{[^}]+\}", "[^/]+", path), asked) for own, asked in made)
    ]
    assert len(offered) > 50
    assert sorted(set(missing) - ELSEWHERE) == []

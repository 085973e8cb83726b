"""Whatever can be asked of a server can be asked by either client."""

from __future__ import annotations

import importlib
import pkgutil
from types import ModuleType

import pytest

from skiros_py.client import async_topics, calls, topics
from skiros_py.client.call import Call

MODULES = [importlib.import_module(f"{calls.__name__}.{found.name}") for found in pkgutil.iter_modules(calls.__path__)]


def made_by(module: ModuleType) -> set[object]:
    """The functions whose calls the parts of a client send."""
    parts = [part for part in vars(module).values() if isinstance(part, type)]
    return {vars(method)["call"] for part in parts for method in vars(part).values() if "call" in dir_of(method)}


def dir_of(method: object) -> dict[str, object]:
    return getattr(method, "__dict__", {})


def makes_calls(function: object) -> bool:
    return callable(function) and str(getattr(function, "__annotations__", {}).get("return", "")).startswith(
        Call.__name__
    )


@pytest.mark.parametrize("module", MODULES, ids=lambda module: module.__name__.rpartition(".")[2])
def test_each_call_belongs_to_both_clients(module: ModuleType) -> None:
    ours = {getattr(module, name) for name in module.__all__ if makes_calls(getattr(module, name))}

    assert ours
    assert ours <= made_by(topics)
    assert ours <= made_by(async_topics)

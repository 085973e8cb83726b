"""Each call is a method of a topic, blocking or awaitable as its client is."""

from __future__ import annotations

import importlib
import pkgutil
from types import ModuleType

import pytest

from skiros_py.client import calls, topics
from skiros_py.client.request import Call, Method

MODULES = [importlib.import_module(f"{calls.__name__}.{found.name}") for found in pkgutil.iter_modules(calls.__path__)]


def methods() -> set[object]:
    """The functions whose calls the topics of a client send."""
    topics_ = [part for part in vars(topics).values() if isinstance(part, type)]
    return {method.make for topic in topics_ for method in vars(topic).values() if isinstance(method, Method)}


def makes_calls(function: object) -> bool:
    return callable(function) and str(getattr(function, "__annotations__", {}).get("return", "")).startswith(
        Call.__name__
    )


@pytest.mark.parametrize("module", MODULES, ids=lambda module: module.__name__.rpartition(".")[2])
def test_each_call_is_a_method_of_a_topic(module: ModuleType) -> None:
    ours = {made for name, made in vars(module).items() if not name.startswith("_") and makes_calls(made)}

    assert ours
    assert ours <= methods()

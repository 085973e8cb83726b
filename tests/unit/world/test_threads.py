"""Many threads read and write one world, and nobody sees what nobody wrote."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest


@pytest.fixture
def world_threads(root: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The run that the command with more seconds does too."""
    monkeypatch.syspath_prepend(str(root / "benchmarks"))  # its neighbours
    spec = importlib.util.spec_from_file_location("world_threads", root / "benchmarks" / "world_threads.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, module)  # its dataclasses look for it there
    spec.loader.exec_module(module)
    return module


def test_parallel_reads_are_consistent_and_parallel_writes_are_not_lost(world_threads: ModuleType) -> None:
    outcome = world_threads.run(2.0)

    assert (outcome.errors, outcome.torn, outcome.lost) == ([], [], [])
    assert outcome.writes > 100
    assert outcome.reads > 100

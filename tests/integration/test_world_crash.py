"""Nothing that was acknowledged is lost when the process is killed."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


@pytest.fixture(scope="module")
def rounds() -> ModuleType:
    """The rounds that the command with more of them runs too."""
    spec = importlib.util.spec_from_file_location("world_crash_rounds", BENCHMARKS / "world_crash_rounds.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # its dataclasses look for it there
    spec.loader.exec_module(module)
    return module


def test_a_world_whose_process_is_killed_again_and_again_keeps_every_acknowledged_change(
    rounds: ModuleType, tmp_path: Path
) -> None:
    outcome = rounds.run(50, tmp_path, seed=7)

    assert outcome.faults == []
    assert outcome.rounds == 50
    assert outcome.acknowledged > 200
    assert outcome.compactions > 10

"""For tests of skills, plans and goals without physics and without any plug-in: a tiny domain and a bench.

>>> from skiros_py.testing import Bench, tiny_world
>>> with Bench(tiny_world()) as bench:
...     report = bench.pursue("In(ball_1, slot_1)")
>>> report.reached
True
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from skiros_py.testing.bench import Bench
    from skiros_py.testing.faulty_cell import (
        Blind,
        CellFault,
        Deaf,
        Dies,
        FaultyCell,
        Frozen,
        Late,
        Noisy,
        Says,
        Unplugged,
    )
    from skiros_py.testing.tiny import (
        CONDITIONS,
        SKILLS,
        TINY_ONTOLOGY,
        robot_turtle,
        tiny_ontology,
        tiny_scene,
        tiny_world,
        world_of,
    )
    from skiros_py.testing.trying import (
        Answers,
        Breaks,
        Fails,
        GivenPlanner,
        ModuleFault,
        SkillTrial,
        Slow,
        answers,
        run_primitive,
        run_skill,
        spoiled,
    )

__all__ = [
    "CONDITIONS",
    "SKILLS",
    "TINY_ONTOLOGY",
    "Answers",
    "Bench",
    "Blind",
    "Breaks",
    "CellFault",
    "Deaf",
    "Dies",
    "Fails",
    "FaultyCell",
    "Frozen",
    "GivenPlanner",
    "Late",
    "ModuleFault",
    "Noisy",
    "Says",
    "SkillTrial",
    "Slow",
    "Unplugged",
    "answers",
    "robot_turtle",
    "run_primitive",
    "run_skill",
    "spoiled",
    "tiny_ontology",
    "tiny_scene",
    "tiny_world",
    "world_of",
]

_MODULES = ("faulty_cell", "tiny", "bench", "trying")


def __getattr__(name: str) -> Any:
    """Imports names on demand: the pytest plug-in in this package is loaded by every pytest, and must be light."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    modules = (vars(import_module(f"{__name__}.{module}")) for module in _MODULES)
    return next(module[name] for module in modules if name in module)

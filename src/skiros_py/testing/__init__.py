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
    from skiros_py.testing.answering import Answers, answers
    from skiros_py.testing.bench import Bench
    from skiros_py.testing.cell_faults import Blind, CellFault, Deaf, Dies, Frozen, Late, Noisy, Says
    from skiros_py.testing.faulty_cell import FaultyCell
    from skiros_py.testing.module_faults import Breaks, Fails, ModuleFault, Slow, spoiled
    from skiros_py.testing.planners import GivenPlanner
    from skiros_py.testing.tiny import TINY_ONTOLOGY, tiny_ontology, tiny_scene, tiny_world
    from skiros_py.testing.tiny_skills import CONDITIONS, SKILLS
    from skiros_py.testing.tiny_tasks import tiny_pddl, tiny_task
    from skiros_py.testing.trial import SkillTrial
    from skiros_py.testing.trying import run_primitive, run_skill
    from skiros_py.testing.worlds import robot_turtle, world_of

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
    "answers",
    "robot_turtle",
    "run_primitive",
    "run_skill",
    "spoiled",
    "tiny_ontology",
    "tiny_pddl",
    "tiny_scene",
    "tiny_task",
    "tiny_world",
    "world_of",
]

_HOMES = {
    "answering": ("Answers", "answers"),
    "bench": ("Bench",),
    "cell_faults": ("Blind", "CellFault", "Deaf", "Dies", "Frozen", "Late", "Noisy", "Says"),
    "faulty_cell": ("FaultyCell",),
    "module_faults": ("Breaks", "Fails", "ModuleFault", "Slow", "spoiled"),
    "planners": ("GivenPlanner",),
    "tiny": ("TINY_ONTOLOGY", "tiny_ontology", "tiny_scene", "tiny_world"),
    "tiny_skills": ("CONDITIONS", "SKILLS"),
    "tiny_tasks": ("tiny_pddl", "tiny_task"),
    "trial": ("SkillTrial",),
    "trying": ("run_primitive", "run_skill"),
    "worlds": ("robot_turtle", "world_of"),
}
_MODULES = {name: module for module, names in _HOMES.items() for name in names}


def __getattr__(name: str) -> Any:
    """Imports names on demand: the pytest plug-in in this package is loaded by every pytest, and must be light."""
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)

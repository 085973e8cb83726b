"""For tests of skills, plans and goals without physics and without any plug-in: a tiny domain and a bench.

>>> from skiros_py.testing import Bench, tiny_world
>>> with Bench(tiny_world()) as bench:
...     report = bench.pursue("In(ball_1, slot_1)")
>>> report.reached
True
"""

from skiros_py.testing.bench import Bench
from skiros_py.testing.planners import GivenPlanner
from skiros_py.testing.tiny import TINY_ONTOLOGY, tiny_ontology, tiny_scene, tiny_world
from skiros_py.testing.tiny_skills import CONDITIONS, SKILLS
from skiros_py.testing.tiny_tasks import tiny_pddl, tiny_task

__all__ = [
    "CONDITIONS",
    "SKILLS",
    "TINY_ONTOLOGY",
    "Bench",
    "GivenPlanner",
    "tiny_ontology",
    "tiny_pddl",
    "tiny_scene",
    "tiny_task",
    "tiny_world",
]

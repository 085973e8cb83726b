"""Planning from many threads at once: each goal gets its own plan, and no processes or files are left.

    uv run python benchmarks/planning_threads.py

A plan is wrong if its replay does not reach the goal of its thread, or if the service refused it, regardless of the
answers of other planners.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path

import psutil
from table import Figure, finish

from skiros_py.errors import PlanningError
from skiros_py.planning.plan import Plan
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.planners.kairos import Kairos
from skiros_py.planning.planners.planner import Planner, Planners
from skiros_py.planning.problem.task import Capability
from skiros_py.planning.replay import replay
from skiros_py.planning.service import plan
from skiros_py.skills.conditions import Condition
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import DRIVE, IN_CONTAINER, PICK, PLACE
from skiros_py.world.world import World

_BALLS, _SLOTS = 8, 6
_SKILLS = (DRIVE, PICK, PLACE)


def main() -> int:
    """Measures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--goals", type=int, default=1000, help="how many goals are planned for")
    parser.add_argument("--threads", type=int, default=8, help="from how many threads")
    arguments = parser.parse_args()
    return finish("planning from many threads", figures(arguments.goals, arguments.threads))


def figures(goals: int = 1000, threads: int = 8) -> list[Figure]:
    """Plans for many different goals with each planner in turn.

    Args:
        goals: How many goals, shared among the planners.
        threads: From how many threads at once.
    """
    share = goals // 2
    with tempfile.TemporaryDirectory() as folder:
        usual, tempfile.tempdir = tempfile.tempdir, folder  # nobody else leaves anything there
        try:
            return [
                *_of_planner(FastDownward(), share, threads, Path(folder)),
                *_of_planner(Kairos(), goals - share, threads, Path(folder)),
            ]
        finally:
            tempfile.tempdir = usual


def _of_planner(planner: Planner, goals: int, threads: int, folder: Path) -> list[Figure]:
    world = _world()
    wanted = _goals(goals)
    before = _left_behind(folder)
    started = time.perf_counter()
    with closing(Planners.only(planner)) as planners:
        with ThreadPoolExecutor(threads) as pool:
            verdicts = list(pool.map(lambda goal: _verdict(planners, world, goal), wanted))
        seconds = time.perf_counter() - started
    wrong = len(verdicts) - verdicts.count("")
    stray = len(_left_behind(folder) - before)
    each = 1e3 * seconds / goals
    return [
        Figure(
            f"{planner.name}: wrong plans of {goals} goals from {threads} threads",
            f"{wrong}{_examples(verdicts)}, {each:.0f} ms each",
            "0",
            wrong == 0,
            "unified-planning's own call: 43 of 60",
        ),
        Figure(f"{planner.name}: stray processes and files", f"{stray}", "0", stray == 0),
    ]


def _world() -> World:
    balls = "".join(f"scene:ball_{n} a tiny:Ball ; sk:in scene:box_{'ab'[n % 2]} . " for n in range(2, _BALLS + 1))
    slots = "".join(f"scene:slot_{n} a tiny:Slot ; sk:on scene:floor . " for n in range(3, _SLOTS + 1))
    return tiny_world(balls, slots)


def _goals(count: int) -> list[tuple[Condition, ...]]:
    """Draws goals of one or two balls in slots of their own."""
    drawn = random.Random(7)  # noqa: S311 - a workload, not a secret
    goals = []
    for _ in range(count):
        number = drawn.choice((1, 2))
        balls = drawn.sample(range(1, _BALLS + 1), number)
        slots = drawn.sample(range(1, _SLOTS + 1), number)
        pairs = zip(balls, slots, strict=True)
        goals.append(tuple(IN_CONTAINER(f"ball_{ball}", f"slot_{slot}") for ball, slot in pairs))
    return goals


def _verdict(planners: Planners, world: World, goal: Sequence[Condition]) -> str:
    """Plans for a goal; returns the fault of the plan, or nothing."""
    able = [Capability(skill, world.instances(skill.agent_class)) for skill in _SKILLS]
    try:
        planned = plan(planners, world, able, goal)
    except PlanningError as error:
        return str(error)
    if not isinstance(planned.outcome, Plan):
        return "; ".join((*planned.outcome.reasons, *planned.notes))
    flaw = replay(world, planned.outcome.steps, goal, {skill.name: skill for skill in _SKILLS})
    return "; ".join(planned.notes) if flaw is None else flaw.verdict.text


def _left_behind(folder: Path) -> set[str]:
    """Returns our child processes, and the content of the folder for temporary files."""
    running = {f"process {child.pid}" for child in psutil.Process().children(recursive=True)}
    return running | {str(path) for path in folder.iterdir()}


def _examples(verdicts: Sequence[str]) -> str:
    wrong = sorted({verdict for verdict in verdicts if verdict})
    return f" ({wrong[0][:80]})" if wrong else ""


if __name__ == "__main__":
    sys.exit(main())

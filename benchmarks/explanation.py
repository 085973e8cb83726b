"""Why there is no plan: whether the cause is right, how long it takes, and whether every repair works.

    uv run python benchmarks/explanation.py

Tasks that have a plan are modified in a way drawn from a seed, so that the cause is known. Each repair is then applied
to a fresh copy of the world, as a person would, and a planner other than the one that verified it must find a plan.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, field

from mutations import Mutation, mutations
from table import Figure, finish, in_steps

from skiros_py.planning.explanation.explaining import explain
from skiros_py.planning.explanation.trial import Trial
from skiros_py.planning.plan import NoPlan
from skiros_py.planning.planners.fast_downward import FastDownward
from skiros_py.planning.planners.kairos import Kairos
from skiros_py.planning.planners.planner import Planner, Planners
from skiros_py.planning.problem.task import Capability, build_task
from skiros_py.planning.service import plan
from skiros_py.skills.conditions import Condition
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import DRIVE, IN_CONTAINER, PICK, PLACE

_RIGHT, _CAUSE, _ALL = 0.95, 2.8e6, 28e6


@dataclass
class Tally:
    """Counts over all mutations; times in seconds."""

    tasks: int = 0
    wrong: list[str] = field(default_factory=list)
    causes: list[float] = field(default_factory=list)
    whole: list[float] = field(default_factory=list)
    repairs: int = 0
    repaired: int = 0
    broken: list[str] = field(default_factory=list)


def main() -> int:
    """Measures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3, help="how many seeds")
    parser.add_argument("--rounds", type=int, default=2, help="how often each way to spoil a task is drawn from a seed")
    options = parser.parse_args()
    trying, checking = Planners.only(Kairos()), FastDownward()
    tally = Tally()
    for seed in range(1, options.seeds + 1):
        for mutation in mutations(seed, options.rounds):
            _measure(mutation, trying, checking, tally)
    checking.close()
    trying.close()
    for line in (*tally.wrong, *tally.broken):
        print(line)
    return finish("explanation", _figures(tally, _in_a_large_world()))


def _measure(mutation: Mutation, trying: Planners, checking: Planner, tally: Tally) -> None:
    task = build_task(mutation.world, mutation.capabilities, mutation.goal)
    started = time.perf_counter()
    explain(task)
    tally.causes.append(time.perf_counter() - started)
    started = time.perf_counter()
    found = explain(task, Trial(trying, mutation.capabilities))
    tally.whole.append(time.perf_counter() - started)
    tally.tasks += 1
    if not mutation.is_explained(found.causes):
        tally.wrong.append(f"wrong: {mutation.name}: {'; '.join(found.reasons)}")
    _apply_each(mutation, found, checking, tally)


def _apply_each(mutation: Mutation, found: NoPlan, checking: Planner, tally: Tally) -> None:
    offered = [repair for repair in found.repairs if repair.edits or repair.without]
    tally.repairs += len(offered)
    tally.repaired += bool(offered)
    for repair in offered:
        assert mutation.again is not None
        fresh = mutation.again()
        repair.apply(fresh.world)
        if not _has_plan(fresh, [c for c in fresh.goal if c not in repair.without], checking):
            tally.broken.append(f"no plan after all: {mutation.name}: {repair.text}")


def _has_plan(mutation: Mutation, goal: Sequence[Condition], checking: Planner) -> bool:
    return not isinstance(plan(checking, mutation.world, mutation.capabilities, goal).outcome, NoPlan)


def _in_a_large_world() -> float:
    """Returns the time to find the cause among 500 parts in 50 boxes [s]."""
    boxes = [f"scene:box_{n} a tiny:Box ; sk:on scene:floor ." for n in range(50)]
    parts = [f"scene:part_{n} a tiny:Ball ; sk:in scene:box_{n % 50} ." for n in range(500)]
    world = tiny_world(*boxes, *parts, "scene:ball_9 a tiny:Ball ; sk:in scene:slot_1 .", robots=2)
    able = [Capability(skill, tuple(world.instances(skill.agent_class))) for skill in (DRIVE, PICK, PLACE)]
    goal = IN_CONTAINER("tiny:Ball", "slot_2"), IN_CONTAINER("part_7", "slot_1")
    task = build_task(world, able, goal, whole=True)
    started = time.perf_counter()
    explain(task)
    return time.perf_counter() - started


def _figures(tally: Tally, large: float) -> list[Figure]:
    right = 1.0 - len(tally.wrong) / tally.tasks
    worked = tally.repairs - len(tally.broken)
    cause, whole = max(tally.causes), max(tally.whole)
    return [
        Figure(
            "cause right", f"{right:.1%} of {tally.tasks}", f">= {_RIGHT:.0%}", right >= _RIGHT, "how it was spoilt"
        ),
        in_steps("cause, slowest", cause, _CAUSE),
        in_steps("cause among 500 parts", large, _CAUSE),
        in_steps("cause and repairs, slowest", whole, _ALL),
        Figure(
            "repairs that work",
            f"{worked} of {tally.repairs}",
            "all",
            not tally.broken,
            "applied, planned by Fast Downward, replayed",
        ),
        Figure("tasks with a repair", f"{tally.repaired} of {tally.tasks}"),
    ]


if __name__ == "__main__":
    sys.exit(main())

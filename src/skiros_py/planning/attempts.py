"""The tasks given to planners, one after the other: quick ones first, the complete problem last."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

from skiros_py.planning.domain.pddl import PddlTexts, write_pddl
from skiros_py.planning.domain.sequencing import in_sequence, with_costs
from skiros_py.planning.domain.temporal import write_temporal
from skiros_py.planning.durations import timed
from skiros_py.planning.problem.task import Capability, PlanningTask, build_task
from skiros_py.planning.robots.allocation import deal
from skiros_py.skills.conditions import Condition
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import SPATIAL_THING

_WIDTHS = (2, 16)
"""How many candidates are included per choice, before all of them are."""
_SMALL = 60
"""In a world with at most this many things the complete problem is as quick."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """What to plan.

    Attributes:
        view: The world.
        capabilities: The available skills.
        goal: The conditions that must all hold.
        reached: The highest sequence number that each robot has visited in this task.
        temporal: True for temporal planning, with durative actions.
        name: Name of domain and problem.
    """

    view: WorldView
    capabilities: tuple[Capability, ...]
    goal: tuple[Condition, ...]
    reached: Mapping[str, int] = field(default_factory=dict)
    temporal: bool = False
    name: str = "skiros"


def attempts(wanted: Wanted) -> Iterator[tuple[PlanningTask, PddlTexts]]:
    """Yields increasingly complete tasks with their texts; each is computed on demand.

    Raises:
        PlanningError: The task cannot be expressed in PDDL.
    """
    for width in _widths(wanted.view):
        task = _task(wanted, width)
        shared = deal(wanted.view, task)
        if shared is not task:
            yield replace(shared, complete=False), _texts(wanted, shared)
        yield task, _texts(wanted, task)
        if task.complete:
            return


def _widths(view: WorldView) -> tuple[int | None, ...]:
    small = len(view.some_instances(SPATIAL_THING, _SMALL + 1)) <= _SMALL
    return (None,) if small else (*_WIDTHS, None)


def _task(wanted: Wanted, width: int | None) -> PlanningTask:
    task = build_task(wanted.view, wanted.capabilities, wanted.goal, width=width)
    return in_sequence(wanted.view, timed(wanted.view, task), wanted.reached)


def _texts(wanted: Wanted, task: PlanningTask) -> PddlTexts:
    if wanted.temporal:
        return write_temporal(task, name=wanted.name)
    return with_costs(wanted.view, task, write_pddl(task.domain, task.problem, name=wanted.name))

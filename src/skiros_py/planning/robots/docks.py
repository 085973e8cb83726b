"""Chooses among docking places: planners ignore distances, so a plan may cross the hall unnecessarily.

Places are exchanged for equivalent ones (parts of one thing, of one class) if that shortens the driving and the plan
remains valid.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations, pairwise
from typing import NamedTuple

from skiros_py.geometry import Pose
from skiros_py.planning.domain.pddl import PddlTexts
from skiros_py.planning.plan import Plan, Step
from skiros_py.planning.plan_validation import replay
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.planning.regrounding import pddl_plan
from skiros_py.planning.robots.allocation import teams
from skiros_py.skills.conditions import Related
from skiros_py.world.poses import map_pose
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import AT, DRIVING_POSE, HAS_A

_MOST = 20
"""Maximum number of exchanges."""
_WORTH = 0.1
"""Minimum driving distance an exchange must save [m]."""

Point = tuple[float, float]


def docking_nearer(
    view: WorldView, task: PlanningTask, texts: PddlTexts, plan: Plan, reached: Mapping[str, int] | None = None
) -> Plan:
    """Returns the plan with docking places exchanged while that shortens the driving and the plan remains valid.

    Args:
        view: The world that the plan starts from.
        task: The planned task.
        texts: The task as PDDL.
        plan: The steps, validated by replay.
        reached: The highest sequence number that each robot has visited in this task.
    """
    skills = {c.skill.name: c.skill for c in task.capabilities}
    docking = _Docking(view, task)
    for _ in range(_MOST):
        for steps in docking.shorter(plan.steps):
            if replay(view, steps, task.conditions, skills, reached=reached) is None:
                lines = pddl_plan(task, texts, steps, view.ontology)
                if lines:
                    plan = replace(plan, steps=steps, pddl=lines)
                    break
        else:
            break
    return plan


class _Ride(NamedTuple):
    robot: str
    place: str


class _Docking:
    """The robots' stops in a plan, and their alternatives."""

    def __init__(self, view: WorldView, task: PlanningTask) -> None:
        self._view = view
        self._skills = {c.skill.name: c.skill for c in task.capabilities}
        self._robots = {agent: robot for robot, agents in teams(view, task).items() for agent in agents}

    def shorter(self, steps: tuple[Step, ...]) -> list[tuple[Step, ...]]:
        """Returns the same steps with two docking places exchanged, those with the least driving first."""
        now = self._driven(steps)
        other = [(self._driven(changed), changed) for changed in self._exchanged(steps)]
        worth = [(driven, changed) for driven, changed in other if driven < now - _WORTH]
        return [changed for _, changed in sorted(worth, key=lambda found: found[0])]

    def _exchanged(self, steps: tuple[Step, ...]) -> Iterator[tuple[Step, ...]]:
        """Exchanges places for all robots; for a single one only if no other robot visits either of them."""
        rides = list(self._rides(steps))
        for pair in self._alike({ride.place for ride in rides}):
            names = dict(zip(pair, reversed(pair), strict=True))
            yield tuple(step.renamed(names) for step in steps)
            for robot in sorted({ride.robot for ride in rides if ride.place in pair}):
                if {ride.robot for ride in rides if ride.place in pair} == {robot}:
                    continue  # same as the exchange for all robots
                places = {ride.place for ride in rides if ride.robot != robot}
                taken = {ride.place for ride in rides if ride.robot == robot and ride.place in pair}
                if places.isdisjoint(set(pair) - taken):
                    yield tuple(step.renamed(names) if self._robot(step) == robot else step for step in steps)

    def _alike(self, places: set[str]) -> list[tuple[str, str]]:
        """Returns pairs of equivalent places (parts of one thing, of one class), at least one of which is visited."""
        owners = sorted({owner for place in places for owner in self._view.subjects(HAS_A, place)})
        pairs = {pair for owner in owners for pair in combinations(sorted(self._view.objects(owner, HAS_A)), 2)}
        return sorted(pair for pair in pairs if not places.isdisjoint(pair) and self._are_alike(*pair))

    def _are_alike(self, one: str, other: str) -> bool:
        same = self._view.element(one).type == self._view.element(other).type
        return same and None not in (self._standing(one), self._standing(other))

    def _driven(self, steps: Sequence[Step]) -> float:
        """Returns the robots' straight-line driving distance [m], as far as positions are known."""
        ways: dict[str, list[Point]] = {}
        for robot, place in self._rides(steps):
            way = ways.setdefault(robot, self._start(robot))
            at = self._standing(place)
            way += [at] if at is not None else []
        return sum(math.dist(a, b) for way in ways.values() for a, b in pairwise(way))

    def _rides(self, steps: Sequence[Step]) -> Iterator[_Ride]:
        for step in steps:
            for condition in self._skills[step.skill].post:
                pattern = condition.bind(step.arguments).pattern
                if isinstance(pattern, Related) and pattern.relation == AT:
                    yield _Ride(pattern.subject, pattern.object)

    def _start(self, robot: str) -> list[Point]:
        """Returns a robot's start position: its place, or where its base is; empty if unknown."""
        placement = self._view.placement(robot)
        at = None if placement is None else self._standing(placement.place)
        poses = (map_pose(self._view, piece) for piece in self._view.objects(robot, HAS_A))
        pose = next((pose for pose in poses if pose is not None), None)
        found = at or (None if pose is None else (pose.position[0], pose.position[1]))
        return [] if found is None else [found]

    def _standing(self, place: str) -> Point | None:
        """Returns where a robot stands when working at a place [m in the map]; None if unknown."""
        if not self._view.has(place):
            return None
        pose, driving = map_pose(self._view, place), self._view.value(place, DRIVING_POSE)
        if pose is None or not isinstance(driving, Pose):
            return None
        x, y, _ = (pose @ driving).position
        return x, y

    def _robot(self, step: Step) -> str:
        agent = step.arguments[self._skills[step.skill].agent]
        return self._robots.get(agent, agent)

"""Exchanges docking places for equivalent ones (parts of one thing, of one class) if that shortens the driving."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cache, partial
from itertools import combinations, pairwise
from typing import NamedTuple

from skiros_py.planning.plan import Step
from skiros_py.planning.plan_validation import grounded
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.planning.replay import replay
from skiros_py.skills.conditions import Related
from skiros_py.world.poses import driving_pose, map_pose
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import AT, HAS_A

_MOST = 20
"""Maximum number of exchanges."""
_WORTH = 0.1
"""Minimum driving distance an exchange must save [m]."""

Point = tuple[float, float]


def docking_nearer(task: PlanningTask, steps: tuple[Step, ...], reached: Mapping[str, int]) -> tuple[Step, ...]:
    """Returns the steps with docking places exchanged while that shortens the driving and the plan remains valid.

    Args:
        task: The planned task.
        steps: The plan, validated by replay.
        reached: The highest sequence number that each robot has visited in this task.
    """
    docking = Docking(task)
    for _ in range(_MOST):
        shorter = next((other for other in docking.shorter(steps) if _is_plan(task, other, reached)), None)
        if shorter is None:
            break
        steps = shorter
    return steps


def _is_plan(task: PlanningTask, steps: tuple[Step, ...], reached: Mapping[str, int]) -> bool:
    flaw = replay(task.view, steps, task.conditions, task.skills, reached=reached)
    return flaw is None and bool(grounded(task, steps))


class _Ride(NamedTuple):
    robot: str
    place: str


class Docking:
    """The robots' stops in a plan, and their alternatives."""

    def __init__(self, task: PlanningTask) -> None:
        self._view = task.view
        self._task = task
        self._standing = cache(partial(_standing, task.view))

    def distance(self, robot: str, places: Sequence[str], after: str | None = None) -> float:
        """Returns how far a robot drives in a straight line [m], as far as positions are known.

        Args:
            robot: The robot.
            places: Where it drives to.
            after: Where it is before; None for where it is now.
        """
        points = [self._standing(place) for place in ((after, *places) if after else places)]
        known = [point for point in points if point is not None]
        return sum(math.dist(a, b) for a, b in pairwise(known if after else [*self._start(robot), *known]))

    def robot(self, step: Step) -> str:
        """Returns the robot that runs a step."""
        agent = step.arguments[self._task.skills[step.skill].agent]
        return self._task.robots.get(agent, agent)

    def shorter(self, steps: tuple[Step, ...]) -> list[tuple[Step, ...]]:
        """Returns the same steps with two docking places exchanged, those with the least driving first."""
        now = self._driven(steps)
        other = [(self._driven(changed), changed) for changed in self._exchanged(steps)]
        worth = [(driven, changed) for driven, changed in other if driven < now - _WORTH]
        return [changed for _, changed in sorted(worth, key=lambda found: found[0])]

    def _exchanged(self, steps: tuple[Step, ...]) -> Iterator[tuple[Step, ...]]:
        """Exchanges places for all robots; for a single one only if no other robot visits either of them."""
        rides = list(self.rides(steps))
        for pair in self._alike({ride.place for ride in rides}):
            names = dict(zip(pair, reversed(pair), strict=True))
            yield tuple(step.renamed(names) for step in steps)
            for robot in sorted({ride.robot for ride in rides if ride.place in pair}):
                if {ride.robot for ride in rides if ride.place in pair} == {robot}:
                    continue  # same as the exchange for all robots
                places = {ride.place for ride in rides if ride.robot != robot}
                taken = {ride.place for ride in rides if ride.robot == robot and ride.place in pair}
                if places.isdisjoint(set(pair) - taken):
                    yield tuple(step.renamed(names) if self.robot(step) == robot else step for step in steps)

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
        places: dict[str, list[str]] = {}
        for robot, place in self.rides(steps):
            places.setdefault(robot, []).append(place)
        return sum(self.distance(robot, own) for robot, own in places.items())

    def rides(self, steps: Sequence[Step]) -> Iterator[_Ride]:
        """Yields where the robots drive to."""
        for step in steps:
            for condition in self._task.skills[step.skill].post:
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


def _standing(view: WorldView, place: str) -> Point | None:
    """Returns where a robot stands when working at a place [m in the map]; None if unknown."""
    pose = driving_pose(view, place) if view.has(place) else None
    return None if pose is None else (pose.position[0], pose.position[1])

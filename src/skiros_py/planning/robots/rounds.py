"""Arranges the rounds of several robots, and their docking places, so that they do not block each other.

Places are exchanged for equivalent ones (parts of one thing, of one class) if that shortens the driving and the plan
remains valid.

A planner returns a sequence: first everything one robot does, then everything the next does. If both visit the same
places, the second then waits at each of them. The steps of a robot for one thing (fetch it, bring it) form a round;
rounds are rearranged one after the other, for the robot that is free first and such that each ends as early as
possible (greedy list scheduling).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import NamedTuple

from skiros_py.geometry import Pose
from skiros_py.planning.domain.model import Grounding
from skiros_py.planning.plan import Plan, Step
from skiros_py.planning.plan_validation import TaskState, grounded
from skiros_py.planning.problem.reachability import USUAL
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.planning.replay import replay
from skiros_py.planning.robots.allocation import Handling
from skiros_py.planning.robots.ordering import partial_order, schedule
from skiros_py.skills.conditions import Related
from skiros_py.world.poses import map_pose
from skiros_py.world.vocabulary import AT, DRIVING_POSE, HAS_A

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
    docking = _Docking(task)
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


class _Docking:
    """The robots' stops in a plan, and their alternatives."""

    def __init__(self, task: PlanningTask) -> None:
        self._view = task.view
        self._task = task

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
                    yield tuple(step.renamed(names) if _robot(self._task, step) == robot else step for step in steps)

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

    def _standing(self, place: str) -> Point | None:
        """Returns where a robot stands when working at a place [m in the map]; None if unknown."""
        if not self._view.has(place):
            return None
        pose, driving = map_pose(self._view, place), self._view.value(place, DRIVING_POSE)
        if pose is None or not isinstance(driving, Pose):
            return None
        x, y, _ = (pose @ driving).position
        return x, y


_MOST_ROUNDS = 40
"""Plans with more rounds are not rearranged: it would take seconds."""


@dataclass(frozen=True, slots=True)
class _Round:
    """The steps of one robot for one thing."""

    robot: str
    steps: tuple[Step, ...]


_Found = tuple[_Round, TaskState, list[Grounding], float]


def arranged(task: PlanningTask, plan: Plan, reached: Mapping[str, int]) -> Plan:
    """Returns the plan with its rounds in the sequence that ends soonest among those tried.

    Args:
        task: The planned task.
        plan: The steps, validated by replay, and their actions.
        reached: The highest sequence number that each robot has visited in this task.
    """
    steps = docking_nearer(task, plan.steps, reached)
    plan = plan if steps is plan.steps else Plan(steps, grounded(task, steps))
    arrangement = _Arrangement(task, plan.steps)
    if len({round_.robot for round_ in arrangement.rounds}) < 2 or len(arrangement.rounds) > _MOST_ROUNDS:
        return plan
    best = arrangement.best()
    if best is None or replay(task.view, best, task.conditions, task.skills, reached=reached) is not None:
        return plan
    other = Plan(best, grounded(task, best))
    return other if 0.0 < arrangement.lasts(other.groundings) < arrangement.lasts(plan.groundings) else plan


class _Arrangement:
    """The rounds of a plan, and their rearrangement."""

    def __init__(self, task: PlanningTask, steps: Sequence[Step]) -> None:
        self._task = task
        self.rounds = tuple(self._rounds(steps, Handling(task)))

    def lasts(self, plan: Sequence[Grounding]) -> float:
        """Returns how long a plan takes with maximum concurrency [s]."""
        return max(self._ends(plan), default=0.0)

    def best(self) -> tuple[Step, ...] | None:
        """Arranges the rounds; None if no tried sequence is valid."""
        left = list(self.rounds)
        steps: list[Step] = []
        state, taken = TaskState(self._task), list[Grounding]()
        ends = dict.fromkeys((round_.robot for round_ in left), 0.0)
        while left:
            found = None
            for robot in _free_first(ends, left):
                found = found or self._next(state, taken, left, robot)
            if found is None:
                return None
            round_, state, taken, ends[round_.robot] = found
            left.remove(round_)
            steps += round_.steps
        return tuple(steps)

    def _next(self, state: TaskState, taken: list[Grounding], left: Sequence[_Round], robot: str) -> _Found | None:
        """Returns the round of a robot that would end soonest if next, with the resulting state."""
        tried = [self._after(state, taken, round_) for round_ in left if round_.robot == robot]
        return min(filter(None, tried), key=lambda found: found[3], default=None)

    def _after(self, state: TaskState, taken: list[Grounding], round_: _Round) -> _Found | None:
        state = state.copy()
        more = [state.take(step) for step in round_.steps]
        if None in more:
            return None
        taken = [*taken, *filter(None, more)]
        return round_, state, taken, self._ends(taken)[-1]

    def _ends(self, plan: Sequence[Grounding]) -> list[float]:
        """Returns when each step of a plan ends with maximum concurrency [s]."""
        actions = [one.action for one in plan if one.action.skill is not None]
        durations = [USUAL if action.duration is None else action.duration for action in actions]
        starts = schedule(partial_order(plan, self._task.skills), durations)
        return [start + duration for start, duration in zip(starts, durations, strict=True)]

    def _rounds(self, steps: Sequence[Step], handling: Handling) -> Iterator[_Round]:
        """Splits a plan into rounds: a robot's steps up to the last one for a thing; its moves start the next round."""
        for robot in dict.fromkeys(_robot(self._task, step) for step in steps):
            own: list[Step] = []
            last, thing = 0, None
            for step in (step for step in steps if _robot(self._task, step) == robot):
                handled = self._thing(step, handling)
                if handled is not None and thing is not None and handled != thing:
                    yield _Round(robot, tuple(own[:last]))
                    own = own[last:]
                own.append(step)
                if handled is not None:
                    thing, last = handled, len(own)
            yield _Round(robot, tuple(own))

    def _thing(self, step: Step, handling: Handling) -> str | None:
        """Returns the thing a step moves or acts on; None for one that only moves its robot."""
        actions = (a for a in self._task.domain.actions if a.skill == step.skill)
        keys = (variable.lstrip("?") for a in actions for variable in handling.variables.get(a.name, ()))
        return next((step.arguments[key] for key in keys if key in step.arguments), None)


def _robot(task: PlanningTask, step: Step) -> str:
    """Returns the robot that runs a step."""
    agent = step.arguments[task.skills[step.skill].agent]
    return task.robots.get(agent, agent)


def _free_first(ends: Mapping[str, float], left: Sequence[_Round]) -> list[str]:
    """Returns the robots with remaining rounds, the one that is free first at the front."""
    busy = {round_.robot for round_ in left}
    return sorted(busy, key=lambda robot: (ends[robot], robot))

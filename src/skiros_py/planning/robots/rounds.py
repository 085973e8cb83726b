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
from dataclasses import dataclass, replace
from itertools import combinations, pairwise
from typing import NamedTuple

from skiros_py.geometry import Pose
from skiros_py.planning.domain.pddl import PddlTexts
from skiros_py.planning.plan import Plan, Step
from skiros_py.planning.plan_validation import TaskState, pddl_plan
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.planning.replay import replay
from skiros_py.planning.robots.allocation import Handling, teams
from skiros_py.planning.robots.ordering import makespan, partial_order, schedule
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
    docking = _Docking(view, task)
    for _ in range(_MOST):
        for steps in docking.shorter(plan.steps):
            if replay(view, steps, task.conditions, task.skills, reached=reached) is None:
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
        self._skills = task.skills
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


_MOST_ROUNDS = 40
"""Plans with more rounds are not rearranged: it would take seconds."""
_USUAL = 10.0
"""Assumed duration of a step with unknown duration [s]."""


@dataclass(frozen=True, slots=True)
class _Round:
    """The steps of one robot for one thing."""

    robot: str
    steps: tuple[Step, ...]


def arranged(
    view: WorldView, task: PlanningTask, texts: PddlTexts, plan: Plan, reached: Mapping[str, int] | None = None
) -> Plan:
    """Returns the plan with its rounds in the sequence that ends soonest among those tried.

    Args:
        view: The world that the plan starts from.
        task: The planned task.
        texts: The task as PDDL.
        plan: The steps, validated by replay.
        reached: The highest sequence number that each robot has visited in this task.
    """
    plan = docking_nearer(view, task, texts, plan, reached)
    arrangement = _Arrangement(view, task, texts, plan)
    rounds = arrangement.rounds
    if len({round_.robot for round_ in rounds}) < 2 or len(rounds) > _MOST_ROUNDS:
        return plan
    steps = arrangement.best()
    if steps is None:
        return plan
    if replay(view, steps, task.conditions, task.skills, reached=reached) is not None:
        return plan
    other = Plan(steps, pddl_plan(task, texts, steps, view.ontology))
    return other if 0.0 < arrangement.lasts(other.pddl) < arrangement.lasts(plan.pddl) else plan


class _Arrangement:
    """The rounds of a plan, and their rearrangement."""

    def __init__(self, view: WorldView, task: PlanningTask, texts: PddlTexts, plan: Plan) -> None:
        self._task = task
        self._texts = texts
        self._ontology = view.ontology
        self._robots = {agent: robot for robot, agents in teams(view, task).items() for agent in agents}
        self.rounds = tuple(self._rounds(plan.steps, Handling(task, view.ontology)))

    def lasts(self, lines: Sequence[str]) -> float:
        """Returns how long a plan takes with maximum concurrency [s]."""
        after = partial_order(self._texts, lines, self._task.skills)
        durations = self._durations(lines)
        return makespan(schedule(after, durations), durations)

    def best(self) -> tuple[Step, ...] | None:
        """Arranges the rounds; None if no tried sequence is valid."""
        left = list(self.rounds)
        state, steps, lines = TaskState(self._task, self._ontology), list[Step](), list[str]()
        ends = dict.fromkeys((round_.robot for round_ in left), 0.0)
        while left:
            found = None
            for robot in _free_first(ends, left):
                found = found or self._next(state, lines, left, robot)
            if found is None:
                return None
            round_, state, lines, ends[round_.robot] = found
            left.remove(round_)
            steps += round_.steps
        return tuple(steps)

    def _next(
        self, state: TaskState, lines: list[str], left: Sequence[_Round], robot: str
    ) -> tuple[_Round, TaskState, list[str], float] | None:
        """Returns the round of a robot that would end soonest if next, with the resulting state."""
        tried = [self._after(state, lines, round_) for round_ in left if round_.robot == robot]
        return min(filter(None, tried), key=lambda found: found[3], default=None)

    def _after(
        self, state: TaskState, lines: list[str], round_: _Round
    ) -> tuple[_Round, TaskState, list[str], float] | None:
        state, lines = state.copy(), list(lines)
        for step in round_.steps:
            taken = state.take(step)
            if taken is None:
                return None
            lines.append(taken.line(self._texts))
        after, durations = partial_order(self._texts, lines, self._task.skills), self._durations(lines)
        return round_, state, lines, schedule(after, durations)[-1] + durations[-1]

    def _durations(self, lines: Sequence[str]) -> list[float]:
        actions = (self._texts.actions[line.strip("()").split()[0]] for line in lines)
        return [_USUAL if a.duration is None else a.duration for a in actions if a.skill is not None]

    def _rounds(self, steps: Sequence[Step], handling: Handling) -> Iterator[_Round]:
        """Splits a plan into rounds: a robot's steps up to the last one for a thing; its moves start the next round."""
        for robot in dict.fromkeys(map(self._robot, steps)):
            own: list[Step] = []
            last, thing = 0, None
            for step in (step for step in steps if self._robot(step) == robot):
                handled = self._thing(step, handling)
                if handled is not None and thing is not None and handled != thing:
                    yield _Round(robot, tuple(own[:last]))
                    own = own[last:]
                own.append(step)
                if handled is not None:
                    thing, last = handled, len(own)
            yield _Round(robot, tuple(own))

    def _robot(self, step: Step) -> str:
        agent = step.arguments[self._task.skills[step.skill].agent]
        return self._robots.get(agent, agent)

    def _thing(self, step: Step, handling: Handling) -> str | None:
        """Returns the thing a step moves or acts on; None for one that only moves its robot."""
        actions = (a for a in self._task.domain.actions if a.skill == step.skill)
        keys = (variable.lstrip("?") for a in actions for variable in handling.variables.get(a.name, ()))
        return next((step.arguments[key] for key in keys if key in step.arguments), None)


def _free_first(ends: Mapping[str, float], left: Sequence[_Round]) -> list[str]:
    """Returns the robots with remaining rounds, the one that is free first at the front."""
    busy = {round_.robot for round_ in left}
    return sorted(busy, key=lambda robot: (ends[robot], robot))

"""Arranges the rounds of several robots so that they do not block each other.

A planner returns a sequence: first everything one robot does, then everything the next does. If both visit the same
places, the second then waits at each of them. The steps of a robot for one thing (fetch it, bring it) form a round;
rounds are rearranged one after the other, for the robot that is free first and such that each ends as early as
possible (greedy list scheduling).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from skiros_py.planning.domain.pddl import PddlTexts
from skiros_py.planning.plan import Plan, Step
from skiros_py.planning.plan_validation import replay
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.planning.regrounding import TaskState, pddl_plan
from skiros_py.planning.robots.allocation import teams
from skiros_py.planning.robots.docks import docking_nearer
from skiros_py.planning.robots.handling import Handling
from skiros_py.planning.robots.ordering import makespan, partial_order, schedule
from skiros_py.skills.skill import SkillDescription
from skiros_py.world.view import WorldView

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
    if replay(view, steps, task.conditions, arrangement.skills, reached=reached) is not None:
        return plan
    other = Plan(steps, pddl_plan(task, texts, steps, view.ontology))
    return other if 0.0 < arrangement.lasts(other.pddl) < arrangement.lasts(plan.pddl) else plan


class _Arrangement:
    """The rounds of a plan, and their rearrangement."""

    def __init__(self, view: WorldView, task: PlanningTask, texts: PddlTexts, plan: Plan) -> None:
        self.skills: Mapping[str, SkillDescription] = {c.skill.name: c.skill for c in task.capabilities}
        self._task = task
        self._texts = texts
        self._ontology = view.ontology
        self._robots = {agent: robot for robot, agents in teams(view, task).items() for agent in agents}
        self.rounds = tuple(self._rounds(plan.steps, Handling(task, view.ontology)))

    def lasts(self, lines: Sequence[str]) -> float:
        """Returns how long a plan takes with maximum concurrency [s]."""
        after = partial_order(self._texts, lines, self.skills)
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
        after, durations = partial_order(self._texts, lines, self.skills), self._durations(lines)
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
        agent = step.arguments[self.skills[step.skill].agent]
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

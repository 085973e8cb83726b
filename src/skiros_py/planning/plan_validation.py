"""Validates planners' answers by replaying them; finds the actions of the PDDL task that a plan of skills stands for.

Removed detours change the state that later steps start from, so the planner's own actions may no longer be valid.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from itertools import product
from types import MappingProxyType

from skiros_py.errors import PlanningError
from skiros_py.planning.domain.actions import passed_keys
from skiros_py.planning.domain.matching import is_variable, solutions
from skiros_py.planning.domain.model import Action, Atom, Grounding
from skiros_py.planning.domain.numbers import ASSIGN, DECREASE, change_of, number_compared, numbers_in
from skiros_py.planning.domain.pddl import PddlTexts
from skiros_py.planning.plan import Plan, Step
from skiros_py.planning.planners.planner import Solved
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.planning.replay import Flaw, Simulation


def grounded(task: PlanningTask, steps: Sequence[Step]) -> tuple[Grounding, ...]:
    """Returns the actions that a plan stands for, with the goal's bookkeeping at the end.

    Args:
        task: The task.
        steps: The skills to run, in order; they lead to the goal.

    Returns:
        The actions; empty if the task is stricter than the conditions and has no such plan.
    """
    state = TaskState(task)
    taken = [state.take(step) for step in steps]
    closing = state.close()
    return () if None in taken or closing is None else (*filter(None, taken), *closing)


class TaskState:
    """The state of a task while its actions are applied one after the other."""

    def __init__(self, task: PlanningTask) -> None:
        self._task = task
        self._facts: dict[str, dict[Atom, None]] = {}
        self._numbers = numbers_in(task.problem.init)
        actions = task.domain.actions
        self._changing = {atom.predicate for action in actions for atom in (*action.add, *action.delete)}
        self._changing |= {predicate for predicate in task.asked if number_compared(predicate) is not None}
        self._become(task.problem.init)

    def copy(self) -> TaskState:
        """Returns a copy of the state."""
        other = copy(self)
        changing = {name: dict(self._facts[name]) for name in self._changing if name in self._facts}
        vars(other).update(_facts=self._facts | changing, _numbers=dict(self._numbers))
        return other

    def changing(self, atoms: Iterable[Atom]) -> frozenset[Atom]:
        """Returns those of some atoms that some action can change."""
        return frozenset(atom for atom in atoms if atom.predicate in self._changing)

    def candidates(self, atom: Atom) -> Collection[Atom]:
        """Returns a superset of the facts that match an atom with variables."""
        facts = self._facts.get(atom.predicate, {})
        return facts if any(map(is_variable, atom.arguments)) else [fact for fact in (atom,) if fact in facts]

    def take(self, step: Step) -> Grounding | None:
        """Applies the first of the skill's actions applicable now with a step's arguments; None if none is."""
        taken = self.possible(step)
        if taken is not None:
            self._apply(taken)
        return taken

    def possible(self, step: Step) -> Grounding | None:
        """Returns the first of the skill's actions applicable now with a step's arguments; None if none is."""
        choices = [action for action in self._task.domain.actions if action.skill == step.skill]
        given = {f"?{key}": value for key, value in step.arguments.items()}
        return next((one for action in choices for one in self._possible(action, given)), None)

    def close(self) -> list[Grounding] | None:
        """Applies bookkeeping actions until the goal is reached.

        Returns:
            The actions that the goal needs, or None if it cannot be reached.
        """
        closing = [action for action in self._task.domain.actions if action.skill is None]
        goal = self._task.problem.goal
        taken: list[Grounding] = []
        before = -1
        while not self.holds(goal) and len(taken) > before:
            before = len(taken)
            for one in (one for action in closing for one in list(self._possible(action, {}))):
                if not self.holds(one.of(one.action.add)):
                    self._apply(one)
                    taken.append(one)
        return _needed(taken, goal) if self.holds(goal) else None

    def _possible(self, action: Action, given: Mapping[str, str]) -> Iterator[Grounding]:
        """Yields the applicable groundings of an action; for a parameter in no atom, any element will do."""
        fits, types = self._task.fits, action.types
        for found in solutions(action.pre, self, given, types, fits):
            there = (solutions(such.bind(found).atoms, self, {}, types, fits) for such in action.none)
            if any(next(ways, None) is not None for ways in there):
                continue
            free = [variable for variable in action.parameters if variable.name not in found]
            fitting = ([e for e in self._task.problem.objects if fits(e, variable.type)] for variable in free)
            for elements in product(*fitting):
                further = {variable.name: element for variable, element in zip(free, elements, strict=True)}
                yield Grounding(action, found | further)

    def apply(self, deletes: Iterable[Atom], adds: Iterable[Atom]) -> None:
        """Applies what an action deletes and adds."""
        for atom in deletes:
            self._facts.get(atom.predicate, {}).pop(atom, None)
        self._become(adds)

    def _apply(self, one: Grounding) -> None:
        self.apply(one.of(one.action.delete), one.of(one.action.add))
        for change in (atom.bind(one.binding) for atom in one.action.changes):
            self._count(change)

    def _count(self, change: Atom) -> None:
        """Changes a number, and every comparison of it."""
        word, property_, by = change_of(change)
        element = change.arguments[0]
        if (property_, element) not in self._numbers:
            return  # no action raises or lowers it: all about it is among the facts
        amount = self._numbers[by, change.arguments[-1]] if isinstance(by, str) else by
        before = 0.0 if word == ASSIGN else self._numbers[property_, element]
        number = self._numbers[property_, element] = round(before - amount if word == DECREASE else before + amount, 9)
        for predicate in self._task.asked:
            compared = number_compared(predicate)
            if compared is not None and compared[0] == property_:
                atom = Atom(predicate, (element,))
                if compared[1].allows(number):
                    self._become((atom,))
                else:
                    self._facts.get(predicate, {}).pop(atom, None)

    def _become(self, atoms: Iterable[Atom]) -> None:
        for atom in sorted(atoms):
            self._facts.setdefault(atom.predicate, {})[atom] = None

    def holds(self, atoms: Iterable[Atom]) -> bool:
        """Returns whether all of some atoms are facts."""
        return all(map(self.candidates, atoms))


def _needed(taken: Sequence[Grounding], goal: Iterable[Atom]) -> list[Grounding]:
    """Removes actions the goal does not need."""
    wanted = set(goal)
    kept: list[Grounding] = []
    for one in reversed(taken):
        if not wanted.isdisjoint(one.of(one.action.add)):
            wanted |= one.of(one.action.pre)
            kept.append(one)
    return kept[::-1]


_LONGEST = 10_000
"""Longer answers are rejected."""
_STREAMLINED = 300
"""Detours are not removed from longer plans: the search takes quadratic time."""


# ------------------------------------------------------------------ planners' answers


@dataclass(frozen=True, slots=True)
class Wrong:
    """An answer that is not a valid plan for the task.

    Attributes:
        steps: Its steps.
        flaw: Where it fails.
    """

    steps: tuple[Step, ...]
    flaw: Flaw

    def __str__(self) -> str:
        step = self.flaw.step
        if not self.steps:
            return f"is empty: {self.flaw.verdict.text}"
        where = "the end" if step is None else f"step {step + 1} ({self.steps[step]})"
        return f"breaks at {where}: {self.flaw.verdict.text}"


def read_plan(task: PlanningTask, texts: PddlTexts, answer: Solved) -> tuple[Step, ...]:
    """Turns a planner's answer back into skills; omits auxiliary actions and parameters that are not passed on.

    Raises:
        PlanningError: It refers to things not in the task.
    """
    steps: list[Step] = []
    for step in map(texts.grounding, answer.steps):
        if step.action.skill is not None:
            keys = passed_keys(task.skills[step.action.skill])
            steps.append(Step(step.action.skill, MappingProxyType({key: step.binding[f"?{key}"] for key in keys})))
    return tuple(steps)


def validate(
    task: PlanningTask, texts: PddlTexts, answer: Solved, reached: Mapping[str, int] | None = None
) -> Plan | Wrong:
    """Validates a planner's answer: parses it, replays it, and removes detours.

    Args:
        task: The task.
        texts: The task as PDDL.
        answer: The planner's answer.
        reached: The highest sequence number that each robot has visited in this task.

    Raises:
        PlanningError: It refers to things not in the task, or is too long.
    """
    if len(answer.steps) > _LONGEST:
        raise PlanningError(f"the planner answered with {len(answer.steps)} steps: no plan is that long")
    steps = read_plan(task, texts, answer)
    before: list[Simulation] | None = [] if len(steps) <= _STREAMLINED else None
    flaw = Simulation(task.view, task.conditions, task.skills, reached).run(steps, before)
    if flaw is not None:
        return Wrong(steps, flaw)
    if before is not None:
        steps = _without_detours(steps, before)
    return Plan(steps, grounded(task, steps))


def _without_detours(steps: Sequence[Step], before: Sequence[Simulation]) -> tuple[Step, ...]:
    """Removes steps without which the plan still leads to the goal (satisficing planners may take detours).

    Args:
        steps: The plan.
        before: The simulation before each of them; it goes on from there.
    """
    kept: tuple[Step, ...] = ()
    for step, simulation in zip(reversed(steps), reversed(before), strict=True):
        if simulation.run(kept) is not None:
            kept = (step, *kept)
    return kept

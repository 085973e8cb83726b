"""Validates planners' answers by replaying them; converts plans of skills back to their PDDL task.

Removed detours change the state that later steps start from, so the planner's own lines may no longer be valid.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

from skiros_py.errors import PlanningError
from skiros_py.planning.domain.actions import passed_keys
from skiros_py.planning.domain.matching import Fits, unified
from skiros_py.planning.domain.model import Action, Atom, NoneSuch, Variable
from skiros_py.planning.domain.pddl import PddlTexts
from skiros_py.planning.plan import Plan, Step, read_plan
from skiros_py.planning.planners.planner import Solved
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.planning.replay import Flaw, Simulation
from skiros_py.world.ontology import Ontology
from skiros_py.world.view import WorldView


def pddl_plan(task: PlanningTask, texts: PddlTexts, steps: Sequence[Step], ontology: Ontology) -> tuple[str, ...]:
    """Writes the plan in the task's PDDL names, with the goal's bookkeeping actions at its end, in planner format.

    The conditions decide whether a plan is valid, not this text: if the task is stricter than the conditions and has
    no such plan, the text is empty.

    Args:
        task: The task.
        texts: The task as PDDL, for its names.
        steps: The skills to run, in order; they lead to the goal.
        ontology: Classes.
    """
    run = TaskState(task, ontology)
    taken = [run.take(step) for step in steps]
    closing = run.close([a for a in task.domain.actions if a.skill is None], task.problem.goal)
    if None in taken or closing is None:
        return ()
    return tuple(one.line(texts) for one in (*filter(None, taken), *closing))


class Taken(NamedTuple):
    """An applied action.

    Attributes:
        action: The action.
        binding: Element by parameter.
    """

    action: Action
    binding: Mapping[str, str]

    @property
    def elements(self) -> tuple[str, ...]:
        """Its elements, in the order of its parameters."""
        return tuple(self.binding[variable.name] for variable in self.action.parameters)

    def line(self, texts: PddlTexts) -> str:
        """Formats it as planners do."""
        name = next(word for word, action in texts.actions.items() if action.name == self.action.name)
        return f"({' '.join([name, *map(texts.objects.pddl, self.elements)])})"

    def of(self, atoms: Iterable[Atom]) -> set[Atom]:
        """Grounds atoms of the action with these elements."""
        return {atom.bind(self.binding) for atom in atoms}


class TaskState:
    """The state of the task while its actions are applied one after the other."""

    def __init__(self, task: PlanningTask, ontology: Ontology) -> None:
        self._actions = task.domain.actions
        self._objects = task.problem.objects
        self._ontology = ontology
        self._facts: dict[str, dict[Atom, None]] = {}
        self._become(sorted(task.problem.init))

    def copy(self) -> TaskState:
        """Returns a copy of the state."""
        other = copy(self)
        vars(other).update(_facts={predicate: dict(atoms) for predicate, atoms in self._facts.items()})
        return other

    def take(self, step: Step) -> Taken | None:
        """Applies the first of the skill's actions applicable now with a step's arguments; None if none is."""
        choices = [action for action in self._actions if action.skill == step.skill]
        given = {f"?{key}": value for key, value in step.arguments.items()}
        possible = (one for action in choices for one in self._possible(action, given))
        taken = next(possible, None)
        if taken is not None:
            self._apply(taken)
        return taken

    def close(self, closing: Sequence[Action], goal: Iterable[Atom]) -> list[Taken] | None:
        """Applies bookkeeping actions until the goal is reached.

        Returns:
            The actions applied, or None if it cannot be reached.
        """
        taken: list[Taken] = []
        before = -1
        while not all(map(self._holds, goal)) and len(taken) > before:
            before = len(taken)
            for one in (one for action in closing for one in list(self._possible(action, {}))):
                if not all(map(self._holds, one.of(one.action.add))):
                    self._apply(one)
                    taken.append(one)
        return _needed(taken, goal) if all(map(self._holds, goal)) else None

    def _possible(self, action: Action, given: Mapping[str, str]) -> Iterator[Taken]:
        """Yields the applicable groundings of an action; for a parameter in no atom, any element will do."""
        facts = {predicate: tuple(atoms) for predicate, atoms in self._facts.items()}
        for found in bindings(action.pre, facts, given, action.types, self._fits):
            if are_none(action.none, facts, found, self._fits):
                free = [variable for variable in action.parameters if variable.name not in found]
                for elements in product(*(self._fitting(variable) for variable in free)):
                    names = (variable.name for variable in free)
                    yield Taken(action, {**found, **dict(zip(names, elements, strict=True))})

    def _apply(self, one: Taken) -> None:
        for atom in one.of(one.action.delete):
            self._facts.get(atom.predicate, {}).pop(atom, None)
        self._become(sorted(one.of(one.action.add)))

    def _become(self, atoms: Iterable[Atom]) -> None:
        for atom in atoms:
            self._facts.setdefault(atom.predicate, {})[atom] = None

    def _holds(self, atom: Atom) -> bool:
        return atom in self._facts.get(atom.predicate, ())

    def _fitting(self, variable: Variable) -> list[str]:
        return [element for element in self._objects if self._fits(element, variable.type)]

    def _fits(self, element: str, class_: str) -> bool:
        return class_ in ("", "object") or self._ontology.is_a(self._objects[element], class_)


def _needed(taken: Sequence[Taken], goal: Iterable[Atom]) -> list[Taken]:
    """Removes actions the goal does not need."""
    wanted = set(goal)
    kept: list[Taken] = []
    for one in reversed(taken):
        if not wanted.isdisjoint(one.of(one.action.add)):
            wanted |= one.of(one.action.pre)
            kept.append(one)
    return kept[::-1]


def bindings(
    atoms: Sequence[Atom],
    facts: Mapping[str, Sequence[Atom]],
    start: Mapping[str, str],
    types: Mapping[str, str],
    fits: Fits,
) -> Iterator[dict[str, str]]:
    """Yields every way to bind variables so that all atoms are facts.

    Args:
        atoms: Atoms over variables ("?Robot") and elements.
        facts: Facts by predicate; a predicate may gain facts while this is read.
        start: What is bound already.
        types: Class by variable.
        fits: Tells whether an element is of a class.
    """
    if not atoms:
        yield dict(start)
        return
    for fact in list(facts.get(atoms[0].predicate, ())):
        matched = unified(atoms[0], fact, start, types, fits)
        if matched is not None:
            yield from bindings(atoms[1:], facts, matched, types, fits)


def are_none(
    none: Iterable[NoneSuch], facts: Mapping[str, Sequence[Atom]], binding: Mapping[str, str], fits: Fits
) -> bool:
    """Returns whether there are no such things among the facts.

    Args:
        none: What there must not be.
        facts: Facts by predicate.
        binding: What the variables around are bound to.
        fits: Tells whether an element is of a class.
    """
    for such in none:
        types = {variable.name: variable.type for variable in such.variables}
        if next(bindings(such.bind(binding).atoms, facts, {}, types, fits), None) is not None:
            return False
    return True


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


def validate(
    view: WorldView,
    task: PlanningTask,
    texts: PddlTexts,
    answer: Solved,
    reached: Mapping[str, int] | None = None,
) -> Plan | Wrong:
    """Validates a planner's answer: parses it, replays it, and removes detours.

    Args:
        view: The world.
        task: The task.
        texts: The task as PDDL.
        answer: The planner's answer.
        reached: The highest sequence number that each robot has visited in this task.

    Raises:
        PlanningError: It refers to things not in the task, or is too long.
    """
    if len(answer.steps) > _LONGEST:
        raise PlanningError(f"the planner answered with {len(answer.steps)} steps: no plan is that long")
    _check_objects(texts, answer)
    keys = {name: passed_keys(skill) for name, skill in task.skills.items()}
    steps = read_plan(answer.steps, texts, keys)
    before: list[Simulation] | None = [] if len(steps) <= _STREAMLINED else None
    flaw = Simulation(view, task.conditions, task.skills, reached).run(steps, before)
    if flaw is not None:
        return Wrong(steps, flaw)
    if before is not None:
        steps = _without_detours(steps, before)
    lines = pddl_plan(task, texts, steps, view.ontology)
    return Plan(steps, lines)


def _check_objects(texts: PddlTexts, answer: Solved) -> None:
    for name, *objects in answer.steps:
        action = texts.actions.get(name.lower())
        if action is not None and len(objects) != len(action.parameters):
            step = " ".join([name, *objects])
            raise PlanningError(
                f"the planner answered with ({step}), but {name} takes {len(action.parameters)} objects"
            )


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

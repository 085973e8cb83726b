"""The facts that could ever become true if nothing were ever undone (delete relaxation), and the time to each.

The additive heuristic of Bonet and Geffner (2001), spread from the cheapest fact to the dearest as Knuth (1977) does:
a fact costs as much as the cheapest action that achieves it, including that action's preconditions.

Indistinguishable things can be treated as one, so that five hundred parts cost no more than a few.
"""

from __future__ import annotations

import heapq
from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import count, islice, product
from math import inf

from skiros_py.planning.domain.literals import CAN
from skiros_py.planning.domain.matching import Binding, FactIndex, is_variable, solutions, unified
from skiros_py.planning.domain.model import Action, Atom, Variable
from skiros_py.planning.problem.stock import signs
from skiros_py.planning.problem.task import PlanningTask

USUAL = 10.0
"""Assumed duration of a skill with unknown duration [s]."""
_FEW = 40
"""Up to this many objects none are grouped: finding indistinguishable ones would cost more."""


class Relaxation:
    """The facts of a task that could ever become true.

    Args:
        task: The task.
        agents: The agents that may act; None for all.
        together: True to group indistinguishable things; False if their number matters.
        timed: True to estimate times; otherwise all are 0.

    Attributes:
        task: The task.
        facts: The facts; of indistinguishable things, those of one representative.
        cost: The estimated time to each [s].
    """

    def __init__(
        self,
        task: PlanningTask,
        agents: Collection[str] | None = None,
        *,
        together: bool = False,
        timed: bool = False,
    ) -> None:
        self.task = task
        self.facts = FactIndex()
        self.cost: dict[Atom, float] = {}
        self.fits = task.fits
        self._timed = timed
        self._like = _alike(task) if together else {thing: (thing,) for thing in task.problem.objects}
        self._types = {action.name: action.types for action in task.domain.actions}
        self._uses: dict[str, list[tuple[Action, int]]] = {}
        self._best: dict[Atom, float] = {}
        self._waiting: list[tuple[float, int, Atom]] = []
        self._order = count()
        for action in task.domain.actions:
            if all(self.is_some(variable.type) for variable in action.parameters):
                for index, atom in enumerate(action.pre):
                    self._uses.setdefault(atom.predicate, []).append((action, index))
                if not action.pre:
                    self._extend(action, (), {}, self._duration(action))
        for atom in sorted(task.problem.init):
            is_allowed = agents is None or not atom.predicate.startswith(CAN) or atom.arguments[0] in agents
            if is_allowed and self._like.keys() >= set(atom.arguments):
                self._offer(atom, 0.0)
        self._grow()

    def is_some(self, class_: str) -> bool:
        """Returns whether there is any object of a class."""
        return any(self.fits(thing, class_) for thing in self._like)

    def alike(self, element: str) -> tuple[str, ...]:
        """Returns the objects that an element represents, itself first."""
        return self._like.get(element, (element,))

    def ways(
        self, action: Action, atoms: Sequence[Atom], start: Binding, types: Mapping[str, str], limit: int
    ) -> list[dict[str, str]]:
        """Returns bindings that make atoms of an action true together, up to a limit.

        Args:
            action: The action.
            atoms: Some of its preconditions.
            start: The initial binding.
            types: Class by variable, perhaps narrower than the action's own.
            limit: How many at most.
        """
        return list(islice(solutions(atoms, self.facts, start, {**action.types, **types}, self.fits), limit))

    # ------------------------------------------------------------ growing

    def _grow(self) -> None:
        while self._waiting:
            cost, _, fact = heapq.heappop(self._waiting)
            if fact not in self.cost:
                self.cost[fact] = cost
                self.facts.add(fact)
                for action, index in self._uses.get(fact.predicate, ()):
                    self._fire(action, index, fact)

    def _offer(self, atom: Atom, cost: float) -> None:
        if cost < self._best.get(atom, inf):
            self._best[atom] = cost
            heapq.heappush(self._waiting, (cost, next(self._order), atom))

    def _fire(self, action: Action, index: int, fact: Atom) -> None:
        """Queues the effects of an action of which the fact was the last missing precondition."""
        binding = unified(action.pre[index], fact, {}, self._types[action.name], self.fits)
        if binding is not None:
            rest = (*action.pre[:index], *action.pre[index + 1 :])
            self._extend(action, rest, binding, self.cost[fact] + self._duration(action))

    def _duration(self, action: Action) -> float:
        if not self._timed or action.skill is None or action.costs is not None:
            return 0.0  # learned costs depend on the elements: they are added as soon as these are known
        return USUAL if action.duration is None else action.duration

    def _extend(self, action: Action, rest: Sequence[Atom], binding: dict[str, str], cost: float) -> None:
        """Satisfies the remaining preconditions in every way and queues the resulting effects.

        Variables not used afterwards, such as the place that is left, are bound to the cheapest value only.
        """
        adds = [atom.bind(binding) for atom in action.add]
        if all(self._best.get(atom, inf) <= cost for atom in adds):
            return
        if not rest:
            if self._timed and action.costs is not None:
                known = action.seconds(binding)
                cost += USUAL if known is None else known
            for atom in adds:
                self._offer_all(atom, action, cost)
            return
        found = [self.facts.candidates(atom.bind(binding)) for atom in rest]
        rarest = min(range(len(rest)), key=lambda i: len(found[i]))
        others = (*rest[:rarest], *rest[rarest + 1 :])
        used = {argument for atom in (*action.add, *others) for argument in atom.arguments}
        matters = any(is_variable(a) and a not in binding and a in used for a in rest[rarest].arguments)
        for fact in tuple(found[rarest]):
            further = unified(rest[rarest], fact, binding, self._types[action.name], self.fits)
            if further is not None:
                self._extend(action, others, further, cost + self.cost[fact])
                if not matters:
                    return

    def _offer_all(self, atom: Atom, action: Action, cost: float) -> None:
        """Offers an atom for every value of variables that occur in no precondition."""
        free = [v for v in action.parameters if v.name in atom.arguments]
        for values in product(*(self._of(variable) for variable in free)):
            self._offer(atom.bind({v.name: value for v, value in zip(free, values, strict=True)}), cost)

    def _of(self, variable: Variable) -> Iterator[str]:
        return (thing for thing in self._like if self.fits(thing, variable.type))


def _alike(task: PlanningTask) -> dict[str, tuple[str, ...]]:
    """Returns a representative of each group of indistinguishable objects, with the group; goals name their own."""
    objects = task.problem.objects
    if len(objects) <= _FEW:
        return {thing: (thing,) for thing in objects}
    named = {a for _, atoms in task.goal for atom in atoms for a in atom.arguments}
    named |= {a for condition in task.conditions for a in condition.arguments}
    named |= {
        a for action in task.domain.actions for atom in action.atoms for a in atom.arguments if not is_variable(a)
    }
    said = signs([thing for thing in objects if thing not in named], objects, task.problem.init)
    groups: dict[object, list[str]] = {}
    for thing in objects:
        groups.setdefault(said.get(thing, thing), []).append(thing)
    return {group[0]: tuple(group) for group in groups.values()}

"""Estimates how long facts take to achieve, ignoring that skills undo things: a quick estimate before planning.

The additive heuristic of Bonet and Geffner (2001), spread from the cheapest fact to the dearest as Knuth (1977) does:
a fact costs as much as the cheapest action that achieves it, including that action's preconditions.
"""

from __future__ import annotations

import heapq
from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import cache

from skiros_py.planning.domain.literals import CAN
from skiros_py.planning.domain.model import Action, Atom
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.world.ontology import Ontology

USUAL = 10.0
"""Assumed duration of a skill with unknown duration [s]."""

Binding = dict[str, str]


def efforts(task: PlanningTask, ontology: Ontology, agents: Collection[str] | None = None) -> Mapping[Atom, float]:
    """Returns the estimated time [s] to every reachable fact.

    Args:
        task: The task.
        ontology: Classes.
        agents: The agents that may act; default: all.
    """
    spread = _Spread(task, ontology)
    for atom in sorted(task.problem.init):
        if agents is None or not atom.predicate.startswith(CAN) or atom.arguments[0] in agents:
            spread.offer(atom, 0.0)
    spread.run()
    return spread.settled


class _Spread:
    """Facts with their costs, settled in order of cost."""

    def __init__(self, task: PlanningTask, ontology: Ontology) -> None:
        self.settled: dict[Atom, float] = {}
        self._waiting: list[tuple[float, Atom]] = []
        self._best: dict[Atom, float] = {}
        self._by_predicate: dict[str, list[Atom]] = {}
        self._by_argument: dict[tuple[str, int, str], list[Atom]] = {}
        self._needs: dict[str, list[tuple[Action, int]]] = {}
        for action in task.domain.actions:
            for place, atom in enumerate(action.pre):
                self._needs.setdefault(atom.predicate, []).append((action, place))
        objects = task.problem.objects
        self._is_a = cache(lambda type_, class_: class_ in ("", "object") or ontology.is_a(type_, class_))
        self._fits = cache(lambda element, class_: element in objects and self._is_a(objects[element], class_))

    def offer(self, atom: Atom, cost: float) -> None:
        if cost < self._best.get(atom, float("inf")):
            self._best[atom] = cost
            heapq.heappush(self._waiting, (cost, atom))

    def run(self) -> None:
        while self._waiting:
            cost, atom = heapq.heappop(self._waiting)
            if atom not in self.settled:
                self._settle(atom, cost)
                for action, place in self._needs.get(atom.predicate, ()):
                    self._apply(action, place, atom)

    def _settle(self, atom: Atom, cost: float) -> None:
        self.settled[atom] = cost
        self._by_predicate.setdefault(atom.predicate, []).append(atom)
        for place, argument in enumerate(atom.arguments):
            self._by_argument.setdefault((atom.predicate, place, argument), []).append(atom)

    def _apply(self, action: Action, place: int, fact: Atom) -> None:
        """Queues the effects of an action whose last precondition has just been settled."""
        types = action.types
        start = self._matched(action.pre[place], fact, {}, types)
        if start is None:
            return
        given = {argument for atom in action.add for argument in atom.arguments}
        rest = (*action.pre[:place], *action.pre[place + 1 :])
        own = 0.0 if action.skill is None else USUAL if action.duration is None else action.duration
        for binding, cost in self._joined(rest, start, types, given):
            for atom in action.add:
                effect = atom.bind(binding)
                if not any(argument.startswith("?") for argument in effect.arguments):
                    self.offer(effect, cost + self.settled[fact] + own)

    def _joined(
        self, atoms: Sequence[Atom], binding: Binding, types: Mapping[str, str], given: set[str]
    ) -> Iterator[tuple[Binding, float]]:
        """Yields bindings that make the atoms settled facts, with their total cost.

        Variables not used afterwards, such as the place that is left, are bound to the cheapest value only.
        """
        if not atoms:
            yield binding, 0.0
            return
        found = [self._candidates(atom, binding) for atom in atoms]
        at = min(range(len(atoms)), key=lambda i: len(found[i]))
        rest = (*atoms[:at], *atoms[at + 1 :])
        asked = given.union(*(atom.arguments for atom in rest))
        matters = any(a.startswith("?") and a not in binding and a in asked for a in atoms[at].arguments)
        for fact in tuple(found[at]):
            matched = self._matched(atoms[at], fact, binding, types)
            if matched is None:
                continue
            for result, cost in self._joined(rest, matched, types, given):
                yield result, cost + self.settled[fact]
            if not matters:
                return

    def _candidates(self, atom: Atom, binding: Binding) -> Sequence[Atom]:
        """The smallest indexed set of settled facts that contains all matches of the atom."""
        bound = [(at, binding.get(a, a)) for at, a in enumerate(atom.arguments)]
        known = [(at, value) for at, value in bound if not value.startswith("?")]
        if not known:
            return self._by_predicate.get(atom.predicate, ())
        return min((self._by_argument.get((atom.predicate, at, v), ()) for at, v in known), key=len)

    def _matched(self, atom: Atom, fact: Atom, binding: Binding, types: Mapping[str, str]) -> Binding | None:
        result = dict(binding)
        for argument, value in zip(atom.arguments, fact.arguments, strict=True):
            if not argument.startswith("?"):
                if argument != value:
                    return None
            elif result.setdefault(argument, value) != value or not self._fits(value, types.get(argument, "")):
                return None
        return result

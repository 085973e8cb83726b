"""Facts that could ever become true (delete relaxation), and pairs of them that can never hold together.

Indistinguishable things are treated as one, so that five hundred parts cost no more than a few.

Finds conflicts that follow from several skills together: a robot that drives only with empty hands cannot hold a part
from one place and stand in another.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, islice, product

import numpy as np
from numpy.typing import NDArray

from skiros_py.planning.domain.matching import Binding, FactIndex, is_variable, solutions, unified
from skiros_py.planning.domain.model import Action, Atom, Variable
from skiros_py.planning.problem.stock import signs
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.skills.conditions import Condition
from skiros_py.world.ontology import Ontology

_FEW = 40
"""Up to this many objects none are grouped: finding indistinguishable ones would cost more."""


def relax(task: PlanningTask, ontology: Ontology, *, together: bool = True) -> Relaxation:
    """Returns the facts that could ever become true."""
    relaxed = Relaxation(task, ontology, together=together)
    relaxed.grow()
    return relaxed


class Relaxation:
    """The facts that could ever become true, once :meth:`grow` has come to its end.

    Args:
        task: The task.
        ontology: Classes.
        together: True to group indistinguishable things; False if their number matters.

    Attributes:
        facts: These facts; of indistinguishable things, those of one representative.
        task: The task.
    """

    def __init__(self, task: PlanningTask, ontology: Ontology, *, together: bool = True) -> None:
        self.task = task
        self.facts = FactIndex()
        self._ontology = ontology
        self._types = dict(task.problem.objects)
        self._fitting: dict[tuple[str, str], bool] = {}
        self._like = _alike(task) if together else {thing: (thing,) for thing in task.problem.objects}
        self._objects = list(self._like)
        self._uses: dict[str, list[tuple[Action, int]]] = {}
        self._new: deque[Atom] = deque()
        self._known: set[Atom] = set()
        self._begin()

    # ------------------------------------------------------------ asking

    def fits(self, element: str, class_: str) -> bool:
        """Returns whether an object is of a class; the empty class matches any. Removed objects are of none."""
        if class_ in ("", "object"):
            return True
        if element not in self._types:
            return False
        key = self._types[element], class_
        if key not in self._fitting:
            self._fitting[key] = self._ontology.is_a(*key)
        return self._fitting[key]

    def is_some(self, class_: str) -> bool:
        """Returns whether there is any object of a class."""
        return any(self.fits(thing, class_) for thing in self._objects)

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

    def grow(self) -> None:
        """Computes all reachable facts."""
        while self._new:
            self._take(self._new.popleft())

    def _begin(self) -> None:
        for action in self.task.domain.actions:
            if not all(self.is_some(v.type) for v in action.parameters):
                continue
            for index, atom in enumerate(action.pre):
                self._uses.setdefault(atom.predicate, []).append((action, index))
            if not action.pre:
                self._extend(action, (), {})
        kept = set(self._objects)
        for atom in sorted(self.task.problem.init):
            if kept.issuperset(atom.arguments):
                self._learn(atom)

    def _learn(self, atom: Atom) -> None:
        if atom not in self._known:
            self._known.add(atom)
            self._new.append(atom)

    def _take(self, fact: Atom) -> None:
        """Fires the actions of which the fact was the last missing precondition."""
        self.facts.add(fact)
        for action, index in self._uses.get(fact.predicate, ()):
            binding = unified(action.pre[index], fact, {}, action.types, self.fits)
            if binding is not None:
                rest = tuple(atom for i, atom in enumerate(action.pre) if i != index)
                self._extend(action, rest, binding)

    def _extend(self, action: Action, rest: Sequence[Atom], binding: dict[str, str]) -> None:
        """Satisfies the remaining preconditions in every way and adds the resulting effects."""
        adds = [atom.bind(binding) for atom in action.add]
        if all(atom in self._known for atom in adds):
            return
        if not rest:
            for atom in adds:
                self._learn_all(atom, action)
            return
        found = [self.facts.candidates(atom.bind(binding)) for atom in rest]
        rarest = min(range(len(rest)), key=lambda i: len(found[i]))
        others = tuple(atom for i, atom in enumerate(rest) if i != rarest)
        for fact in tuple(found[rarest]):
            further = unified(rest[rarest], fact, binding, action.types, self.fits)
            if further is not None:
                self._extend(action, others, further)

    def _learn_all(self, atom: Atom, action: Action) -> None:
        """Adds an atom for every value of variables that occur in no precondition."""
        free = [v for v in action.parameters if v.name in atom.arguments]
        for values in product(*(self._of(variable) for variable in free)):
            self._learn(atom.bind({v.name: value for v, value in zip(free, values, strict=True)}))

    def _of(self, variable: Variable) -> Iterator[str]:
        return (thing for thing in self._objects if self.fits(thing, variable.type))


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


_OBJECTS, _FACTS, _STEPS = 120, 600, 4000
"""Maximum number of objects, changing facts and ground actions for this analysis: more would take seconds."""


def exclusive_conditions(task: PlanningTask, ontology: Ontology) -> tuple[Condition, ...]:
    """Returns two conditions of the goal (or one) that never hold together; none if there are none or it is unknown.

    Args:
        task: The task; each of its conditions could hold by itself.
        ontology: Classes.
    """
    if len(task.problem.objects) > _OBJECTS:
        return ()
    relaxed = relax(task, ontology, together=False)
    changing = {atom.predicate for action in task.domain.actions for atom in (*action.add, *action.delete)}
    facts = [atom for atom in relaxed.facts if atom.predicate in changing]
    steps = list(islice(_steps(relaxed, changing), _STEPS + 1))
    if len(facts) > _FACTS or len(steps) > _STEPS or any(set(step.add) - set(facts) for step in steps):
        return ()
    number = {atom: i for i, atom in enumerate(facts)}
    reached = _reachable(task, steps, number)
    wanted = [(condition, number[atom]) for condition, atoms in task.goal for atom in atoms if atom in number]
    pairs = ((one, other) for (one, i), (other, j) in combinations(wanted, 2) if not reached[i, j])
    return tuple(dict.fromkeys(next(pairs, ())))


def _steps(relaxed: Relaxation, changing: set[str]) -> Iterator[Action]:
    """Yields ground actions, each with only those preconditions that can change."""
    seen: set[tuple[tuple[Atom, ...], ...]] = set()
    for action in relaxed.task.domain.actions:
        for binding in solutions(action.pre, relaxed.facts, {}, action.types, relaxed.fits):
            pre = tuple(atom.bind(binding) for atom in action.pre if atom.predicate in changing)
            add, delete = (tuple(atom.bind(binding) for atom in atoms) for atoms in (action.add, action.delete))
            free = any(is_variable(argument) for atom in (*add, *delete) for argument in atom.arguments)
            if free:
                add, delete = _filled(add, relaxed), tuple(a for a in delete if not any(map(is_variable, a.arguments)))
            if (pre, add, delete) not in seen:
                seen.add((pre, add, delete))
                yield Action(action.name, action.skill, (), pre, add, delete)


def _filled(atoms: tuple[Atom, ...], relaxed: Relaxation) -> tuple[Atom, ...]:
    """Binds free variables to all values at once: an over-approximation, so nothing is excluded wrongly."""
    return tuple(fact for atom in atoms for fact in relaxed.facts.candidates(atom))


def _reachable(task: PlanningTask, steps: list[Action], number: dict[Atom, int]) -> NDArray[np.bool_]:
    """Returns which pairs of facts could hold together."""
    reached: NDArray[np.bool_] = np.zeros((len(number), len(number)), dtype=np.bool_)
    start = [number[atom] for atom in task.problem.init if atom in number]
    reached[np.ix_(start, start)] = True
    rows = [tuple([number[a] for a in atoms if a in number] for atoms in (s.pre, s.add, s.delete)) for s in steps]
    size = -1
    while size != (size := int(reached.sum())):
        for pre, add, delete in rows:
            if not reached[np.ix_(pre, pre)].all():
                continue
            beside = np.array(reached[pre].all(axis=0) if pre else reached.diagonal())
            beside[delete] = False
            beside[add] = True
            reached[add] |= beside
            reached[:, add] |= beside[:, None]
    return reached

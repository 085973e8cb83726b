"""The initial facts about the elements of a problem: stored or computed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import product

from skiros_py.errors import PlanningError, SkirosError
from skiros_py.interruptions import Interruption
from skiros_py.planning.domain.classes import IS
from skiros_py.planning.domain.complements import stated_objects
from skiros_py.planning.domain.literals import NOTHING, Asked
from skiros_py.planning.domain.model import Action, Atom
from skiros_py.skills.conditions import Computed, Not
from skiros_py.world.ontology import Ontology
from skiros_py.world.view import WorldView


class Facts:
    """The facts about some elements, by predicate.

    Args:
        view: The world.
        objects: The elements, with their classes.
        asked: What is evaluated, by predicate, over the variables "1" and "2".
        who: Names the conditions that use a predicate, for error messages.
    """

    def __init__(
        self,
        view: WorldView,
        objects: Mapping[str, str],
        asked: Mapping[str, Asked | Not],
        who: Callable[[str], str],
    ) -> None:
        self._view = view
        self._objects = objects
        self._asked = asked
        self._who = who
        self._found: dict[tuple[str, tuple[str, ...]], tuple[Atom, ...]] = {}
        self._of_class: dict[str, tuple[str, ...]] = {}

    def of(self, predicates: Mapping[str, tuple[str, ...]]) -> set[Atom]:
        """Returns the facts of predicates with the given argument types.

        Raises:
            PlanningError: A condition's own function failed; the message names the condition.
        """
        return {atom for name, types in predicates.items() for atom in self._facts(name, types)}

    def _facts(self, name: str, types: tuple[str, ...]) -> tuple[Atom, ...]:
        key = name, types
        if key not in self._found:
            try:
                self._found[key] = tuple(self._worked_out(name, [self._fitting(type_) for type_ in types]))
            except (SkirosError, KeyboardInterrupt, Interruption):
                raise
            except BaseException as error:
                said = f"{type(error).__name__}: {error}"
                raise PlanningError(f"{self._who(name) or name} cannot be worked out: {said}") from error
        return self._found[key]

    def _worked_out(self, name: str, fitting: Sequence[Sequence[str]]) -> Iterable[Atom]:
        if name in self._asked:
            return (Atom(name, ids) for ids in self._holding(self._asked[name], fitting))
        if name.startswith(NOTHING):
            relation = name.removeprefix(NOTHING)
            return (Atom(name, (place,)) for place in fitting[0] if not self._view.subjects(relation, place))
        if name.startswith(IS):
            class_, ontology = name.removeprefix(IS), self._view.ontology
            return (Atom(name, (o,)) for o in fitting[0] if ontology.is_a(self._objects[o], class_))
        return self._stored(name, fitting) if name in self._view.ontology.relations else ()

    def _stored(self, relation: str, fitting: Sequence[Sequence[str]]) -> Iterable[Atom]:
        targets = set(fitting[1])
        for subject in fitting[0]:
            for object_ in stated_objects(self._view, subject, relation):
                if object_ in targets:
                    yield Atom(relation, (subject, object_))

    def _holding(self, literal: Asked | Not, fitting: Sequence[Sequence[str]]) -> Iterable[tuple[str, ...]]:
        """Returns the tuples a literal holds for, among fitting arguments."""
        if isinstance(literal, Computed):
            return literal.pairs(self._view, fitting[0], fitting[1])
        tuples = product(*fitting)
        if isinstance(literal, Not) and isinstance(literal.pattern, Computed):
            there = set(literal.pattern.pairs(self._view, fitting[0], fitting[1]))
            return (ids for ids in tuples if ids not in there)
        return (ids for ids in tuples if literal.evaluate(self._view, dict(zip(("1", "2"), ids, strict=False))))

    def _fitting(self, class_: str) -> tuple[str, ...]:
        if class_ not in self._of_class:
            self._of_class[class_] = tuple(_fitting(self._objects, class_, self._view.ontology))
        return self._of_class[class_]


def _fitting(objects: Mapping[str, str], class_: str, ontology: Ontology) -> Iterable[str]:
    if class_ in ("", "object"):
        return objects
    below = frozenset(ontology.subclasses(class_))
    return (o for o, type_ in objects.items() if type_ in below)


def living(actions: Iterable[Action], view: WorldView) -> tuple[Action, ...]:
    """Removes variants that involve a class without elements (no station, no deck, ...)."""
    drafts = tuple(actions)
    classes = {v.type for action in drafts for v in action.parameters} & view.ontology.classes.keys()
    empty = {class_ for class_ in classes if not view.some_instances(class_, 1)}
    return _or_all(drafts, lambda action: all(v.type not in empty for v in action.parameters))


def supported(
    actions: Sequence[Action], init: Iterable[Atom], objects: Mapping[str, str], ontology: Ontology
) -> tuple[Action, ...]:
    """Removes variants with a precondition that neither holds initially nor is ever achieved (no kit is carried, ...).

    Args:
        actions: All of the task.
        init: What holds at the start.
        objects: The elements, with their classes.
        ontology: Classes.
    """
    support = _Support(actions, init, objects, ontology)
    kept = _or_all(actions, lambda action: all(support.may_be(atom, action.types) for atom in action.pre))
    count = Counter(action.skill for action in kept)
    return tuple(replace(a, name=a.skill) if a.skill is not None and count[a.skill] == 1 else a for a in kept)


class _Support:
    """The initial and the achievable facts, by predicate."""

    def __init__(
        self, actions: Iterable[Action], init: Iterable[Atom], objects: Mapping[str, str], ontology: Ontology
    ) -> None:
        self._objects = objects
        self._ontology = ontology
        self._added = {atom.predicate for action in actions for atom in action.add}
        self._facts: dict[str, list[Atom]] = {}
        for atom in init:
            self._facts.setdefault(atom.predicate, []).append(atom)

    def may_be(self, atom: Atom, types: Mapping[str, str]) -> bool:
        facts = self._facts.get(atom.predicate, ())
        return atom.predicate in self._added or any(self._matches(atom, fact, types) for fact in facts)

    def _matches(self, atom: Atom, fact: Atom, types: Mapping[str, str]) -> bool:
        pairs = zip(atom.arguments, fact.arguments, strict=True)
        return all(self._fits(v, types.get(a, "")) if a.startswith("?") else a == v for a, v in pairs)

    def _fits(self, element: str, class_: str) -> bool:
        return class_ in ("", "object") or self._ontology.is_a(self._objects[element], class_)


def _or_all(actions: Sequence[Action], is_good: Callable[[Action], bool]) -> tuple[Action, ...]:
    """Returns the good ones; for a skill without any, all, so that explanations can name what it lacks."""
    good = {action.name for action in actions if is_good(action)}
    skills = {action.skill for action in actions if action.name in good}
    return tuple(a for a in actions if a.name in good or a.skill is None or a.skill not in skills)

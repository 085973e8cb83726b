"""What holds at the start, of the elements of a problem: looked up, or worked out."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import product

from skiros_py.errors import PlanningError, SkirosError
from skiros_py.interruptions import Interruption
from skiros_py.planning.domain.classes import IS
from skiros_py.planning.domain.complements import stated_objects
from skiros_py.planning.domain.literals import NOTHING, Asked
from skiros_py.planning.domain.model import Atom
from skiros_py.skills.conditions import Computed, Not
from skiros_py.world.ontology import Ontology
from skiros_py.world.view import WorldView


class Facts:
    """The facts about some elements, by predicate.

    Args:
        view: The world.
        objects: The elements, with their classes.
        asked: What is evaluated, by predicate, over the variables "1" and "2".
        who: Names the conditions that ask for a predicate, for a fault.
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
        """Returns what a literal holds of, among what fits its arguments."""
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

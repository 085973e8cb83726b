"""Variants of skills that this scene can make possible; the others only cost time, and clutter what people read."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

from skiros_py.planning.domain.model import Action, Atom
from skiros_py.world.ontology import Ontology
from skiros_py.world.view import WorldView


def living(actions: Iterable[Action], view: WorldView) -> tuple[Action, ...]:
    """Leaves out variants that speak of a class of which there is nothing (no station, no deck, ...)."""
    drafts = tuple(actions)
    classes = {v.type for action in drafts for v in action.parameters} & view.ontology.classes.keys()
    nobody = {class_ for class_ in classes if not view.some_instances(class_, 1)}
    return _or_all(drafts, lambda action: all(v.type not in nobody for v in action.parameters))


def supported(
    actions: Sequence[Action], init: Iterable[Atom], objects: Mapping[str, str], ontology: Ontology
) -> tuple[Action, ...]:
    """Leaves out variants that need what neither holds at the start nor is ever brought about (no kit is carried, ...).

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
    """What holds at the start, and what is brought about, by predicate."""

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
    """Returns the good ones; of a skill that has none, all, so that an explanation can say what it lacks."""
    good = {action.name for action in actions if is_good(action)}
    skills = {action.skill for action in actions if action.name in good}
    return tuple(a for a in actions if a.name in good or a.skill is None or a.skill not in skills)

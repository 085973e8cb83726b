"""Variants of a skill: their names, and which of them something in the scene could ever make possible."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from skiros_py.planning.domain.model import Action, Atom
from skiros_py.planning.domain.placing import is_placement, moved_and_place
from skiros_py.world.ontology import Ontology
from skiros_py.world.view import WorldView


def numbered(actions: Iterable[Action]) -> tuple[Action, ...]:
    """Names each action after its skill, with a number where there are several of one; bookkeeping keeps its names."""
    drafts = tuple(actions)
    count = Counter(action.skill for action in drafts)
    reached: Counter[str | None] = Counter()
    result = []
    for action in drafts:
        reached[action.skill] += 1
        name = action.skill if count[action.skill] == 1 else f"{action.skill}/{reached[action.skill]}"
        result.append(action if action.skill is None or name is None else replace(action, name=name))
    return tuple(result)


def possible_variants(actions: Iterable[Action], view: WorldView) -> tuple[Action, ...]:
    """Removes variants with a placement that nothing of the class has or can ever get.

    If no variant is possible, a skill's first one is kept, so that explanations can name what it lacks.
    """
    drafts = tuple(actions)
    placing = _Placing(drafts, view)
    possible = [a for a in drafts if placing.allows(a)]
    there = {action.skill for action in possible}
    kept: list[Action] = []
    for action in drafts:
        if action in possible or action.skill not in there:
            kept.append(action)
            there.add(action.skill)
    return numbered(kept)


class _Placing:
    """How things of some class are or could be placed."""

    def __init__(self, actions: Sequence[Action], view: WorldView) -> None:
        self._view = view
        self._found: dict[tuple[str, str], bool] = {}
        self._brought: dict[str, set[str]] = {}
        for action in actions:
            for moved, atom in _moved(action, action.add, view.ontology):
                self._brought.setdefault(atom.predicate, set()).add(moved)

    def allows(self, action: Action) -> bool:
        return all(self._may_be(m, a.predicate) for m, a in _moved(action, action.pre, self._view.ontology))

    def _may_be(self, class_: str, relation: str) -> bool:
        key = class_, relation
        if key not in self._found:
            self._found[key] = self._is_brought(class_, relation) or self._is_there(class_, relation)
        return self._found[key]

    def _is_brought(self, class_: str, relation: str) -> bool:
        below = set(self._view.ontology.subclasses(class_))
        return any(not below.isdisjoint(self._view.ontology.subclasses(c)) for c in self._brought.get(relation, ()))

    def _is_there(self, class_: str, relation: str) -> bool:
        placements = (self._view.placement(thing) for thing in self._view.instances(class_))
        return any(placement is not None and placement.relation == relation for placement in placements)


def _moved(action: Action, atoms: Iterable[Atom], ontology: Ontology) -> Iterator[tuple[str, Atom]]:
    """Yields the placements among atoms, with the class of what is placed."""
    types = action.types
    for atom in atoms:
        if is_placement(atom, ontology):
            class_ = types[moved_and_place(atom, ontology)[0]]
            if class_ in ontology.classes:
                yield class_, atom

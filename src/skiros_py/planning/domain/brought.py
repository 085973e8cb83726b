"""Between which things skills could ever make a relation hold, by their classes."""

from __future__ import annotations

from collections.abc import Iterable

from skiros_py.planning.domain.model import Action
from skiros_py.world.ontology import Ontology


class Brought:
    """What a set of skills can bring about.

    Args:
        actions: The skills.
        ontology: Their classes.
    """

    def __init__(self, actions: Iterable[Action], ontology: Ontology) -> None:
        self._ontology = ontology
        self._ends: dict[str, dict[tuple[str, ...], None]] = {}
        for action in actions:
            types = action.types
            for atom in action.add:
                ends = tuple(types[argument] for argument in atom.arguments)
                self._ends.setdefault(atom.predicate, {})[ends] = None

    def may_relate(self, relation: str, *classes: str) -> bool:
        """Tells whether a skill could make a relation hold between things of these most specific classes."""
        return any(all(map(self._fits, classes, ends)) for ends in self._ends.get(relation, ()))

    def _fits(self, class_: str, wanted: str) -> bool:
        return wanted not in self._ontology.classes or self._ontology.is_a(class_, wanted)

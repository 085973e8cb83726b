"""Where a thing can be put by hand: not into occupied places that skills reserve for a single thing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from skiros_py.planning.domain.actions import actions_of
from skiros_py.planning.domain.literals import NOTHING
from skiros_py.planning.domain.model import Action
from skiros_py.planning.problem.task import Capability
from skiros_py.world.element import Placement
from skiros_py.world.ontology import Ontology
from skiros_py.world.view import WorldView
from skiros_py.world.vocabulary import FLOOR, LOCATION, UNKNOWN_LOCATION


class Room:
    """Determines which places skills reserve for a single thing: those they require to be empty.

    Args:
        capabilities: The available skills.
        ontology: Their classes.
    """

    def __init__(self, capabilities: Sequence[Capability], ontology: Ontology) -> None:
        self._ontology = ontology
        actions = (action for c in capabilities for action in actions_of(c.skill, ontology))
        self._kept = frozenset(kept for action in actions for kept in _kept_empty(action))

    def homes(self, class_: str, view: WorldView, besides: Sequence[str] = ()) -> list[Placement]:
        """Returns where things of a class are stored, or else of the nearest superclass with stored things.

        Single-thing places are returned only if there is no other storage, and only free ones.

        Args:
            class_: CURIE of the class.
            view: The world.
            besides: Places to exclude.
        """
        free: dict[Placement, None] = {}
        for above in view.ontology.ancestors(class_):
            placed = (view.placement(thing) for thing in view.instances(above))
            homes = [p for p in dict.fromkeys(placed) if p is not None and self._is_home(p, view, besides)]
            stored = [home for home in homes if not self.keeps_one(home, view)]
            if stored:
                return stored
            free |= dict.fromkeys(home for home in homes if self.has_room(home, view))
        return list(free)

    def has_room(self, placement: Placement, view: WorldView) -> bool:
        """Returns whether one more thing can be put somewhere."""
        return not (self.keeps_one(placement, view) and view.subjects(placement.relation, placement.place))

    def is_free(self, place: str, view: WorldView) -> bool:
        """Returns whether a place is a single-thing place and empty."""
        relations = {r for r, c in self._kept if self._ontology.is_a(view.element(place).type, c)}
        return bool(relations) and not any(view.subjects(relation, place) for relation in relations)

    def keeps_one(self, placement: Placement, view: WorldView) -> bool:
        """Returns whether skills reserve a place for a single thing."""
        type_ = view.element(placement.place).type
        return any(placement.relation == r and self._ontology.is_a(type_, c) for r, c in self._kept)

    def _is_home(self, placement: Placement, view: WorldView, besides: Sequence[str]) -> bool:
        type_ = view.element(placement.place).type
        nowhere = any(self._ontology.is_a(type_, class_) for class_ in (FLOOR, UNKNOWN_LOCATION))
        return placement.place not in besides and self._ontology.is_a(type_, LOCATION) and not nowhere


def _kept_empty(action: Action) -> Iterator[tuple[str, str]]:
    """Yields relation and class of the places that an action requires to be empty."""
    types = action.types
    for atom in action.pre:
        if atom.predicate.startswith(NOTHING):
            yield atom.predicate.removeprefix(NOTHING), types[atom.arguments[0]]

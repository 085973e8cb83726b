"""A supposed world in which there are also things that the world model has no individuals for."""

from __future__ import annotations

from collections.abc import Iterable

from skiros_py.world.element import Element, Placement
from skiros_py.world.overlay import Overlay
from skiros_py.world.view import WorldView

__all__ = ["Enlarged"]


class Enlarged(Overlay):
    """An overlay with elements that its base does not have."""

    def __init__(self, base: WorldView) -> None:
        super().__init__(base)
        self._more: dict[str, str] = {}

    def enlarge(self, element: Element, placement: Placement | None = None) -> None:
        """Supposes one more element.

        Args:
            element: The element, of an id that the base does not have.
            placement: Where it is; None for nowhere.

        Raises:
            UnknownName: There is no such place or relation.
        """
        self._more[element.id] = element.type
        self._elements[element.id] = element
        self._placements[element.id] = None
        if placement is not None:
            self.place(element.id, placement.relation, placement.place)

    @property
    def further(self) -> tuple[str, ...]:
        """Ids of the elements that the base does not have."""
        return tuple(self._more)

    def has(self, element_id: str) -> bool:
        """Returns True when there is an element of that id."""
        return element_id in self._more or super().has(element_id)

    def instances(self, class_: str) -> tuple[str, ...]:
        """Returns the ids of all elements of a class or of its subclasses, sorted.

        Raises:
            UnknownName: It is not a class.
        """
        known, more = super().instances(class_), self._further_of(class_)
        return tuple(sorted((*known, *more))) if more else known

    def some_instances(self, class_: str, limit: int, after: str = "") -> tuple[str, ...]:
        """Returns the first of the instances of a class that sort after an id, at most so many.

        Raises:
            UnknownName: It is not a class.
        """
        known = super().some_instances(class_, limit, after)
        more = [name for name in self._further_of(class_) if name > after]
        return tuple(sorted((*known, *more)))[:limit] if more else known

    def instances_among(self, class_: str, ids: Iterable[str]) -> tuple[str, ...]:
        """Returns which of some ids are of elements of a class, in the order given.

        Raises:
            UnknownName: It is not a class, or there is no such element.
        """
        asked = tuple(ids)
        known = super().instances_among(class_, (i for i in asked if i not in self._more))
        if len(known) == len(asked):
            return known
        fitting = {*known, *self._further_of(class_)}
        return tuple(i for i in asked if i in fitting)

    def _further_of(self, class_: str) -> list[str]:
        return [name for name, type_ in self._more.items() if self.ontology.is_a(type_, class_)]

"""A world in which also things are supposed to be there, or to be gone."""

from __future__ import annotations

from collections.abc import Iterable

from skiros_py.errors import UnknownName
from skiros_py.world.element import Element, is_abstract
from skiros_py.world.names import local_name
from skiros_py.world.overlay import Overlay
from skiros_py.world.view import WorldView

__all__ = ["Supposition"]


class Supposition(Overlay):
    """An overlay with elements that the world does not have, and without some that it has."""

    def __init__(self, base: WorldView) -> None:
        super().__init__(base)
        self._below = base
        self._more: dict[str, Element] = {}
        self._gone: set[str] = set()

    def add(self, class_: str) -> str:
        """Supposes one more element of a class and returns its id."""
        number = len(self._more) + 1
        name = f"new_{local_name(class_).lower()}_{number}"
        while self._below.has(name):
            name += "_"
        self._more[name] = self._elements[name] = Element(name, class_, name)
        self._placements[name] = None
        return name

    def remove(self, element: str) -> None:
        """Supposes that an element is gone."""
        self.unplace(element)
        self._gone.add(element)

    def element(self, element_id: str) -> Element:
        """Returns one element.

        Raises:
            UnknownName: There is none of that id.
        """
        if element_id in self._gone:
            raise UnknownName("element", element_id, self._more)
        return super().element(element_id)

    def has(self, element_id: str) -> bool:
        """Returns True when there is an element of that id."""
        return element_id not in self._gone and (element_id in self._more or super().has(element_id))

    def instances(self, class_: str) -> tuple[str, ...]:
        """Returns the ids of all elements of a class or of its subclasses, sorted.

        Raises:
            UnknownName: It is not a class.
        """
        more = (e.id for e in self._more.values() if self.ontology.is_a(e.type, class_))
        return tuple(sorted(i for i in (*super().instances(class_), *more) if i not in self._gone))

    def some_instances(self, class_: str, limit: int, after: str = "") -> tuple[str, ...]:
        """Returns the first of the instances of a class that sort after an id, at most so many.

        Raises:
            UnknownName: It is not a class.
        """
        more = (e.id for e in self._more.values() if e.id > after and self.ontology.is_a(e.type, class_))
        found = (*super().some_instances(class_, limit + len(self._gone), after), *more)
        return tuple(sorted(i for i in found if i not in self._gone))[:limit]

    def instances_among(self, class_: str, ids: Iterable[str]) -> tuple[str, ...]:
        """Returns those of the ids that are instances of a class, in their order.

        Raises:
            UnknownName: It is not a class, or there is none of an id.
        """
        return tuple(i for i in ids if not is_abstract(i) and self.ontology.is_a(self.element(i).type, class_))

"""A view for what-if questions: an overlay that also hides elements."""

from __future__ import annotations

from collections.abc import Iterable

from skiros_py.errors import UnknownName
from skiros_py.world.element import Element
from skiros_py.world.names import local_name
from skiros_py.world.overlay import ExtendedView
from skiros_py.world.view import WorldView


class HypotheticalView(ExtendedView):
    """An overlay that adds elements to the world and hides others."""

    def __init__(self, base: WorldView) -> None:
        super().__init__(base)
        self._gone: set[str] = set()

    def add(self, class_: str) -> str:
        """Adds a hypothetical element of a class and returns its id."""
        name = f"new_{local_name(class_).lower()}_{len(self.further) + 1}"
        while self.has(name):
            name += "_"
        self.extend(Element(name, class_, name))
        return name

    def remove(self, element: str) -> None:
        """Hides an element."""
        self.unplace(element)
        self._gone.add(element)

    def element(self, element_id: str) -> Element:
        """Returns one element.

        Raises:
            UnknownName: There is no element with that id.
        """
        if element_id in self._gone:
            raise UnknownName("element", element_id, self.further)
        return super().element(element_id)

    def has(self, element_id: str) -> bool:
        """Returns True when there is an element of that id."""
        return element_id not in self._gone and super().has(element_id)

    def instances(self, class_: str) -> tuple[str, ...]:
        """Returns the ids of all elements of a class or of its subclasses, sorted.

        Raises:
            UnknownName: It is not a class.
        """
        return tuple(i for i in super().instances(class_) if i not in self._gone)

    def some_instances(self, class_: str, limit: int, after: str = "") -> tuple[str, ...]:
        """Returns the first instances of a class that sort after an id, up to a limit.

        Raises:
            UnknownName: It is not a class.
        """
        found = super().some_instances(class_, limit + len(self._gone), after)
        return tuple(i for i in found if i not in self._gone)[:limit]

    def instances_among(self, class_: str, ids: Iterable[str]) -> tuple[str, ...]:
        """Returns the given ids that are instances of a class, in their order.

        Raises:
            UnknownName: It is not a class, or there is none of an id.
        """
        return super().instances_among(class_, (i for i in ids if i not in self._gone))

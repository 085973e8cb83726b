"""A view of the world in which some elements do not take part."""

from __future__ import annotations

from collections.abc import Iterable

from skiros_py.world.element import Element, Placement, Value
from skiros_py.world.ontology import Ontology
from skiros_py.world.reasoners.registry import Reasoners
from skiros_py.world.sensors import NO_SENSORS, Sensors
from skiros_py.world.view import WorldView

__all__ = ["Without"]


class Without(WorldView):
    """The same world, but the given elements are not found when somebody looks for one of a class.

    They are still where they are: a gripper that holds one is not empty.
    """

    def __init__(self, base: WorldView, ids: frozenset[str]) -> None:
        self._base = base
        self._ids = ids

    @property
    def ontology(self) -> Ontology:
        """The classes and relations."""
        return self._base.ontology

    @property
    def reasoners(self) -> Reasoners:
        """What works out computed relations."""
        return self._base.reasoners

    @property
    def sensors(self) -> Sensors:
        """Nothing: this view is for planning, and plans cannot sense."""
        return NO_SENSORS

    def element(self, element_id: str) -> Element:
        """Returns one element, left out or not."""
        return self._base.element(element_id)

    def has(self, element_id: str) -> bool:
        """Returns True when there is an element of that id, left out or not."""
        return self._base.has(element_id)

    def instances(self, class_: str) -> tuple[str, ...]:
        """Returns the ids of all elements of a class that take part."""
        return tuple(i for i in self._base.instances(class_) if i not in self._ids)

    def some_instances(self, class_: str, limit: int, after: str = "") -> tuple[str, ...]:
        """Returns the first of the elements of a class that take part and sort after an id, at most so many."""
        found = self._base.some_instances(class_, limit + len(self._ids), after)
        return tuple(i for i in found if i not in self._ids)[:limit]

    def instances_among(self, class_: str, ids: Iterable[str]) -> tuple[str, ...]:
        """Returns which of some ids are of elements of a class that take part."""
        return self._base.instances_among(class_, (i for i in ids if i not in self._ids))

    def abstracts(self, class_: str) -> tuple[str, ...]:
        """Returns the ids of the abstract elements of a class."""
        return self._base.abstracts(class_)

    def value(self, element_id: str, property_: str) -> Value | None:
        """Returns a property's value."""
        return self._base.value(element_id, property_)

    def objects(self, subject: str, relation: str) -> tuple[str, ...]:
        """Returns ids of what the subject is related to."""
        return self._base.objects(subject, relation)

    def subjects(self, relation: str, object_: str) -> tuple[str, ...]:
        """Returns ids of what is related to the object."""
        return self._base.subjects(relation, object_)

    def related(self, subject: str, relation: str, object_: str) -> bool:
        """Returns True when the relation holds between the two."""
        return self._base.related(subject, relation, object_)

    def placement(self, element_id: str) -> Placement | None:
        """Returns where an element is."""
        return self._base.placement(element_id)

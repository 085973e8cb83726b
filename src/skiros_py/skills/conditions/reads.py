"""What an evaluation read of the world, and what a change touches of that: both as the same small keys."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from skiros_py.world.change import Edit, ElementEdit, GoalsEdit, PlacementEdit, PropertyEdit
from skiros_py.world.element import Element, Placement, Value
from skiros_py.world.index import Index
from skiros_py.world.ontology import Ontology
from skiros_py.world.reasoners.registry import computed_objects, computed_subjects
from skiros_py.world.taught import TEACHABLE, lessons
from skiros_py.world.terms import Family
from skiros_py.world.view import ForwardingView, Sensors

Key = tuple[str, ...]
"""A piece of the world: its kind, and which.

``is`` an element's being there, ``all`` of its own values, one ``value``, its ``place``, what it relates ``from`` and
``to``, whether a relation is ``between`` two, who is of a ``class``.
"""


class ReadingView(ForwardingView):
    """One state of the world that notes what is read of it.

    Reasoners are asked with this view, so what they read is noted too.

    Attributes:
        keys: What was read so far.
        sensed: Whether sensors were asked for.
    """

    def __init__(self, state: Index, sensors: Sensors) -> None:
        self.keys: set[Key] = set()
        self.sensed = False
        self._base = state
        self._sensors = sensors

    @property
    def sensors(self) -> Sensors:
        """What devices say in this cycle."""
        self.sensed = True
        return self._sensors

    def element(self, element_id: str) -> Element:
        """Returns one element."""
        self.keys |= {("is", element_id), ("all", element_id)}
        return self._base.element(element_id)

    def has(self, element_id: str) -> bool:
        """Returns True when there is an element of that id."""
        self.keys.add(("is", element_id))
        return self._base.has(element_id)

    def instances(self, class_: str) -> tuple[str, ...]:
        """Returns the ids of all elements of a class."""
        self.keys.add(("class", class_))
        return self._base.instances(class_)

    def some_instances(self, class_: str, limit: int, after: str = "") -> tuple[str, ...]:
        """Returns the first of the elements of a class."""
        self.keys.add(("class", class_))
        return self._base.some_instances(class_, limit, after)

    def instances_among(self, class_: str, ids: Iterable[str]) -> tuple[str, ...]:
        """Returns which of some ids are of elements of a class."""
        asked = tuple(ids)
        self.keys.update(("is", name) for name in asked)
        return self._base.instances_among(class_, asked)

    def abstracts(self, class_: str) -> tuple[str, ...]:
        """Returns the ids of the abstract elements of a class."""
        self.keys.add(("class", class_))
        return self._base.abstracts(class_)

    def value(self, element_id: str, property_: str) -> Value | None:
        """Returns a property's value."""
        self.keys |= {("is", element_id), ("value", element_id, property_)}
        if property_ in TEACHABLE:
            lessons(self)  # what is taught later counts, too
        return self._base.value(element_id, property_)

    def objects(self, subject: str, relation: str) -> tuple[str, ...]:
        """Returns ids of what the subject is related to."""
        if self.ontology.family(relation) is Family.COMPUTED:
            return computed_objects(self, subject, relation)
        self.keys.update(("from", subject, below) for below in self.ontology.sub_relations(relation))
        return self._base.objects(subject, relation)

    def subjects(self, relation: str, object_: str) -> tuple[str, ...]:
        """Returns ids of what is related to the object."""
        if self.ontology.family(relation) is Family.COMPUTED:
            return computed_subjects(self, relation, object_)
        self.keys.update(("to", below, object_) for below in self.ontology.sub_relations(relation))
        return self._base.subjects(relation, object_)

    def related(self, subject: str, relation: str, object_: str) -> bool:
        """Returns True when the relation holds between the two."""
        if self.ontology.family(relation) is Family.COMPUTED:
            return self.reasoners.answer(self, subject, relation, object_).holds
        self.keys.update(("between", subject, below, object_) for below in self.ontology.sub_relations(relation))
        return self._base.related(subject, relation, object_)

    def placement(self, element_id: str) -> Placement | None:
        """Returns where an element is."""
        self.keys |= {("is", element_id), ("place", element_id)}
        return self._base.placement(element_id)


def touched_by(edit: Edit, ontology: Ontology) -> Iterator[Key]:
    """Yields what an edit changes, as it would be read."""
    match edit:
        case ElementEdit(element, old, new):
            yield ("is", element)
            type_ = (new or old or Element(element, "", "")).type
            yield from (("class", above) for above in ontology.ancestors(type_))
        case PropertyEdit(element, property_):
            yield from (("all", element), ("value", element, property_))
        case PlacementEdit(element, old_place, new_place):
            yield ("place", element)
            for place in filter(None, (old_place, new_place)):
                subject, object_ = ontology.placement_pair(element, place)
                yield from _statement(subject, place.relation, object_)
        case GoalsEdit():
            pass
        case _:
            yield from _statement(edit.subject, edit.relation, edit.object)


def _statement(subject: str, relation: str, object_: str) -> Iterator[Key]:
    yield from (("from", subject, relation), ("to", relation, object_), ("between", subject, relation, object_))

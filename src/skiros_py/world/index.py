"""The typed indexes over the scene: what every question of the hot paths is answered from."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator
from dataclasses import replace
from types import MappingProxyType
from typing import TypeVar

from skiros_py.errors import UnknownName
from skiros_py.world.change import Edit, ElementEdit, PlacementEdit, RelationEdit
from skiros_py.world.element import Element, Placement, Value
from skiros_py.world.ontology import Ontology
from skiros_py.world.vocabulary import LABEL, STRUCTURE

__all__ = ["Index", "with_value"]

_Ids = tuple[str, ...]
_Key = TypeVar("_Key")


class Index:
    """One state of the scene, as a :class:`~skiros_py.world.view.WorldView`.

    A published index is never changed any more: whoever wants another state makes a :meth:`copy` first. That is cheap,
    since tables are copied flat and share their entries, which are immutable.
    """

    def __init__(self, ontology: Ontology) -> None:
        self._ontology = ontology
        self._elements: dict[str, Element] = {}
        self._of_class: dict[str, _Ids] = {}
        self._objects: dict[tuple[str, str], _Ids] = {}
        self._subjects: dict[tuple[str, str], _Ids] = {}
        self._placements: dict[str, Placement] = {}
        self._contents: dict[str, _Ids] = {}

    def copy(self) -> Index:
        """Returns an index of its own with the same content."""
        other = Index(self._ontology)
        other._elements = self._elements.copy()
        other._of_class = self._of_class.copy()
        other._objects = self._objects.copy()
        other._subjects = self._subjects.copy()
        other._placements = self._placements.copy()
        other._contents = self._contents.copy()
        return other

    # ------------------------------------------------------------ the world view

    @property
    def ontology(self) -> Ontology:
        """The classes and relations."""
        return self._ontology

    def element(self, element_id: str) -> Element:
        """Returns one element.

        Raises:
            UnknownName: There is none of that id.
        """
        if element_id not in self._elements:
            raise UnknownName("element", element_id, self._elements)
        return self._elements[element_id]

    def has(self, element_id: str) -> bool:
        """Returns True when there is an element of that id."""
        return element_id in self._elements

    def instances(self, class_: str) -> tuple[str, ...]:
        """Returns the ids of all elements of a class or of its subclasses, sorted.

        Raises:
            UnknownName: It is not a class.
        """
        return _merged(self._of_class.get(below, ()) for below in self._ontology.subclasses(class_))

    def value(self, element_id: str, property_: str) -> Value | None:
        """Returns the element's own value, else the one its class (or nearest superclass) gives, else None.

        Raises:
            UnknownName: There is no such element or property.
        """
        element = self.element(element_id)
        if property_ not in self._ontology.properties:
            raise UnknownName("property", property_, self._ontology.properties)
        own = element.properties.get(property_)
        return self._ontology.class_value(element.type, property_) if own is None else own

    def objects(self, subject: str, relation: str) -> tuple[str, ...]:
        """Returns ids of what the subject is related to, sorted; sub-relations count.

        Raises:
            UnknownName: It is not a relation.
        """
        return _merged(self._objects.get((subject, below), ()) for below in self._ontology.sub_relations(relation))

    def subjects(self, relation: str, object_: str) -> tuple[str, ...]:
        """Returns ids of what is related to the object, sorted; sub-relations count.

        Raises:
            UnknownName: It is not a relation.
        """
        return _merged(self._subjects.get((below, object_), ()) for below in self._ontology.sub_relations(relation))

    def related(self, subject: str, relation: str, object_: str) -> bool:
        """Returns True when the relation (or a sub-relation) holds between the two.

        Raises:
            UnknownName: It is not a relation.
        """
        below = self._ontology.sub_relations(relation)
        return any(object_ in self._objects.get((subject, name), ()) for name in below)

    def placement(self, element_id: str) -> Placement | None:
        """Returns where an element is, or None for one that never is anywhere (the root, a piece of structure).

        Raises:
            UnknownName: There is none of that id.
        """
        self.element(element_id)
        return self._placements.get(element_id)

    # ------------------------------------------------------------ beyond the world view

    def contents(self, place: str) -> tuple[str, ...]:
        """Returns ids of what is placed directly there, by whatever relation, sorted."""
        return self._contents.get(place, ())

    def owners(self, element_id: str) -> tuple[str, ...]:
        """Returns ids of what the element is a piece of (one, in a world that was checked)."""
        return self.subjects(STRUCTURE, element_id)

    def stated(self, subject: str, relation: str, object_: str) -> bool:
        """Returns True when exactly this is stated, not through a sub-relation."""
        return object_ in self._objects.get((subject, relation), ())

    def statements(self) -> Iterator[tuple[str, str, str]]:
        """Yields every stated (subject, relation, object), placements too, sorted."""
        for subject, relation in sorted(self._objects):
            for object_ in self._objects[subject, relation]:
                yield subject, relation, object_

    def statements_about(self, element_id: str) -> list[tuple[str, str, str]]:
        """Returns every stated (subject, relation, object) with the element at either end, sorted."""
        found = set()
        for relation in self._ontology.relations:
            found |= {(element_id, relation, o) for o in self._objects.get((element_id, relation), ())}
            found |= {(s, relation, element_id) for s in self._subjects.get((relation, element_id), ())}
        return sorted(found)

    # ------------------------------------------------------------ writing: only before publication

    def apply(self, edit: Edit) -> None:
        """Does one edit of a change that was checked when it was made."""
        if isinstance(edit, ElementEdit):
            self.remove_element(edit.element) if edit.new is None else self.put_element(edit.new)
        elif isinstance(edit, PlacementEdit):
            self.put_placement(edit.element, edit.new)
        elif isinstance(edit, RelationEdit):
            self.put_relation(edit.subject, edit.relation, edit.object, holds=edit.new)
        else:
            self.put_element(with_value(self.element(edit.element), edit.property, edit.new))

    def put_element(self, element: Element) -> None:
        """Adds an element, or replaces the one of its id, which has the same type."""
        self._elements[element.id] = element
        _insert(self._of_class, element.type, element.id)

    def remove_element(self, element_id: str) -> None:
        """Takes an element out; it has no placement and no relation any more."""
        _discard(self._of_class, self._elements.pop(element_id).type, element_id)

    def put_placement(self, element_id: str, placement: Placement | None) -> None:
        """Moves an element across the whole placement family."""
        old = self._placements.pop(element_id, None)
        if old is not None:
            _discard(self._contents, old.place, element_id)
            self._put_pair(element_id, old, holds=False)
        if placement is not None:
            self._placements[element_id] = placement
            _insert(self._contents, placement.place, element_id)
            self._put_pair(element_id, placement, holds=True)

    def put_relation(self, subject: str, relation: str, object_: str, *, holds: bool) -> None:
        """Lets a relation hold or not."""
        change = _insert if holds else _discard
        change(self._objects, (subject, relation), object_)
        change(self._subjects, (relation, object_), subject)

    def _put_pair(self, element_id: str, placement: Placement, *, holds: bool) -> None:
        subject, object_ = self._ontology.placement_pair(element_id, placement)
        self.put_relation(subject, placement.relation, object_, holds=holds)


def with_value(element: Element, property_: str, value: Value | None) -> Element:
    """Returns the element with another own value (None: none); ``rdfs:label`` sets its label."""
    if property_ == LABEL:
        return replace(element, label=str(value))
    properties = {name: old for name, old in element.properties.items() if name != property_}
    if value is not None:
        properties[property_] = value
    return replace(element, properties=MappingProxyType(properties))


def _merged(groups: Iterator[_Ids]) -> _Ids:
    found = [group for group in groups if group]
    if len(found) == 1:
        return found[0]
    return tuple(sorted({name for group in found for name in group}))


def _insert(table: dict[_Key, _Ids], key: _Key, name: str) -> None:
    old = table.get(key, ())
    at = bisect_left(old, name)
    if old[at : at + 1] != (name,):
        table[key] = (*old[:at], name, *old[at:])


def _discard(table: dict[_Key, _Ids], key: _Key, name: str) -> None:
    left = tuple(other for other in table.get(key, ()) if other != name)
    if left:
        table[key] = left
    else:
        table.pop(key, None)

"""The typed indexes over the scene, which answer all queries on hot paths."""

from __future__ import annotations

import gc
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from itertools import chain
from types import MappingProxyType
from typing import TypeVar

from immutables import Map

from skiros_py.errors import UnknownName
from skiros_py.world.change import (
    Change,
    Edit,
    ElementEdit,
    GoalsEdit,
    PlacementEdit,
    RelationEdit,
    SceneSource,
    SourceEdit,
)
from skiros_py.world.element import Element, Placement, Stamp, Value, is_abstract
from skiros_py.world.ids import EMPTY, IdSet
from skiros_py.world.ontology import Ontology
from skiros_py.world.reasoners.registry import NO_REASONERS, Reasoners, computed_others
from skiros_py.world.taught import class_value
from skiros_py.world.terms import Family, PlaceEnd
from skiros_py.world.view import NO_SENSORS, Sensors, WorldView
from skiros_py.world.vocabulary import LABEL, PLACEMENT, STRUCTURE


@contextmanager
def collection_paused() -> Iterator[None]:
    """Stops Python's search for unreachable cycles inside the block.

    When a million objects are created that all stay alive, it would scan them repeatedly without finding any: that
    doubles the time.
    """
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


# ---------------------------------------------------------------- the index


_Key = TypeVar("_Key")
_NEVER = Stamp(0, 0.0)


class Index(WorldView):
    """One state of the scene, as a :class:`~skiros_py.world.view.WorldView`.

    A published index never changes: to create another state, :meth:`copy` it first. That is
    cheap, since all tables are persistent: two states share everything except their differences.

    Attributes:
        ontology: The classes and relations.
        reasoners: The reasoners for computed relations.
        sensors: None: a state of the scene has no sensors.
        goals: Texts of the goals stored with the scene, sorted.
        source: The file of the scene.
        version: Number of the change that led to this state.
    """

    sensors: Sensors = NO_SENSORS

    def __init__(self, ontology: Ontology, reasoners: Reasoners = NO_REASONERS) -> None:
        self.goals: tuple[str, ...] = ()
        self.source = SceneSource()
        self.version = 0
        self.ontology = ontology
        self.reasoners = reasoners
        self._elements: Map[str, Element] = Map()
        self._of_class: Map[str, IdSet] = Map()
        self._abstract: Map[str, IdSet] = Map()
        self._objects: Map[tuple[str, str], IdSet] = Map()
        self._subjects: Map[tuple[str, str], IdSet] = Map()
        self._placements: Map[str, Placement] = Map()
        self._guests: Map[tuple[str, str], IdSet] = Map()
        self._placed_by: Map[tuple[str, str], int] = Map()  # how many of a class have a placement relation
        self._stamps: Map[str, Stamp] = Map()

    def copy(self) -> Index:
        """Returns an independent index with the same content."""
        other = Index.__new__(Index)
        other.__dict__.update(self.__dict__)
        return other

    def forked(self) -> tuple[WorldView, Index]:
        """Returns a copy, twice: as the view and as its state."""
        other = self.copy()
        return other, other

    # ------------------------------------------------------------ the world view

    def element(self, element_id: str) -> Element:
        """Returns one element.

        Raises:
            UnknownName: There is none of that id.
        """
        element = self._elements.get(element_id)
        if element is None:
            raise self.unknown(element_id)
        return element

    def unknown(self, element_id: str) -> UnknownName:
        """Returns the error for an unknown element id, with the known ones."""
        return UnknownName("element", element_id, self._elements)

    def has(self, element_id: str) -> bool:
        """Returns True when there is an element of that id."""
        return element_id in self._elements

    def instances(self, class_: str) -> tuple[str, ...]:
        """Returns the ids of all elements of the scene of a class or of its subclasses, sorted.

        Raises:
            UnknownName: It is not a class.
        """
        return _merged(self._of_class, self.ontology.subclasses(class_))

    def some_instances(self, class_: str, limit: int, after: str = "") -> tuple[str, ...]:
        """Returns the first of the instances of a class that sort after an id, at most so many.

        Raises:
            UnknownName: It is not a class.
        """
        groups = (self._of_class.get(below, EMPTY) for below in self.ontology.subclasses(class_))
        found = [some for group in groups if (some := group.some(limit, after))]
        return found[0] if len(found) == 1 else tuple(sorted(chain.from_iterable(found))[:limit])

    def instances_among(self, class_: str, ids: Iterable[str]) -> tuple[str, ...]:
        """Returns which of some ids are of elements of the scene of a class or of its subclasses, in the order given.

        Raises:
            UnknownName: It is not a class, or there is no such element.
        """
        is_a = self.ontology.is_a
        return tuple(i for i in ids if not is_abstract(i) and is_a(self.element(i).type, class_))

    def abstracts(self, class_: str) -> tuple[str, ...]:
        """Returns the ids of the abstract elements of a class or of its subclasses, sorted: the ontology's and learned.

        Raises:
            UnknownName: It is not a class.
        """
        return _merged(self._abstract, self.ontology.subclasses(class_))

    def value(self, element_id: str, property_: str) -> Value | None:
        """Returns the element's own value, else what was taught for its class, else what the class gives, else None.

        Raises:
            UnknownName: There is no such element or property.
        """
        element = self.element(element_id)
        if property_ not in self.ontology.properties:
            raise UnknownName("property", property_, self.ontology.properties)
        own = element.properties.get(property_)
        return class_value(self, element.type, property_) if own is None else own

    def objects(self, subject: str, relation: str) -> tuple[str, ...]:
        """Returns ids of what the subject is related to, sorted; sub-relations count.

        Raises:
            UnknownName: It is not a relation, or one that no reasoner here computes.
        """
        family = self.ontology.family(relation)
        if family is Family.COMPUTED:
            return computed_others(self, subject, relation)
        if family is Family.PLACEMENT:
            return self._placed(subject, relation, "object")
        return _merged(self._objects, [(subject, below) for below in self.ontology.sub_relations(relation)])

    def subjects(self, relation: str, object_: str) -> tuple[str, ...]:
        """Returns ids of what is related to the object, sorted; sub-relations count.

        Raises:
            UnknownName: It is not a relation, or one that no reasoner here computes.
        """
        family = self.ontology.family(relation)
        if family is Family.COMPUTED:
            return computed_others(self, object_, relation, backwards=True)
        if family is Family.PLACEMENT:
            return self._placed(object_, relation, "subject")
        return _merged(self._subjects, [(below, object_) for below in self.ontology.sub_relations(relation)])

    def related(self, subject: str, relation: str, object_: str) -> bool:
        """Returns True when the relation (or a sub-relation) holds between the two.

        Raises:
            UnknownName: It is not a relation, or one that no reasoner here computes.
        """
        if self.ontology.family(relation) is Family.COMPUTED:
            return self.reasoners.answer(self, subject, relation, object_).holds
        return any(self.stated(subject, below, object_) for below in self.ontology.sub_relations(relation))

    def placement(self, element_id: str) -> Placement | None:
        """Returns where an element is, or None for one that never is anywhere (the root, a piece of structure).

        Raises:
            UnknownName: There is none of that id.
        """
        self.element(element_id)
        return self._placements.get(element_id)

    def any_placed(self, class_: str, relation: str) -> bool:
        """Returns True when exactly this placement relation holds for an element of a class or of its subclasses.

        It may be one that is hidden from searches. Takes constant time per class.

        Raises:
            UnknownName: It is not a class.
        """
        return any((below, relation) in self._placed_by for below in self.ontology.subclasses(class_))

    # ------------------------------------------------------------ beyond the world view

    def stamp(self, element_id: str) -> Stamp:
        """Returns which change last touched an element (its properties, placement or relations), and when.

        Raises:
            UnknownName: There is none of that id.
        """
        self.element(element_id)
        return self._stamps.get(element_id, _NEVER)

    def count(self, class_: str, *, abstract: bool = False) -> int:
        """Returns how many elements there are of a class or of its subclasses, in constant time per class.

        Args:
            class_: The class.
            abstract: True to count the abstract ones instead.

        Raises:
            UnknownName: It is not a class.
        """
        table = self._abstract if abstract else self._of_class
        return sum(len(table.get(below, EMPTY)) for below in self.ontology.subclasses(class_))

    def contents(self, place: str) -> tuple[str, ...]:
        """Returns ids of the elements placed directly there, by any relation, sorted."""
        return _merged(self._guests, [(below, place) for below in self.ontology.sub_relations(PLACEMENT)])

    def owners(self, element_id: str) -> tuple[str, ...]:
        """Returns ids of what the element is a piece of (one, in a world that was checked)."""
        return _merged(self._subjects, [(below, element_id) for below in self.ontology.sub_relations(STRUCTURE)])

    def stated(self, subject: str, relation: str, object_: str) -> bool:
        """Returns True when exactly this is stated, not through a sub-relation."""
        if self.ontology.is_placement(relation):
            element, placement = self.ontology.placed(subject, relation, object_)
            return self._placements.get(element) == placement
        return object_ in self._objects.get((subject, relation), EMPTY)

    def ids(self) -> Iterator[str]:
        """Yields the id of every element, abstract ones too, in no order."""
        return iter(self._elements)

    def statements(self) -> Iterator[tuple[str, str, str]]:
        """Yields every stated (subject, relation, object), placements too, sorted."""
        placed = (self.ontology.placement_statement(name, placement) for name, placement in self._placements.items())
        related = ((s, r, o) for (s, r), objects in self._objects.items() for o in objects.ids())
        yield from sorted((*placed, *related))

    def used_relations(self) -> tuple[set[str], set[str]]:
        """Returns the relations of placements, and all others, that are stated."""
        return {relation for relation, _ in self._guests}, {relation for _, relation in self._objects}

    def statements_about(self, element_id: str) -> list[tuple[str, str, str]]:
        """Returns every stated (subject, relation, object) with the element at either end, sorted."""
        found = set()
        for relation, declared in self.ontology.relations.items():
            if declared.family is not Family.PLACEMENT:
                found |= {(element_id, relation, o) for o in self._objects.get((element_id, relation), EMPTY).ids()}
                found |= {(s, relation, element_id) for s in self._subjects.get((relation, element_id), EMPTY).ids()}
        for name in (element_id, *self.contents(element_id)):
            if name in self._placements:
                found.add(self.ontology.placement_statement(name, self._placements[name]))
        return sorted(found)

    # ------------------------------------------------------------ writing: only before publication

    def take(self, change: Change) -> None:
        """Applies the next change.

        Raises:
            KeyError: It is about an element that does not exist.
        """
        for edit in change.edits:
            self.apply(edit)
        self.mark(change.marks(), Stamp(change.number, change.time))
        self.version = change.number

    def apply(self, edit: Edit) -> None:
        """Applies one edit of a change that was already validated.

        Raises:
            KeyError: It is about an element that does not exist.
        """
        if isinstance(edit, ElementEdit):
            self.remove_element(edit.element) if edit.new is None else self.put_element(edit.new)
        elif isinstance(edit, PlacementEdit):
            self.put_placement(edit.element, edit.new)
        elif isinstance(edit, RelationEdit):
            self.put_relation(edit.subject, edit.relation, edit.object, holds=edit.new)
        elif isinstance(edit, GoalsEdit):
            self.goals = edit.new
        elif isinstance(edit, SourceEdit):
            self.source = edit.new
        else:
            self.put_element(with_value(self._elements[edit.element], edit.property, edit.new))

    def mark(self, ids: Iterable[str], stamp: Stamp) -> None:
        """Records that a change affected elements, some of which may have been removed."""
        with self._stamps.mutate() as stamps:
            for name in ids:
                if name in self._elements:
                    stamps[name] = stamp
                else:
                    stamps.pop(name, None)
            self._stamps = stamps.finish()

    def put_element(self, element: Element) -> None:
        """Adds an element, or replaces the one of its id, which has the same type."""
        if element.id not in self._elements:
            if is_abstract(element.id):
                self._abstract = _insert(self._abstract, element.type, element.id)
            else:
                self._of_class = _insert(self._of_class, element.type, element.id)
        self._elements = self._elements.set(element.id, element)

    def remove_element(self, element_id: str) -> None:
        """Removes an element, which must have no placement and no relation any more."""
        type_ = self._elements[element_id].type
        self._elements = self._elements.delete(element_id)
        if is_abstract(element_id):
            self._abstract = _discard(self._abstract, type_, element_id)
        else:
            self._of_class = _discard(self._of_class, type_, element_id)

    def hide(self, ids: Iterable[str]) -> None:
        """Removes elements from searches by class; nothing else about them changes."""
        for name in ids:
            if name in self._elements:
                self._of_class = _discard(self._of_class, self._elements[name].type, name)

    def put_placement(self, element_id: str, placement: Placement | None) -> None:
        """Moves an element across the whole placement family."""
        old = self._placements.get(element_id)
        if old is not None:
            self._guests = _discard(self._guests, (old.relation, old.place), element_id)
        before, after = (None if one is None else one.relation for one in (old, placement))
        if before != after:
            self._count(element_id, before, -1)
            self._count(element_id, after, 1)
        if placement is not None:
            self._placements = self._placements.set(element_id, placement)
            self._guests = _insert(self._guests, (placement.relation, placement.place), element_id)
        elif old is not None:
            self._placements = self._placements.delete(element_id)

    def _count(self, element_id: str, relation: str | None, more: int) -> None:
        if relation is not None and not is_abstract(element_id):
            key = self._elements[element_id].type, relation
            count = self._placed_by.get(key, 0) + more
            self._placed_by = self._placed_by.set(key, count) if count else self._placed_by.delete(key)

    def put_relation(self, subject: str, relation: str, object_: str, *, holds: bool) -> None:
        """Lets a relation, no placement, hold or not."""
        change = _insert if holds else _discard
        self._objects = change(self._objects, (subject, relation), object_)
        self._subjects = change(self._subjects, (relation, object_), subject)

    # ------------------------------------------------------------ placements as statements

    def _placed(self, element_id: str, relation: str, asked: PlaceEnd) -> tuple[str, ...]:
        """The elements at the requested end of placement statements with the element at the other end."""
        own = self._placements.get(element_id)
        places: list[str] = []
        keys: list[tuple[str, str]] = []
        for below in self.ontology.sub_relations(relation):
            if self.ontology.relations[below].place_end != asked:
                keys.append((below, element_id))
            elif own is not None and own.relation == below:
                places.append(own.place)
        guests = _merged(self._guests, keys)
        return tuple(sorted({*places, *guests})) if places else guests


def with_value(element: Element, property_: str, value: Value | None) -> Element:
    """Returns the element with another own value (None: none); ``rdfs:label`` sets its label."""
    if property_ == LABEL:
        return replace(element, label=str(value))
    properties = {name: old for name, old in element.properties.items() if name != property_}
    if value is not None:
        properties[property_] = value
    return replace(element, properties=MappingProxyType(properties))


def _merged(table: Map[_Key, IdSet], keys: Iterable[_Key]) -> tuple[str, ...]:
    """The union of the table's sets for the keys, sorted; a table never holds an empty set."""
    found = [group for key in keys if (group := table.get(key)) is not None]
    if not found:
        return ()
    if len(found) == 1:
        return found[0].ids()
    return tuple(sorted({name for group in found for name in group.ids()}))


def _insert(table: Map[_Key, IdSet], key: _Key, name: str) -> Map[_Key, IdSet]:
    return table.set(key, table.get(key, EMPTY).with_(name))


def _discard(table: Map[_Key, IdSet], key: _Key, name: str) -> Map[_Key, IdSet]:
    old = table.get(key)
    if old is None:
        return table
    left = old.without(name)
    return table.set(key, left) if len(left) else table.delete(key)

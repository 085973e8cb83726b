"""Views over another view: copy-on-write, with more elements, with fewer. The base never changes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Self

from skiros_py.errors import UnknownName, UsageError
from skiros_py.world.element import Element, Placement, Value
from skiros_py.world.index import with_value
from skiros_py.world.reasoners.registry import computed_objects, computed_subjects
from skiros_py.world.taught import class_value
from skiros_py.world.terms import Family
from skiros_py.world.view import WorldView

_Statement = tuple[str, str, str]


class Overlay(WorldView):
    """A :class:`~skiros_py.world.view.WorldView` that differs from its base in the values set on it.

    Only names are checked: an overlay is hypothetical, and a plan may pass through states that no transaction would
    allow. Overlays may be stacked.
    """

    def __init__(self, base: WorldView) -> None:
        self._base = base
        self._elements: dict[str, Element] = {}
        self._placements: dict[str, Placement | None] = {}
        self._added: set[_Statement] = set()
        self._removed: set[_Statement] = set()

    def copy(self) -> Self:
        """Returns a copy with the same differences."""
        other = type(self)(self._base)
        vars(other).update(
            _elements=dict(self._elements),
            _placements=dict(self._placements),
            _added=set(self._added),
            _removed=set(self._removed),
        )
        return other

    # ------------------------------------------------------------ supposing

    def place(self, element: str, relation: str, place: str) -> None:
        """Moves an element across the whole placement family.

        Raises:
            UnknownName: There is no such element, place or relation.
        """
        self.element(place)
        placement = Placement(relation, place)
        statement = self.ontology.placement_statement(element, placement)
        self.unplace(element)
        self._placements[element] = placement
        self._added.add(statement)

    def unplace(self, element: str) -> None:
        """Leaves an element without any place.

        Raises:
            UnknownName: There is no such element.
        """
        old = self.placement(element)
        self._placements[element] = None
        if old is not None:
            self._suppose_not(*self.ontology.placement_statement(element, old))

    def set_relation(self, subject: str, relation: str, object_: str) -> None:
        """Lets a relation hold; a placement moves its element, a functional relation replaces its object.

        Raises:
            UnknownName: There is no such element or relation.
            UsageError: It is computed by a reasoner, so it cannot be set directly.
        """
        if self.ontology.family(relation) is Family.COMPUTED:
            raise UsageError(f"{relation} is computed by a reasoner: suppose what it is computed from")
        if self.ontology.is_placement(relation):
            element, placement = self.ontology.placed(subject, relation, object_)
            self.place(element, relation, placement.place)
            return
        self.element(subject)
        self.element(object_)
        if self.ontology.relation(relation).functional:
            for old in self.objects(subject, relation):
                self._suppose_not(subject, relation, old)
        self._added.add((subject, relation, object_))

    def unset_relation(self, subject: str, relation: str, object_: str) -> None:
        """Removes a relation and its sub-relations; does nothing if it does not hold.

        Raises:
            UnknownName: There is no such relation.
        """
        if not self.related(subject, relation, object_):
            return
        if self.ontology.is_placement(relation):
            self.unplace(self.ontology.placed(subject, relation, object_)[0])
        else:
            self._suppose_not(subject, relation, object_)

    def set_value(self, element: str, property_: str, value: Value | None) -> None:
        """Sets an element's own value of a property; None removes it.

        Raises:
            UnknownName: There is no such element or property.
        """
        self.value(element, property_)
        self._elements[element] = with_value(self.element(element), property_, value)

    # ------------------------------------------------------------ the world view

    def element(self, element_id: str) -> Element:
        """Returns one element.

        Raises:
            UnknownName: There is none of that id.
        """
        return self._elements.get(element_id) or self._base.element(element_id)

    def value(self, element_id: str, property_: str) -> Value | None:
        """Returns the element's own value, else what was taught for its class, else what the class gives, else None.

        Raises:
            UnknownName: There is no such element or property.
        """
        if element_id not in self._elements:
            return self._base.value(element_id, property_)
        if property_ not in self.ontology.properties:
            raise UnknownName("property", property_, self.ontology.properties)
        element = self._elements[element_id]
        own = element.properties.get(property_)
        return class_value(self, element.type, property_) if own is None else own

    def objects(self, subject: str, relation: str) -> tuple[str, ...]:
        """Returns ids of what the subject is related to, sorted; sub-relations count.

        Raises:
            UnknownName: It is not a relation.
        """
        if self.ontology.family(relation) is Family.COMPUTED:
            return computed_objects(self, subject, relation)
        below = self.ontology.sub_relations(relation)
        new = {o for s, r, o in self._added if s == subject and r in below}
        old = self._base.objects(subject, relation)
        return tuple(sorted(new.union(o for o in old if self._still(subject, relation, o))))

    def subjects(self, relation: str, object_: str) -> tuple[str, ...]:
        """Returns ids of what is related to the object, sorted; sub-relations count.

        Raises:
            UnknownName: It is not a relation.
        """
        if self.ontology.family(relation) is Family.COMPUTED:
            return computed_subjects(self, relation, object_)
        below = self.ontology.sub_relations(relation)
        new = {s for s, r, o in self._added if o == object_ and r in below}
        old = self._base.subjects(relation, object_)
        return tuple(sorted(new.union(s for s in old if self._still(s, relation, object_))))

    def related(self, subject: str, relation: str, object_: str) -> bool:
        """Returns True when the relation (or a sub-relation) holds between the two.

        Raises:
            UnknownName: It is not a relation.
        """
        if self.ontology.family(relation) is Family.COMPUTED:
            return self.reasoners.answer(self, subject, relation, object_).holds
        if any((subject, below, object_) in self._added for below in self.ontology.sub_relations(relation)):
            return True
        return self._base.related(subject, relation, object_) and self._still(subject, relation, object_)

    def placement(self, element_id: str) -> Placement | None:
        """Returns where an element is, or None for one that is nowhere (the root, a piece of structure).

        Raises:
            UnknownName: There is none of that id.
        """
        return self._placements[element_id] if element_id in self._placements else self._base.placement(element_id)

    # ------------------------------------------------------------ differences

    def _suppose_not(self, subject: str, relation: str, object_: str) -> None:
        gone = {(subject, below, object_) for below in self.ontology.sub_relations(relation)}
        self._added -= gone
        self._removed |= gone

    def _still(self, subject: str, relation: str, object_: str) -> bool:
        """Whether a relation that holds in the base was not removed here.

        The base answers for a relation and all its sub-relations at once, so if something was removed, it must be
        checked whether the relation still holds by itself or by a remaining sub-relation.
        """
        below = self.ontology.sub_relations(relation)
        if not any((subject, name, object_) in self._removed for name in below):
            return True
        return any(
            (subject, name, object_) not in self._removed
            and self._base.related(subject, name, object_)
            and not any(
                self._base.related(subject, narrower, object_) for narrower in self.ontology.sub_relations(name)[1:]
            )
            for name in below
        )


class ExtendedView(Overlay):
    """An overlay that also has elements that its base does not have."""

    def __init__(self, base: WorldView) -> None:
        super().__init__(base)
        self._more: dict[str, str] = {}

    def extend(self, element: Element, placement: Placement | None = None) -> None:
        """Adds a hypothetical element.

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


class FilteredView(WorldView):
    """The same world, with some elements hidden from searches by class.

    They keep their places: a gripper that holds one is not empty.
    """

    def __init__(self, base: WorldView, ids: frozenset[str]) -> None:
        self._base = base
        self._ids = ids

    def instances(self, class_: str) -> tuple[str, ...]:
        """Returns the ids of all elements of a class that are not hidden."""
        return tuple(i for i in super().instances(class_) if i not in self._ids)

    def some_instances(self, class_: str, limit: int, after: str = "") -> tuple[str, ...]:
        """Returns the first of the elements of a class that are not hidden and sort after an id, at most so many."""
        found = super().some_instances(class_, limit + len(self._ids), after)
        return tuple(i for i in found if i not in self._ids)[:limit]

    def instances_among(self, class_: str, ids: Iterable[str]) -> tuple[str, ...]:
        """Returns which of some ids are of elements of a class that are not hidden."""
        return super().instances_among(class_, (i for i in ids if i not in self._ids))

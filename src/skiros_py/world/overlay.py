"""Hypothetical worlds: a view on a copy of another view's state, to be changed freely. The base never changes."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from copy import copy
from typing import Self

from skiros_py.errors import UsageError
from skiros_py.world.element import Element, Placement, Value
from skiros_py.world.index import Index, with_value
from skiros_py.world.terms import Family
from skiros_py.world.view import WorldView


class Overlay(WorldView):
    """A :class:`~skiros_py.world.view.WorldView` that differs from its base in what was set on it.

    Only names are checked: an overlay is hypothetical, and a plan may pass through states that no transaction would
    allow. Overlays may be stacked; copies are cheap, since states share everything except their differences.

    Attributes:
        hidden: Ids that searches by class do not find. These elements keep their places: a gripper that holds one is
            not empty.
        further: Ids of the elements that the base does not have.
    """

    def __init__(self, base: WorldView, hidden: Collection[str] = ()) -> None:
        self._base, self._state = base.forked()
        self.hidden = frozenset(hidden)
        self.further: tuple[str, ...] = ()
        self._state.hide(self.hidden)

    def copy(self) -> Self:
        """Returns a copy with the same differences."""
        other = copy(self)
        base, state = self._base.forked()
        vars(other).update(_base=base, _state=state)
        return other

    def forked(self) -> tuple[WorldView, Index]:
        """Returns a copy, and the state that it shows."""
        other = self.copy()
        return other, vars(other)["_state"]

    def instances_among(self, class_: str, ids: Iterable[str]) -> tuple[str, ...]:
        """Returns which of some ids are of elements of a class that are not hidden, in the order given.

        Raises:
            UnknownName: It is not a class, or there is no such element.
        """
        return super().instances_among(class_, (i for i in ids if i not in self.hidden) if self.hidden else ids)

    # ------------------------------------------------------------ supposing

    def extend(self, element: Element, placement: Placement | None = None) -> None:
        """Adds a hypothetical element.

        Args:
            element: The element, of an id that the base does not have.
            placement: Where it is; None for nowhere.

        Raises:
            UnknownName: There is no such place or relation.
        """
        self.further += (element.id,)
        self._state.put_element(element)
        if placement is not None:
            self.place(element.id, placement.relation, placement.place)

    def place(self, element: str, relation: str, place: str) -> None:
        """Moves an element across the whole placement family.

        Raises:
            UnknownName: There is no such element, place or relation.
        """
        self.element(place)
        self.placement(element)
        self.ontology.relation(relation)
        self._state.put_placement(element, Placement(relation, place))

    def unplace(self, element: str) -> None:
        """Leaves an element without any place.

        Raises:
            UnknownName: There is no such element.
        """
        self.placement(element)
        self._state.put_placement(element, None)

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
                self.unset_relation(subject, relation, old)
        self._state.put_relation(subject, relation, object_, holds=True)

    def unset_relation(self, subject: str, relation: str, object_: str) -> None:
        """Removes a relation and its sub-relations; does nothing if it does not hold.

        Raises:
            UnknownName: There is no such relation.
        """
        if not self.related(subject, relation, object_):
            return
        if self.ontology.is_placement(relation):
            self.unplace(self.ontology.placed(subject, relation, object_)[0])
            return
        for below in self.ontology.sub_relations(relation):
            self._state.put_relation(subject, below, object_, holds=False)

    def set_value(self, element: str, property_: str, value: Value | None) -> None:
        """Sets an element's own value of a property; None removes it.

        Raises:
            UnknownName: There is no such element or property.
        """
        self.value(element, property_)
        self._state.put_element(with_value(self.element(element), property_, value))

"""The read interface of the world model, implemented by the live world, snapshots and overlays."""

from __future__ import annotations

from collections.abc import Iterable
from copy import copy
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

from skiros_py.world.element import Element, Placement, Value
from skiros_py.world.terms import reached
from skiros_py.world.vocabulary import HAS_A

if TYPE_CHECKING:
    from skiros_py.world.index import Index
    from skiros_py.world.ontology import Ontology
    from skiros_py.world.reasoners.registry import Reasoners

Reading = float | bool | tuple[float, ...]
"""The value of a signal."""


class Sensors(Protocol):
    """Reads the signals of the current cycle."""

    def value(self, name: str) -> Reading | None:
        """Returns the value of a signal ("gripper_1.force"); None if there is none."""

    def why_not(self, name: str) -> str:
        """Returns why a signal has no value in this cycle; empty where there is no such signal, or it has one."""


class NoSensors:
    """Sensors without signals: for snapshots, hypothetical views and worlds without a robot."""

    def value(self, name: str) -> Reading | None:  # noqa: ARG002 - the port's signature
        """Returns None."""
        return None

    def why_not(self, name: str) -> str:  # noqa: ARG002 - the port's signature
        """Returns an empty text."""
        return ""


NO_SENSORS = NoSensors()
"""The shared instance."""


# ---------------------------------------------------------------- views


class WorldView:
    """The state of the world as triples with typed indexes. Answers are sorted by id, so that runs are repeatable.

    A view delegates to the view that it is based on; subclasses override what differs.
    """

    _base: WorldView

    @cached_property
    def ontology(self) -> Ontology:
        """The classes and relations."""
        return self._base.ontology

    @cached_property
    def reasoners(self) -> Reasoners:
        """The reasoners for computed relations; used by :meth:`related`, :meth:`objects` and :meth:`subjects`."""
        return self._base.reasoners

    @property
    def sensors(self) -> Sensors:
        """Device readings of this cycle; only the live world has any."""
        return NO_SENSORS

    def element(self, element_id: str) -> Element:
        """Returns one element.

        Raises:
            UnknownName: There is none of that id.
        """
        return self._base.element(element_id)

    def has(self, element_id: str) -> bool:
        """Returns True when there is an element of that id."""
        return self._base.has(element_id)

    def instances(self, class_: str) -> tuple[str, ...]:
        """Returns the ids of all elements of the scene of a class or of its subclasses, sorted.

        Raises:
            UnknownName: It is not a class.
        """
        return self._base.instances(class_)

    def some_instances(self, class_: str, limit: int, after: str = "") -> tuple[str, ...]:
        """Returns the first of the :meth:`instances` of a class, without reading the others.

        Args:
            class_: The class.
            limit: How many at most.
            after: Only ids that sort after this one: the last id of the previous call, to continue.

        Raises:
            UnknownName: It is not a class.
        """
        return self._base.some_instances(class_, limit, after)

    def instances_among(self, class_: str, ids: Iterable[str]) -> tuple[str, ...]:
        """Returns which of some ids are of elements of the scene of a class or of its subclasses, in the order given.

        Raises:
            UnknownName: It is not a class, or there is no such element.
        """
        return self._base.instances_among(class_, ids)

    def abstracts(self, class_: str) -> tuple[str, ...]:
        """Returns the ids of the abstract elements of a class or of its subclasses: the ontology's and learned ones.

        Raises:
            UnknownName: It is not a class.
        """
        return self._base.abstracts(class_)

    def value(self, element_id: str, property_: str) -> Value | None:
        """Returns the element's own value, else what was taught for its class, else what the class gives, else None.

        See :mod:`skiros_py.world.taught`; among the class and its superclasses, the nearest one with a value counts.

        Raises:
            UnknownName: There is no such element or property.
        """
        return self._base.value(element_id, property_)

    def objects(self, subject: str, relation: str) -> tuple[str, ...]:
        """Returns ids of what the subject is related to, sorted; sub-relations count.

        Raises:
            UnknownName: It is not a relation.
        """
        return self._base.objects(subject, relation)

    def subjects(self, relation: str, object_: str) -> tuple[str, ...]:
        """Returns ids of what is related to the object, sorted; sub-relations count.

        Raises:
            UnknownName: It is not a relation.
        """
        return self._base.subjects(relation, object_)

    def related(self, subject: str, relation: str, object_: str) -> bool:
        """Returns True when the relation (or a sub-relation) holds between the two.

        Raises:
            UnknownName: It is not a relation.
        """
        return self._base.related(subject, relation, object_)

    def placement(self, element_id: str) -> Placement | None:
        """Returns where an element is, or None for one that never is anywhere (the root, a piece of structure).

        Raises:
            UnknownName: There is none of that id.
        """
        return self._base.placement(element_id)

    def any_placed(self, class_: str, relation: str) -> bool:
        """Returns True when exactly this placement relation holds for an element of a class or of its subclasses.

        It may be one that is hidden from searches.

        Raises:
            UnknownName: It is not a class.
        """
        return self._base.any_placed(class_, relation)

    def forked(self) -> tuple[WorldView, Index]:
        """Returns a view of the same kind on a copy of its state, and that copy, which may be changed; cheap."""
        other = copy(self)
        base, state = self._base.forked()
        vars(other).update(_base=base)
        return other, state


def pieces(view: WorldView, whole: str) -> tuple[str, ...]:
    """Returns an element and everything it is built of, from the top."""
    return reached([whole], lambda element: view.objects(element, HAS_A))


def wholes(view: WorldView, piece: str) -> tuple[str, ...]:
    """Returns an element and everything that it is a piece of, from the bottom."""
    return reached([piece], lambda element: view.subjects(HAS_A, element))

"""The scene changes that make up repairs; each can be applied to a hypothetical view or written to the world."""

from __future__ import annotations

import builtins
from dataclasses import dataclass

from skiros_py.errors import UnknownName
from skiros_py.messages import Message
from skiros_py.world.element import Element, Placement, Value
from skiros_py.world.literals import shown
from skiros_py.world.names import local_name
from skiros_py.world.overlay import Overlay
from skiros_py.world.stock import is_token, take
from skiros_py.world.transaction import Transaction


class HypotheticalView(Overlay):
    """An overlay that adds elements to the world and removes others."""

    set = Overlay.set_value
    relate = Overlay.set_relation

    def add(self, class_: str, *, placement: Placement) -> None:
        """Adds a hypothetical element of a class."""
        name = f"new_{local_name(class_).lower()}_{len(self.further) + 1}"
        while self.has(name):
            name += "_"
        self.extend(Element(name, class_, name))
        self.place(name, placement.relation, placement.place)

    def remove(self, element: str) -> None:
        """Removes an element; what others are related to stays as it is."""
        self.unplace(element)
        self._state.hide([element])
        self.hidden |= {element}

    def element(self, element_id: str) -> Element:
        """Returns one element.

        Raises:
            UnknownName: There is no element with that id.
        """
        if element_id in self.hidden:
            raise UnknownName("element", element_id, self.further)
        return super().element(element_id)

    def has(self, element_id: str) -> bool:
        """Returns True when there is an element of that id."""
        return element_id not in self.hidden and super().has(element_id)


@dataclass(frozen=True, slots=True)
class Move:
    """An element is moved.

    Attributes:
        element: The moved element.
        relation: The placement relation.
        place: Its new place.
    """

    element: str
    relation: str
    place: str

    def __str__(self) -> str:
        return Message(
            "put {thing} {relation} {place}", thing=self.element, relation=local_name(self.relation), place=self.place
        )

    @property
    def elements(self) -> tuple[str, ...]:
        """The elements that must be there for it."""
        return self.element, self.place

    def write(self, to: Transaction | HypotheticalView) -> None:
        """Writes it into a transaction of the world, or into a supposed world."""
        to.place(_individual(to, self.element), self.relation, self.place)


@dataclass(frozen=True, slots=True)
class Remove:
    """An element is taken out of the scene."""

    element: str

    def __str__(self) -> str:
        return Message("remove {thing} from the scene", thing=self.element)

    @property
    def elements(self) -> tuple[str, ...]:
        """The elements that must be there for it."""
        return (self.element,)

    def write(self, to: Transaction | HypotheticalView) -> None:
        """Writes it into a transaction of the world, or into a supposed world."""
        to.remove(_individual(to, self.element))


@dataclass(frozen=True, slots=True)
class Add:
    """An element of a class is added.

    Attributes:
        class_: CURIE of its class.
        placement: Where it is put.
    """

    class_: str
    placement: Placement

    def __str__(self) -> str:
        where = {"relation": local_name(self.placement.relation), "place": self.placement.place}
        return Message("bring one more {kind}, {relation} {place}", kind=local_name(self.class_), **where)

    @property
    def elements(self) -> tuple[str, ...]:
        """The elements that must be there for it."""
        return (self.placement.place,)

    def write(self, to: Transaction | HypotheticalView) -> None:
        """Writes it into a transaction of the world, or into a supposed world."""
        to.add(self.class_, placement=self.placement)


@dataclass(frozen=True, slots=True)
class Assign:
    """A property gets a value.

    Attributes:
        element: Whose.
        property: CURIE of the property.
        value: The value.
        source: The thing of the same kind that the value is copied from; empty if there is none.
    """

    element: str
    property: str
    value: Value
    source: str = ""

    def __str__(self) -> str:
        of = {"thing": self.element, "property": local_name(self.property)}
        if self.source:
            return Message("give {thing} the {property} of {source}", source=self.source, **of)
        value = str(self.value).lower() if isinstance(self.value, bool) else shown(self.value)
        return Message("see to it that the {property} of {thing} is {value}, and say so", value=value, **of)

    @builtins.property  # the class has a field of that name
    def elements(self) -> tuple[str, ...]:
        """The elements that must be there for it."""
        return (self.element, self.source) if self.source else (self.element,)

    def write(self, to: Transaction | HypotheticalView) -> None:
        """Writes it into a transaction of the world, or into a supposed world."""
        to.set(_individual(to, self.element), self.property, self.value)


@dataclass(frozen=True, slots=True)
class Relate:
    """A relation that moves nothing is added.

    Attributes:
        subject, relation, object: The statement.
    """

    subject: str
    relation: str
    object: str

    def __str__(self) -> str:
        what = {"subject": self.subject, "relation": local_name(self.relation), "object": self.object}
        return Message("state that {subject} {relation} {object}", **what)

    @property
    def elements(self) -> tuple[str, ...]:
        """The elements that must be there for it."""
        return self.subject, self.object

    def write(self, to: Transaction | HypotheticalView) -> None:
        """Writes it into a transaction of the world, or into a supposed world."""
        to.relate(_individual(to, self.subject), self.relation, _individual(to, self.object))


SceneEdit = Move | Remove | Add | Assign | Relate
"""Any of them."""


def _individual(to: Transaction | HypotheticalView, name: str) -> str:
    """Returns the element that a name stands for; for a thing in stock, a transaction creates one."""
    return take(to, name) if isinstance(to, Transaction) and is_token(name) else name

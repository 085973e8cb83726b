"""The base class of reasoners, a kind of plug-in."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from skiros_py.errors import UsageError
from skiros_py.world.element import Value

if TYPE_CHECKING:
    from skiros_py.world.change import Edit, Writer
    from skiros_py.world.transaction import Transaction
    from skiros_py.world.view import WorldView


@dataclass(frozen=True, slots=True)
class Answer:
    """Whether a computed relation holds.

    Attributes:
        holds: Whether it does.
        reason: Why or why not, in words for people.
        value: What it was decided by (a distance [m], a room left [m]), or None if there is no such number.
    """

    holds: bool
    reason: str
    value: float | None = None


@dataclass(frozen=True, slots=True)
class ComputedRelation:
    """A computed relation that holds between two elements; ``value`` as in :class:`Answer`."""

    subject: str
    relation: str
    object: str
    value: float | None = None


@dataclass(frozen=True, slots=True)
class Proposal:
    """A change that is about to take effect.

    Attributes:
        before, after: The world without and with it.
        edits: What it changes.
        author: Who writes.
        writer: What kind of author that is.
    """

    before: WorldView
    after: WorldView
    edits: Sequence[Edit]
    author: str
    writer: Writer


class Reasoner:
    """Knows about one kind of data. A plug-in of the group ``skiros.reasoners`` names a subclass.

    A reasoner has no state of its own: everything it knows it reads from the view it is given, so the same reasoner
    serves the live world, snapshots and suppositions.

    Attributes:
        name: What it is called in messages.
        relations: CURIEs of the computed relations that it answers, each declared below ``sk:computed``.
        functions: Functions for SPARQL by CURIE (``BIND(sk:distance(?a, ?b) AS ?d)``), called with the view and the
            arguments: elements as ids, literals as values; None for no answer.
        keys: Names of the data that :meth:`data` reads and :meth:`store` writes.
    """

    name: ClassVar[str]
    relations: ClassVar[frozenset[str]] = frozenset()
    functions: ClassVar[Mapping[str, Callable[..., Value | None]]] = MappingProxyType({})
    keys: ClassVar[frozenset[str]] = frozenset()

    def answer(self, view: WorldView, subject: str, relation: str, object_: str) -> Answer:
        """Says whether one of its :attr:`relations` holds between two elements, and why."""
        raise NotImplementedError(f"{self.name} declares relations and must answer them")

    def pairs(
        self, view: WorldView, relation: str, subjects: Iterable[str], objects: Sequence[str]
    ) -> Iterator[tuple[str, str]]:
        """Yields the pairs between which a relation holds; overridden where many are found faster together."""
        for subject in subjects:
            for object_ in objects:
                if subject != object_ and self.answer(view, subject, relation, object_).holds:
                    yield subject, object_

    def between(self, view: WorldView, subject: str, object_: str) -> tuple[ComputedRelation, ...]:
        """Returns every one of its relations that holds from one element to another, with values, sorted."""
        answers = ((relation, self.answer(view, subject, relation, object_)) for relation in sorted(self.relations))
        return tuple(ComputedRelation(subject, r, object_, a.value) for r, a in answers if a.holds)

    def data(self, view: WorldView, element: str, key: str) -> Value | None:
        """Reads data from an element in the form that the key names ("pose in the map"), or None if it has none.

        Raises:
            UsageError: It has no such key.
        """
        raise UsageError(f"{self.name} reads no '{key}'")

    def store(self, tx: Transaction, element: str, key: str, value: Value) -> None:
        """Writes data into an element in the form that the key names.

        Raises:
            UsageError: It has no such key.
        """
        raise UsageError(f"{self.name} stores no '{key}'")

    def similarity(self, view: WorldView, a: str, b: str) -> float | None:
        """Returns how alike two elements are, from 0 to 1, or None if it cannot tell."""
        return None

    def classify(self, view: WorldView, element: str, classes: Sequence[str]) -> tuple[tuple[str, float], ...]:
        """Returns how likely an element is of each class, likeliest first; classes it cannot judge are left out."""
        return ()

    def veto(self, proposal: Proposal) -> str | None:
        """Says why a change must not take effect, or None. Called for every change: be quick."""
        return None

"""Use cases: the ontology, possible placements, and SPARQL queries."""

from __future__ import annotations

from collections.abc import Iterable
from decimal import Decimal
from itertools import islice

from skiros_py.api.ontology import ClassDetails, ClassNode, PlacementOptions, PropertyPage, RelationPage
from skiros_py.api.queries import Bound, DecimalLiteral, Query, TextLiteral
from skiros_py.errors import UsageError
from skiros_py.station.requests import Service, addressed
from skiros_py.station.world.answers import Answer
from skiros_py.station.world.ontology import class_details, class_tree, property_info, relation_info
from skiros_py.station.world.placements import placement_options
from skiros_py.station.world.values import given
from skiros_py.world.index import Index
from skiros_py.world.queries import Binding, Text
from skiros_py.world.vocabulary import ELEMENT


class OntologyService(Service):
    """Describes the ontology, and answers queries over all knowledge."""

    @property
    def _view(self) -> Index:
        return self._station.session.world.snapshot()

    def classes(self, root: str = ELEMENT, depth: int = 50) -> ClassNode:
        """Returns the classes as a tree; a class with several parents is below its primary one.

        Raises:
            NotFound: There is no such class.
        """
        with addressed():
            return class_tree(self._view, root, depth)

    def class_(self, name: str) -> ClassDetails:
        """Describes a class: properties of its elements, their number, and the arguments that accept them.

        Raises:
            NotFound: There is no such class.
        """
        session = self._station.session
        with addressed():
            return class_details(session.world.snapshot(), name, session.catalogue)

    def relations(self, limit: int = 1000, after: str = "") -> RelationPage:
        """Lists relations by name, with the classes at their ends."""
        view = self._view
        names, more = _page(view.ontology.relations, limit, after)
        return RelationPage(items=[relation_info(view, view.ontology.relations[name]) for name in names], next=more)

    def properties(self, limit: int = 1000, after: str = "") -> PropertyPage:
        """Lists properties by name, with data type and unit."""
        ontology = self._view.ontology
        names, more = _page(ontology.properties, limit, after)
        return PropertyPage(items=[property_info(ontology.properties[name]) for name in names], next=more)

    def placements(
        self,
        class_: str | None = None,
        element: str | None = None,
        relation: str | None = None,
        limit: int = 50,
        after: str | None = None,
    ) -> PlacementOptions:
        """Returns the possible placement relations of an element, and whether each place would accept it now.

        Args:
            class_: Class of a new element.
            element: Id of an existing element, instead of a class.
            relation: Only this relation.
            limit: Maximum number of places for each relation.
            after: Only places after this one; requires a relation.

        Raises:
            UsageError: Neither or both of class and element are given.
        """
        if (class_ is None) == (element is None):
            raise UsageError("say what is to be put somewhere: either class=kitting:Starter or element=starter_1")
        if after is not None and relation is None:
            raise UsageError("a cursor goes on with the places of one relation: give relation=sk:in, too")
        view = self._view
        what = view.element(element).type if element is not None else class_
        assert what is not None
        view.ontology.ancestors(what)
        return placement_options(view, what, element, limit, relation, after or "")

    def query(self, question: Query) -> Answer:
        """Answers SELECT, ASK or CONSTRUCT over ontology, scene, learned concepts and computed relations.

        Raises:
            UsageError: It cannot be parsed, or takes too long.
            Busy: Too many queries are being answered.
        """
        bindings = {name: _binding(value) for name, value in question.bindings.items()}
        return Answer(
            self._station.query_worker.answer(
                question.query, bindings, entailed=question.entailed, time_limit=question.time_limit
            )
        )


def _page(names: Iterable[str], limit: int, after: str) -> tuple[list[str], str | None]:
    found = list(islice((name for name in sorted(names) if name > after), limit + 1))
    return found[:limit], found[limit - 1] if len(found) > limit else None


def _binding(value: Bound) -> Binding:
    if isinstance(value, TextLiteral):
        return Text(value.text)
    if isinstance(value, DecimalLiteral):
        return Decimal(value.decimal)
    return given(value)

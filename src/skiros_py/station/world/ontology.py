"""Use cases of the ontology: classes, relations, properties and places; and queries in SPARQL."""

from __future__ import annotations

import csv
import io
import threading
from collections.abc import Iterable, Iterator, Mapping
from decimal import Decimal
from itertools import islice
from typing import Any

from skiros_py.api import ontology as api
from skiros_py.api.ontology import ClassDetails, ClassNode, PlacementOptions, PropertyPage, RelationInfoPage
from skiros_py.api.queries import Bound, DecimalLiteral, Query, TextLiteral
from skiros_py.catalogue import Catalogue
from skiros_py.errors import Busy, DeviceError, UsageError
from skiros_py.messages import Message
from skiros_py.station.requests import Service, addressed, admitted
from skiros_py.station.session import Session
from skiros_py.station.world.placements import placement_options
from skiros_py.station.world.values import given, plain
from skiros_py.world.element import Value
from skiros_py.world.index import Index
from skiros_py.world.literals import DATATYPES, format_value
from skiros_py.world.ontology import Ontology
from skiros_py.world.queries.answering import Binding, Constructed, Result, Table, Text
from skiros_py.world.queries.outside import OutsideQueries
from skiros_py.world.queries.replica import Limits
from skiros_py.world.taught import class_value
from skiros_py.world.terms import Property, Relation
from skiros_py.world.vocabulary import ELEMENT


class Answer:
    """The answer to a query.

    Args:
        result: The result from the world model.
    """

    def __init__(self, result: Result) -> None:
        self.result = result

    def data(self) -> dict[str, Any]:
        """Returns the answer as plain data."""
        result = self.result
        if isinstance(result, bool):
            return {"form": "ASK", "answer": result}
        if isinstance(result, Table):
            rows = [{name: plain(value) for name, value in row.items()} for row in result.rows]
            return {"form": "SELECT", "variables": list(result.variables), "rows": rows}
        statements = [[subject, predicate, plain(value)] for subject, predicate, value in result.statements]
        return {"form": "CONSTRUCT", "statements": statements, "turtle": result.turtle}

    def csv(self, line_end: str = "\r\n") -> str | None:
        """Returns the rows as CSV; None if the query is not SELECT, which alone has rows."""
        if not isinstance(self.result, Table):
            return None
        text = io.StringIO()
        writer = csv.writer(text, lineterminator=line_end)
        writer.writerow(self.result.variables)
        writer.writerows([shown_value(row[name]) for name in self.result.variables] for row in self.result.rows)
        return text.getvalue()

    def turtle(self) -> str | None:
        """Returns the triples as Turtle; None if the query is not CONSTRUCT, which alone has triples."""
        return self.result.turtle if isinstance(self.result, Constructed) else None


def shown_value(value: Value | None) -> str:
    """Returns a value as text; empty for None."""
    if value is None:
        return ""
    return value if isinstance(value, str) else format_value(value)


_LIMITS = Limits()


class Queries:
    """Answers queries about the world of the current session.

    Args:
        limits: Resource limits of one query.
    """

    def __init__(self, limits: Limits = _LIMITS) -> None:
        self._limits = limits
        self._turns = threading.BoundedSemaphore(limits.at_once)
        self._outside: OutsideQueries | None = None

    def answer(self, sparql: str, bindings: Mapping[str, Binding], *, entailed: bool, time_limit: float) -> Result:
        """Answers a query.

        Args:
            sparql: The query.
            bindings: Values of its parameters.
            entailed: True to include triples entailed by OWL.
            time_limit: Maximum duration [s].

        Raises:
            UsageError: It cannot be answered, or not within its limits; the text gives the reason.
            Busy: Too many queries are being answered already, or the station is being opened.
        """
        full = Message("{count} questions are being answered already: ask again later", count=self._limits.at_once)
        with admitted(self._turns, full):
            outside = self._outside
            if outside is None:
                raise Busy(Message("the station is not running: ask again later"))
            try:
                return outside.query(sparql, bindings, entailed=entailed, time_limit=time_limit)
            except DeviceError:
                if self._outside is outside:
                    raise
                raise Busy(Message("the station was closed meanwhile: ask again later")) from None

    def open(self, session: Session) -> None:
        """Answers queries about a session's world from now on."""
        self._outside = OutsideQueries(session.world, self._limits)
        session.on_close(self._outside.close, self._leave)

    def _leave(self) -> None:
        self._outside = None


class OntologyService(Service):
    """Describes the ontology, and answers queries over all knowledge.

    Labels and comments are in the language of a given tag, as far as the ontology has them, else in English.
    """

    @property
    def languages(self) -> tuple[str, ...]:
        """Tags of the languages in which the ontology has labels or comments, English first."""
        return self._world.ontology.languages

    def classes(self, root: str = ELEMENT, depth: int = 50, *, language: str = "en") -> ClassNode:
        """Returns the classes as a tree; a class with several parents is below its primary one.

        Raises:
            NotFound: There is no such class.
        """
        with addressed():
            return class_tree(self._world.snapshot(), root, depth, language)

    def class_(self, name: str, *, language: str = "en") -> ClassDetails:
        """Describes a class: properties of its elements, their number, and the arguments that accept them.

        Raises:
            NotFound: There is no such class.
        """
        session = self._station.session
        with addressed():
            return class_details(session.world.snapshot(), name, session.catalogue, language)

    def relations(self, limit: int = 1000, after: str = "", *, language: str = "en") -> RelationInfoPage:
        """Lists relations by name, with the classes at their ends."""
        view = self._world.snapshot()
        names, more = _page(view.ontology.relations, limit, after)
        relations = (view.ontology.relations[name].in_language(language) for name in names)
        return RelationInfoPage(items=[relation_info(view, one) for one in relations], next=more)

    def properties(self, limit: int = 1000, after: str = "", *, language: str = "en") -> PropertyPage:
        """Lists properties by name, with data type and unit."""
        ontology = self._world.ontology
        names, more = _page(ontology.properties, limit, after)
        properties = (ontology.properties[name].in_language(language) for name in names)
        return PropertyPage(items=[property_info(one) for one in properties], next=more)

    def placements(
        self,
        class_: str | None = None,
        element: str | None = None,
        relation: str | None = None,
        limit: int = 50,
        after: str | None = None,
        *,
        language: str = "en",
    ) -> PlacementOptions:
        """Returns the possible placement relations of an element, and whether each place would accept it now.

        Args:
            class_: Class of a new element.
            element: Id of an existing element, instead of a class.
            relation: Only this relation.
            limit: Maximum number of places for each relation.
            after: Only places after this one; requires a relation.
            language: Of the labels of the relations.

        Raises:
            UsageError: Neither or both of class and element are given.
        """
        if (class_ is None) == (element is None):
            raise UsageError("say what is to be put somewhere: either class=kitting:Starter or element=starter_1")
        if after is not None and relation is None:
            raise UsageError("a cursor goes on with the places of one relation: give relation=sk:in, too")
        view = self._world.snapshot()
        what = view.element(element).type if element is not None else class_
        assert what is not None
        view.ontology.ancestors(what)
        skills = self._station.session.tasks.skills.values()
        return placement_options(view, what, element, limit, relation, after or "", skills, language)

    def query(self, question: Query) -> Answer:
        """Answers SELECT, ASK or CONSTRUCT over ontology, scene, learned concepts and computed relations.

        Raises:
            UsageError: It cannot be parsed, or takes too long.
            Busy: Too many queries are being answered.
        """
        bindings = {name: _binding(value) for name, value in question.bindings.items()}
        ask = self._station.query_worker.answer
        return Answer(ask(question.query, bindings, entailed=question.entailed, time_limit=question.time_limit))


def _page(names: Iterable[str], limit: int, after: str) -> tuple[list[str], str | None]:
    found = list(islice((name for name in sorted(names) if name > after), limit + 1))
    return found[:limit], found[limit - 1] if len(found) > limit else None


def _binding(value: Bound) -> Binding:
    if isinstance(value, TextLiteral):
        return Text(value.text)
    if isinstance(value, DecimalLiteral):
        return Decimal(value.decimal)
    return given(value)


_MOST_SHOWN = 100
"""Maximum number of individuals returned with a class."""


# ------------------------------------------------------------------ classes


def class_tree(view: Index, root: str, depth: int, language: str) -> api.ClassNode:
    """Returns a class with its subclasses, each below its primary parent.

    Raises:
        UnknownName: It is not a class.
    """
    view.ontology.ancestors(root)
    return _node(view, root, _primary_children(view.ontology), depth, language)


def _primary_children(ontology: Ontology) -> Mapping[str, list[str]]:
    children: dict[str, list[str]] = {}
    for name, class_ in sorted(ontology.classes.items()):
        if class_.primary_parent is not None:
            children.setdefault(class_.primary_parent, []).append(name)
    return children


def _node(view: Index, name: str, children: Mapping[str, list[str]], depth: int, language: str) -> api.ClassNode:
    class_, below = view.ontology.classes[name], children.get(name, [])
    return api.ClassNode.view_of(
        class_.in_language(language),
        name=name,
        instances=view.count(name),
        children=[_node(view, child, children, depth - 1, language) for child in below] if depth else [],
        children_total=len(below),
    )


def class_details(view: Index, name: str, catalogue: Catalogue, language: str) -> api.ClassDetails:
    """Describes a class.

    Raises:
        UnknownName: It is not a class.
    """
    ontology = view.ontology
    ancestors = ontology.ancestors(name)
    properties = [one for _, one in sorted(ontology.properties.items()) if not ontology.missed_end(name, one.domains)]
    return api.ClassDetails.view_of(
        ontology.classes[name].in_language(language),
        name=name,
        ancestors=list(ancestors),
        subclasses=list(ontology.subclasses(name)),
        properties=[
            api.ClassProperty.view_of(
                property_info(one.in_language(language)), value=plain(class_value(view, name, one.curie))
            )
            for one in properties
        ],
        relations_from=[r.curie for r in _relations(ontology) if not ontology.missed_end(name, r.domains)],
        relations_to=[r.curie for r in _relations(ontology) if not ontology.missed_end(name, r.ranges)],
        how_many=ontology.cardinalities(name),
        instances=view.count(name),
        some_instances=list(view.some_instances(name, _MOST_SHOWN)),
        individuals=list(view.abstracts(name))[:_MOST_SHOWN],
        skills=list(_used(ontology, name, _skill_arguments(catalogue))),
        conditions=list(_used(ontology, name, _condition_arguments(catalogue))),
    )


def _used(ontology: Ontology, name: str, arguments: Iterable[tuple[str, str, str]]) -> Iterator[api.ClassUse]:
    """Yields the arguments that accept elements of a class, omitting very general ones."""
    for whose, argument, taken in sorted(set(arguments)):
        if taken in ontology.classes and taken != ELEMENT and ontology.is_a(name, taken):
            yield api.ClassUse(name=whose, argument=argument, class_=taken)


def _skill_arguments(catalogue: Catalogue) -> Iterator[tuple[str, str, str]]:
    for skill in catalogue.skills.values():
        for param in skill.description.params:
            if param.is_element:
                yield skill.description.name, param.key, param.element_class


def _condition_arguments(catalogue: Catalogue) -> Iterator[tuple[str, str, str]]:
    for name, condition in catalogue.conditions.items():
        yield from ((name, role.name, role.class_) for role in condition.roles)


# ------------------------------------------------------------------ relations and properties


def _relations(ontology: Ontology) -> list[Relation]:
    return [ontology.relations[name] for name in sorted(ontology.relations)]


def property_info(property_: Property) -> api.PropertyInfo:
    """Describes a property."""
    return api.PropertyInfo.view_of(
        property_,
        name=property_.curie,
        datatype=property_.range,
        says=DATATYPES[property_.range].says,
        borne_by=property_.domains,
    )


def relation_info(view: Index, relation: Relation) -> api.RelationInfo:
    """Describes a relation."""
    return api.RelationInfo.view_of(
        relation,
        name=relation.curie,
        family=relation.family.value,
        subjects=relation.domains,
        objects=relation.ranges,
        computed=view.reasoners.computes(relation.curie),
    )

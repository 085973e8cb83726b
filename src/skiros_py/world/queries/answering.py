"""Runs a query on a store, with parameters and computed relations; ``text.py`` has checked its text.

External queries go through :class:`~skiros_py.world.queries.outside.OutsideQueries`; nothing limits the time here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from decimal import Decimal

import pyoxigraph as ox

from skiros_py.errors import SkirosError, UsageError
from skiros_py.world.element import Value
from skiros_py.world.index import Index
from skiros_py.world.literals import ANY_LITERAL, any_value, format_value, literal_type
from skiros_py.world.names import Names
from skiros_py.world.ontology import Ontology
from skiros_py.world.queries.text import QueryText, parsed
from skiros_py.world.store.store import UNLIMITED, Answer, AnswerLimits, Functions, QuadStore, Rows, Term
from skiros_py.world.terms import Family
from skiros_py.world.view import WorldView
from skiros_py.world.world import World


class Text(str):
    """Marks a bound string as a literal; any other bound string is a name."""

    __slots__ = ()


Binding = Value | Decimal
"""The values of parameters. A pattern matches numbers of the same type only: for an ``xsd:decimal`` property, a
Decimal. ``FILTER`` compares numbers of all types."""


def bound_term(names: Names, value: Binding) -> ox.NamedNode | ox.Literal:
    """Returns the value of a parameter as a term.

    Args:
        names: The prefix table.
        value: A string is a scene id or CURIE, :class:`Text` a text, anything else a value.

    Raises:
        UsageError: It is neither a name nor a value.
    """
    if isinstance(value, str) and not isinstance(value, Text):
        try:
            return ox.NamedNode(names.iri(value))
        except ValueError as error:
            raise UsageError(f"'{value[:100]}' is no name: {error}") from None
    if isinstance(value, Decimal) and value.is_finite():
        return ox.Literal(f"{value:f}", datatype=ox.NamedNode(names.iri("xsd:decimal")))
    try:
        return literal(names, value)  # type: ignore[arg-type]  # what is no value raises
    except ValueError:
        raise UsageError(
            f"{value!r} is no value: bind a name, Text, bool, int, float, Decimal, Pose or vector"
        ) from None


def literal(names: Names, value: Value) -> ox.Literal:
    """Returns a value as a literal of the data type that corresponds to its Python type.

    Raises:
        ValueError: No property can have it.
    """
    if isinstance(value, str):
        return ox.Literal(str(value))
    datatype = ox.NamedNode(names.iri(literal_type(value, ANY_LITERAL)))
    return ox.Literal(format_value(value), datatype=datatype)


def value_of(names: Names, term: object) -> Value | None:
    """Returns a scene id or CURIE for a name, a Python value for a literal, None for no term."""
    if isinstance(term, ox.NamedNode):
        return names.name(term.value)
    if not isinstance(term, ox.Literal):
        return None if term is None else str(term)
    return any_value(term.value, names.name(term.datatype.value))


# ---------------------------------------------------------------- functions of reasoners


def called_functions(view: Index, iris: frozenset[str]) -> Functions:
    """Returns the reasoners' functions among what a query mentions, by IRI."""
    names = view.ontology.names
    offered = {names.iri(curie): f for reasoner in view.reasoners for curie, f in reasoner.functions.items()}
    return {iri: _as_terms(view, names, offered[iri]) for iri in sorted(iris & set(offered))}


def _as_terms(view: WorldView, names: Names, function: Callable[..., Value | None]) -> Callable[..., Term | None]:
    def call(*arguments: Term) -> Term | None:
        if any(isinstance(argument, ox.BlankNode) for argument in arguments):
            return None
        try:
            answer = function(view, *(value_of(names, argument) for argument in arguments))
            return None if answer is None else literal(names, answer)
        except (SkirosError, TypeError, ValueError):  # an error within an expression leaves its variable unbound
            return None

    return call


# ---------------------------------------------------------------- running a query on a store


@dataclass(frozen=True, slots=True)
class Table:
    """The answer to a SELECT.

    Attributes:
        variables: The columns.
        rows: One dictionary per row, by variable: scene ids and CURIEs as strings, literals as Python values, None
            where the row has no value.
    """

    variables: tuple[str, ...]
    rows: list[dict[str, Value | None]]


@dataclass(frozen=True, slots=True)
class Constructed:
    """The answer to a CONSTRUCT.

    Attributes:
        statements: Subject, predicate and object: scene ids and CURIEs as strings, literals as Python values.
        turtle: The same as the text of a Turtle file.
    """

    statements: tuple[tuple[str, str, Value], ...]
    turtle: str


Result = Table | bool | Constructed


@dataclass(frozen=True, slots=True)
class Question:
    """A query with its parameters bound; see :meth:`of`.

    Attributes:
        text: The query.
        sparql: The query as the engine reads it.
        iris: The IRIs in it and in its parameters.
    """

    text: QueryText
    sparql: str
    iris: frozenset[str]

    @classmethod
    def of(cls, names: Names, sparql: str, bindings: Mapping[str, Binding]) -> Question:
        """Binds the parameters of a query.

        Raises:
            UsageError: It is not a query that can be run; see :func:`~skiros_py.world.queries.answering.parsed`.
        """
        text = parsed(sparql, names)
        terms = {name: bound_term(names, value) for name, value in bindings.items()}
        bound = {term.value for term in terms.values() if isinstance(term, ox.NamedNode)}
        return cls(text, text.filled(terms), text.iris | bound if bound else text.iris)

    def answer(self, store: QuadStore, view: Index, limits: AnswerLimits = UNLIMITED) -> Answer:
        """Runs it on a store.

        Args:
            store: The store; not shared meanwhile.
            view: The state that it contains.
            limits: Maximum size of the answer.

        Raises:
            UsageError: It cannot be answered; the text says why.
        """
        relations, functions = mentioned_relations(view.ontology, self.iris), called_functions(view, self.iris)
        if not relations:
            return store.query(self.sparql, functions=functions, limits=limits)
        from skiros_py.world.queries.computed import worked_out  # with rdflib, which most queries do without

        with worked_out(store, view, self.sparql, relations):
            return store.query(self.sparql, functions=functions, limits=limits)


def mentioned_relations(ontology: Ontology, iris: frozenset[str]) -> frozenset[str]:
    """Returns the computed relations in a query, and their sub-relations, as CURIEs."""
    names = [ontology.names.name(iri) for iri in iris]
    named = [name for name in names if name in ontology.relations and ontology.family(name) is Family.COMPUTED]
    return frozenset(below for name in named for below in ontology.sub_relations(name))


def typed(names: Names, answer: Answer) -> Result:
    """Returns an answer with names and Python values instead of terms."""
    if isinstance(answer, bool):
        return answer
    if isinstance(answer, Rows):
        variables = answer.variables
        values = ((value_of(names, term) for term in row) for row in answer.rows)
        return Table(variables, [dict(zip(variables, row, strict=True)) for row in values])
    statements = tuple(tuple(value_of(names, term) for term in triple) for triple in answer)
    turtle = ox.serialize(answer, format=ox.RdfFormat.TURTLE, prefixes=dict(names.prefixes)) or b""
    return Constructed(statements, turtle.decode())  # type: ignore[arg-type]  # three each, and none is missing


# ---------------------------------------------------------------- queries by our own code


def select(world: World, sparql: str, *, entailed: bool = False, **bindings: Binding) -> list[dict[str, Value | None]]:
    """Runs a SELECT over all graphs as one; the ontology's prefixes and ``scene:`` are declared already.

    Computed relations can be used like any other if the query names them (``?a sk:near ?b``); they are evaluated for
    the elements in question. Reasoners' functions can be called (``BIND(sk:distance(?a, ?b) AS ?d)``).

    Args:
        world: The world.
        sparql: The query.
        entailed: Whether to include triples entailed by OWL: inverses, symmetry, transitivity, equivalence,
            sub-relations.
        bindings: Values of its parameters, written ``$name`` in the query: a string is a scene id or CURIE,
            :class:`Text` a text, anything else a value.

    Returns:
        One dictionary per row, by variable: scene ids and CURIEs as strings, literals as Python values, None where
        the row has no value.

    Raises:
        UsageError: It does not parse, is no SELECT, asks another server or names graphs to fetch, leaves a parameter
            unbound, or needs too many pairs of computed relations.
        UnknownName: It uses an undeclared prefix, or a computed relation that no reasoner computes.
    """
    result = _result(world, sparql, "SELECT", bindings, entailed=entailed)
    assert isinstance(result, Table)
    return result.rows


def ask(world: World, sparql: str, *, entailed: bool = False, **bindings: Binding) -> bool:
    """Runs an ASK; arguments and errors as for :func:`select`."""
    result = _result(world, sparql, "ASK", bindings, entailed=entailed)
    assert isinstance(result, bool)
    return result


def construct(world: World, sparql: str, *, entailed: bool = False, **bindings: Binding) -> Constructed:
    """Runs a CONSTRUCT; arguments and errors as for :func:`select`."""
    result = _result(world, sparql, "CONSTRUCT", bindings, entailed=entailed)
    assert isinstance(result, Constructed)
    return result


def query(world: World, sparql: str, *, entailed: bool = False, **bindings: Binding) -> Result:
    """Runs a query of any form; arguments and errors as for :func:`select`."""
    return _result(world, sparql, None, bindings, entailed=entailed)


def _result(world: World, sparql: str, form: str | None, bindings: dict[str, Binding], *, entailed: bool) -> Result:
    names = world.ontology.names
    question = Question.of(names, sparql, bindings)
    own = question.text.form
    if form not in (None, own):
        raise UsageError(f"the query is no {form} but {'an' if own == 'ASK' else 'a'} {own}: ask it by {own.lower()}()")
    with world.store.opened(entailed=entailed) as (store, view):
        answer = question.answer(store, view)
    return typed(names, answer)

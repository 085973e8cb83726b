"""Puts a query to a store, with all that it needs around it: prefixes, parameters, computed relations, functions."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from functools import lru_cache

import pyoxigraph as ox

from skiros_py.errors import UsageError
from skiros_py.world.element import Value
from skiros_py.world.index import Index
from skiros_py.world.names import Names
from skiros_py.world.ontology import Ontology
from skiros_py.world.queries.functions import called_functions
from skiros_py.world.queries.terms import Binding, bound_term, value_of
from skiros_py.world.queries.text import QueryText, parsed
from skiros_py.world.reasoners.registry import Reasoners
from skiros_py.world.store.store import UNLIMITED, Answer, Most, QuadStore, Rows
from skiros_py.world.terms import Family

__all__ = ["Constructed", "Question", "Result", "Table", "mentioned_relations", "typed"]


@dataclass(frozen=True, slots=True)
class Table:
    """What a SELECT answers.

    Attributes:
        variables: The columns.
        rows: One dictionary per row, by variable: scene ids and CURIEs as strings, literals as Python values, None
            where the row has no value.
    """

    variables: tuple[str, ...]
    rows: list[dict[str, Value | None]]


@dataclass(frozen=True, slots=True)
class Constructed:
    """What a CONSTRUCT answers.

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
        text: What it is.
        sparql: As the engine reads it.
        iris: What it mentions, parameters too.
    """

    text: QueryText
    sparql: str
    iris: frozenset[str]

    @classmethod
    def of(cls, names: Names, sparql: str, bindings: Mapping[str, Binding]) -> Question:
        """Binds the parameters of a query.

        Raises:
            UsageError: It is no query that can be put; see :func:`~skiros_py.world.queries.text.parsed`.
        """
        text = parsed(sparql, names)
        terms = {name: bound_term(names, value) for name, value in bindings.items()}
        bound = {term.value for term in terms.values() if isinstance(term, ox.NamedNode)}
        return cls(text, text.filled(terms), text.iris | bound if bound else text.iris)

    def must_be(self, form: str) -> None:
        """Checks what is asked for.

        Raises:
            UsageError: It is another form.
        """
        if self.text.form != form:
            raise UsageError(f"the query is no {form} but {_A[self.text.form]}: ask it by {self.text.form.lower()}()")

    def needs_state(self, ontology: Ontology, reasoners: Reasoners) -> bool:
        """Tells whether reasoners have a part in the answer."""
        return not self.iris.isdisjoint(_reasoned(ontology, reasoners))

    def answer(self, store: QuadStore, view: Index | None, most: Most = UNLIMITED) -> Answer:
        """Puts it to a store.

        Args:
            store: What is asked; nobody else may use it meanwhile.
            view: The state that it holds, or None where no reasoner has a part in the answer.
            most: How large the answer may get.

        Raises:
            UsageError: It cannot be answered; the text says why.
        """
        if view is None:
            return store.query(self.sparql, most=most)
        with self._worked_out(store, view):
            return store.query(self.sparql, functions=called_functions(view, self.iris), most=most)

    def _worked_out(self, store: QuadStore, view: Index) -> AbstractContextManager[None]:
        relations = mentioned_relations(view.ontology, self.iris)
        if not relations:
            return nullcontext()
        from skiros_py.world.queries.computed import worked_out  # with rdflib, which most queries do without

        return worked_out(store, view, self.sparql, relations)


def mentioned_relations(ontology: Ontology, iris: frozenset[str]) -> frozenset[str]:
    """Returns the computed relations among what a query mentions, and those below them, as CURIEs."""
    names = [ontology.names.name(iri) for iri in iris]
    named = [name for name in names if name in ontology.relations and ontology.family(name) is Family.COMPUTED]
    return frozenset(below for name in named for below in ontology.sub_relations(name))


_A = {"SELECT": "a SELECT", "ASK": "an ASK", "CONSTRUCT": "a CONSTRUCT"}


def typed(names: Names, answer: Answer) -> Result:
    """Returns an answer with names and Python values for terms."""
    if isinstance(answer, bool):
        return answer
    if isinstance(answer, Rows):
        variables = answer.variables
        values = ((value_of(names, term) for term in row) for row in answer.rows)
        return Table(variables, [dict(zip(variables, row, strict=True)) for row in values])
    statements = tuple(tuple(value_of(names, term) for term in triple) for triple in answer)
    turtle = ox.serialize(answer, format=ox.RdfFormat.TURTLE, prefixes=dict(names.prefixes)) or b""
    return Constructed(statements, turtle.decode())  # type: ignore[arg-type]  # three each, and none is missing


@lru_cache(maxsize=8)
def _reasoned(ontology: Ontology, reasoners: Reasoners) -> frozenset[str]:
    """IRIs of all that reasoners compute: relations and functions."""
    computed = (name for name, relation in ontology.relations.items() if relation.family is Family.COMPUTED)
    functions = (name for reasoner in reasoners for name in reasoner.functions)
    return frozenset(ontology.names.iri(name) for name in (*computed, *functions))

"""SPARQL over ontology, scene and what was learned, for people and outside programs; never for the control cycle.

Queries by strangers go through :class:`~skiros_py.world.queries.outside.OutsideQueries`: what runs for ever here does.
"""

from __future__ import annotations

from skiros_py.world.element import Value
from skiros_py.world.queries.answering import Binding, Constructed, Question, Result, Table, typed
from skiros_py.world.world import World


def select(world: World, sparql: str, *, entailed: bool = False, **bindings: Binding) -> list[dict[str, Value | None]]:
    """Runs a SELECT over all graphs as one; the ontology's prefixes and ``scene:`` are declared already.

    Relations that a reasoner computes answer like any other where the query names them (``?a sk:near ?b``); they are
    worked out for what the query asks. Reasoners' functions can be called (``BIND(sk:distance(?a, ?b) AS ?d)``).

    Args:
        world: What is asked.
        sparql: The query.
        entailed: Whether what OWL entails counts too: inverses, symmetry, transitivity, equivalence, sub-relations.
        bindings: What its parameters stand for, written ``$name`` in the query: a string is a scene id or CURIE,
            :class:`Text` a text, anything else a value.

    Returns:
        One dictionary per row, by variable: scene ids and CURIEs as strings, literals as Python values, None where
        the row has no value.

    Raises:
        UsageError: It does not parse, is no SELECT, asks another server or names graphs to fetch, leaves a parameter
            unbound, or asks for more computed relations than can be worked out.
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
    if form is not None:
        question.must_be(form)
    if entailed or question.needs_state(world.ontology, world.reasoners):
        with world.store.opened_with_state(entailed=entailed) as (store, view):
            answer = question.answer(store, view)
            return typed(names, answer)
    with world.store.opened() as store:
        answer = question.answer(store, None)
    return typed(names, answer)

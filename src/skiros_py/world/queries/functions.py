"""The reasoners' functions, as SPARQL calls them: ``BIND(sk:distance(?a, ?b) AS ?d)``."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import pyoxigraph as ox

from skiros_py.errors import SkirosError
from skiros_py.world.element import Value
from skiros_py.world.queries.terms import literal, value_of
from skiros_py.world.store.store import Functions, Term

if TYPE_CHECKING:
    from skiros_py.world.index import Index
    from skiros_py.world.names import Names
    from skiros_py.world.view import WorldView

__all__ = ["called_functions"]


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

"""SPARQL over ontology and scene, for people and outside programs; never for the control cycle."""

from __future__ import annotations

import re

import pyoxigraph as ox

from skiros_py.errors import UsageError
from skiros_py.world.element import Value
from skiros_py.world.literals import any_value
from skiros_py.world.names import Names
from skiros_py.world.world import World

__all__ = ["Text", "ask", "select"]


_TOKEN = re.compile(
    r"""'''.*?'''|\"\"\".*?\"\"\"|'(?:[^'\\\n]|\\.)*'|"(?:[^"\\\n]|\\.)*"|<[^<>\s]*>|#[^\n]*|[$?\w:][\w:-]*""",
    re.DOTALL,
)


class Text(str):
    """Marks a bound text as a literal; any other string that is bound is a name."""

    __slots__ = ()


def select(world: World, sparql: str, **bindings: str | bool | float) -> list[dict[str, Value | None]]:
    """Runs a SELECT over all graphs as one; the ontology's prefixes and ``scene:`` are declared already.

    Args:
        world: What is asked.
        sparql: The query.
        bindings: What its parameters stand for, written ``$name`` in the query: a string is a scene id or CURIE,
            :class:`Text` a text.

    Returns:
        One dictionary per row, by variable: scene ids and CURIEs as strings, literals as Python values, None where
        the row has no value.

    Raises:
        UsageError: It does not parse, is no SELECT, or asks another server.
    """
    with world.store.opened() as store:
        result = _run(store, world.ontology.names, sparql, bindings)
        if not isinstance(result, ox.QuerySolutions):
            raise UsageError("the query is no SELECT")
        variables = [variable.value for variable in result.variables]
        rows = [tuple(row) for row in result]
    return [{n: _value(world.ontology.names, term) for n, term in zip(variables, row, strict=True)} for row in rows]


def ask(world: World, sparql: str, **bindings: str | bool | float) -> bool:
    """Runs an ASK; arguments as for :func:`select`.

    Raises:
        UsageError: It does not parse, is no ASK, or asks another server.
    """
    with world.store.opened() as store:
        result = _run(store, world.ontology.names, sparql, bindings)
        if not isinstance(result, ox.QueryBoolean):
            raise UsageError("the query is no ASK")
        return bool(result)


def _run(
    store: ox.Store, names: Names, sparql: str, bindings: dict[str, str | bool | float]
) -> ox.QuerySolutions | ox.QueryBoolean | ox.QueryTriples:
    terms = {name: _term(names, value) for name, value in bindings.items()}
    try:
        return store.query(_filled(sparql, terms), prefixes=dict(names.prefixes), use_default_graph_as_union=True)
    except SyntaxError as error:
        raise UsageError(f"the query does not parse: {error.msg}") from None


def _filled(sparql: str, terms: dict[str, str]) -> str:
    """Puts terms in the place of parameters; in texts, IRIs and comments nothing is a parameter or a keyword."""
    unused = set(terms)

    def fill(match: re.Match[str]) -> str:
        word = match[0]
        if word.upper() == "SERVICE":
            raise UsageError("the query asks another server (SERVICE); only this world can be asked")
        if not word.startswith("$"):
            return word
        if word[1:] not in terms:
            raise UsageError(f"nothing is bound to {word}; bound: {', '.join(sorted(terms)) or 'nothing'}")
        unused.discard(word[1:])
        return terms[word[1:]]

    filled = _TOKEN.sub(fill, sparql)
    if unused:
        raise UsageError(f"the query has no parameter ${', $'.join(sorted(unused))}")
    return filled


def _term(names: Names, value: str | bool | float) -> str:
    """The term as the engine writes it, checked and escaped, so that no value can become query text."""
    try:
        if isinstance(value, str) and not isinstance(value, Text):
            return str(ox.NamedNode(names.iri(value)))
    except ValueError as error:
        raise UsageError(f"'{value}' is no name: {error}") from None
    return str(ox.Literal(str(value) if isinstance(value, Text) else value))


def _value(names: Names, term: object) -> Value | None:
    if isinstance(term, ox.NamedNode):
        return names.name(term.value)
    if not isinstance(term, ox.Literal):
        return None if term is None else str(term)
    return any_value(term.value, names.name(term.datatype.value))

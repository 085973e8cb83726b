"""What is wrong with a query that does not parse is said with its place, and without the engine's list of signs."""

from __future__ import annotations

import pyoxigraph as ox
import pytest

from skiros_py.world.store.store import parse_fault


@pytest.mark.parametrize(
    ("query", "words"),
    [
        (
            "SELECT * WHERE {",
            "line 1: the query ends too early; expected a variable, a name, a value, '{', '}' or '('",
        ),
        ("SELECT ?x { ?x ?y ?z } LIMIT", "line 1: the query ends too early; expected a number"),
        ("SELECT * {\n ?x a <http://a/b#Kit>\n ?y }", "line 3: something is wrong near 'Kit ?y }'"),
        ("SELECT * { ?s ?p }", "line 1: something is wrong near '?s ?p }'"),
        (
            "SELECT ?x ?y { ?x ?p ?y }\nGROUP BY ?x",
            "line 2: The SELECT contains a variable that is unbound",
        ),
        ("SELECT * { ?x nowhere:a ?y }", "line 1: Prefix not found"),
        ("SELECT * { ?x <a b> ?y }", "line 1: IRI parsing failed"),
        (
            "SELECT (1 AS ?x) { ?x ?p ?y }",
            "line 1: The SELECT overrides an existing variable using an expression",
        ),
        ("SELECT WHERE { ?x ?y ?z }", "line 1: something is wrong near 'SELECT WHERE { ?x ?y'"),
    ],
)
def test_a_parse_fault_names_the_position_and_the_expected_token(query: str, words: str) -> None:
    with pytest.raises(SyntaxError) as raised:
        ox.Store().query(query)

    assert parse_fault(query, raised.value.msg) == words


def test_an_unrecognised_engine_message_is_returned_unchanged() -> None:
    assert parse_fault("ASK {}", "too deep") == "too deep"

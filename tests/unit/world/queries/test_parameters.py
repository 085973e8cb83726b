"""What is bound to a parameter is one term, whatever it says; what cannot be asked is refused with words."""

from __future__ import annotations

from decimal import Decimal
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_py.errors import UnknownName, UsageError
from skiros_py.geometry import Pose
from skiros_py.world.element import Value
from skiros_py.world.ontology import Ontology
from skiros_py.world.queries.answering import Constructed, Table, Text, ask, construct, query, select
from skiros_py.world.world import World

ROOT = Path(__file__).parents[4]
EMPTY = World(Ontology.load([ROOT / "ontologies"]))
NASTY = [
    "'",
    '"',
    '"""',
    "'''",
    "\\",
    '\\"',
    "} DROP ALL #",
    '" } ; DROP ALL #',
    "> . DROP ALL",
    "line one\nline two\r\n\ttabbed",
    "$label ?label",
    "\\u0022 } DROP ALL",
    "{{{{}}}}",
    "SERVICE <http://a.example/>",
    "naïve 漢字 🤖",
    "",
    " ",
]


@pytest.fixture
def marked(ontology: Ontology) -> World:
    world = World(ontology)
    with world.transaction("test", "two things") as tx:
        tx.add("sk:Floor", "plain floor", id="floor_1")
        tx.add("sk:Floor", "other floor", id="floor_2")
    return world


# ---------------------------------------------------------------- texts and names


@pytest.mark.parametrize("text", NASTY)
def test_a_bound_text_matches_only_equal_texts_and_changes_nothing(marked: World, text: str) -> None:
    version = marked.version
    asked = "SELECT ?back ?s { BIND($label AS ?back) OPTIONAL { ?s rdfs:label $label } }"

    assert select(marked, asked, label=Text(text)) == [{"back": text, "s": None}]
    assert marked.version == version
    assert len(select(marked, "SELECT ?s { ?s a sk:Floor }")) == 2


@settings(max_examples=100, deadline=None)
@given(st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=30))
def test_any_text_comes_back_as_it_was_bound(text: str) -> None:
    rows = select(EMPTY, "SELECT ($text AS ?back) {}", text=Text(text))

    assert rows == [{"back": text}]


@pytest.mark.parametrize(
    "name",
    ["pallet_a> . DROP ALL", "floor_1> ?p ?o . <x", "a b", "a\nb", 'a"b', "a{b}", "<http://a.example/>", "a`b", "a|b"],
)
def test_a_string_that_is_not_a_name_is_refused(marked: World, name: str) -> None:
    with pytest.raises((UsageError, UnknownName), match=r"is no name|unknown prefix"):
        ask(marked, "ASK { $thing ?p ?o }", thing=name)


def test_a_bound_str_is_a_name_and_a_bound_text_is_a_literal(marked: World) -> None:
    by_label = "SELECT ?s { ?s rdfs:label $what }"

    assert select(marked, by_label, what=Text("plain floor")) == [{"s": "floor_1"}]
    assert select(marked, by_label, what="floor_1") == []
    assert select(marked, "SELECT ?label { $what rdfs:label ?label }", what="floor_1") == [{"label": "plain floor"}]


def test_a_name_parameter_can_be_subject_predicate_or_object(marked: World) -> None:
    rows = select(marked, "SELECT ?s { ?s $p $o }", p="rdf:type", o="sk:Floor")

    assert sorted(str(row["s"]) for row in rows) == ["floor_1", "floor_2"]
    assert ask(marked, "ASK { $s a sk:Floor }", s="floor_2")


def test_a_parameter_can_occur_twice_and_beside_another_parameter(marked: World) -> None:
    rows = select(marked, "SELECT ?x { VALUES ?x { $a$b$a } }", a="floor_1", b=7)

    assert [row["x"] for row in rows] == ["floor_1", 7, "floor_1"]


def test_dollar_names_in_strings_comments_and_iris_are_not_parameters(marked: World) -> None:
    assert not ask(marked, "ASK { ?s rdfs:label '$a' , \"$b\" } # $c")
    assert not ask(marked, "ASK { ?s ?p <http://a.example/$d> }")


# ---------------------------------------------------------------- values


@pytest.mark.parametrize(
    "value",
    [0, -7, 10**12, 0.0, 0.1, -2.5e-30, 1e300, True, False, Pose(), Pose.of(1, -2, 3, yaw=0.5), (1.0, 2.5, -3.0)],
    ids=str,
)
def test_a_value_comes_back_as_it_was_bound(marked: World, value: Value) -> None:
    (row,) = select(marked, "SELECT ($value AS ?back) {}", value=value)

    assert row["back"] == value
    assert type(row["back"]) is type(value)


def test_a_number_finds_and_compares_numbers(world: World) -> None:
    assert select(world, "SELECT ?s { ?s sk:width $width }", width=320) == [{"s": "camera_1"}]
    assert select(world, "SELECT ?s { ?s sk:mass $mass }", mass=Decimal("0.90")) == [{"s": "kitting:Alternator"}]
    assert ask(world, "ASK { scene:starter_1 a/rdfs:subClassOf* ?c . ?c ?p ?m FILTER($low < $high) }", low=-1, high=2.5)
    assert not ask(world, "ASK { FILTER($low < $high) }", low=3, high=2.5)


@pytest.mark.parametrize("value", [None, object(), Decimal("NaN"), [1, 2], {"a": 1}, b"bytes"])
def test_binding_an_unsupported_type_is_refused_with_the_supported_types(marked: World, value: Value) -> None:
    with pytest.raises(UsageError, match=r"is no value: bind a name, Text, bool, int, float, Decimal, Pose or vector"):
        ask(marked, "ASK { ?s ?p $value }", value=value)


# ---------------------------------------------------------------- what does not fit


def test_an_unknown_prefix_is_named(marked: World) -> None:
    with pytest.raises(UnknownName, match=r"unknown prefix 'kiting'.*Did you mean 'kitting'"):
        ask(marked, "ASK { ?s a kiting:Starter }")


def test_an_unknown_prefix_of_a_bound_name_is_named(marked: World) -> None:
    with pytest.raises((UnknownName, UsageError), match="kiting"):
        ask(marked, "ASK { ?s a $class }", **{"class": "kiting:Starter"})


def test_a_query_may_declare_a_prefix_of_its_own(marked: World) -> None:
    mine = "PREFIX mine: <https://w3id.org/skiros-py/core#>\nASK { ?s a mine:Floor }"

    assert ask(marked, mine)


def test_missing_parameters_are_named_with_those_that_are_bound(marked: World) -> None:
    with pytest.raises(UsageError, match=r"nothing is bound to \$a, \$c; bound: b"):
        ask(marked, "ASK { $a $b $c }", b="sk:in")
    with pytest.raises(UsageError, match=r"nothing is bound to \$a; bound: nothing \(variables are written \?name\)"):
        ask(marked, "ASK { $a ?b ?c }")


def test_superfluous_parameters_are_named(marked: World) -> None:
    with pytest.raises(UsageError, match=r"the query has no parameter \$place"):
        ask(marked, "ASK { ?s sk:in ?place }", place="floor_1")


def test_a_query_that_changes_something_is_refused_and_nothing_changes(marked: World) -> None:
    version = marked.version
    for update in ("INSERT DATA { scene:x a sk:Floor }", "DELETE WHERE { ?s ?p ?o }", "DROP ALL", "CLEAR DEFAULT"):
        word = update.split()[0]
        with pytest.raises(UsageError, match=f"{word} changes triples, and a query cannot"):
            query(marked, update)

    assert marked.version == version
    assert len(select(marked, "SELECT ?s { ?s a sk:Floor }")) == 2


@pytest.mark.parametrize(
    ("call", "sparql", "says"),
    [
        (select, "ASK {}", "the query is no SELECT but an ASK: ask it by ask()"),
        (select, "CONSTRUCT WHERE { ?a ?b ?c }", "the query is no SELECT but a CONSTRUCT: ask it by construct()"),
        (ask, "SELECT * {}", "the query is no ASK but a SELECT: ask it by select()"),
        (construct, "select * {}", "the query is no CONSTRUCT but a SELECT: ask it by select()"),
        (query, "DESCRIBE scene:floor_1", "DESCRIBE does not say what it answers: write CONSTRUCT"),
        (query, "BASE <http://a.example/> ASK {}", "the query shortens IRIs by BASE"),
        (query, "", "the query is empty: it needs SELECT, ASK or CONSTRUCT"),
        (query, " # nothing", "the query is empty: it needs SELECT, ASK or CONSTRUCT"),
        (query, "FIND ?x", "the query begins with 'FIND', and must with SELECT, ASK or CONSTRUCT"),
        (query, "ASK { ?s rdfs:label 'open }", "line 1: a text is not closed"),
        (query, "ASK {\n ?s $ ?o }", "line 2: $ begins a parameter, and a name must follow"),
    ],
)
def test_calling_the_function_of_another_query_form_names_the_right_function(
    marked: World, call: object, sparql: str, says: str
) -> None:
    with pytest.raises(UsageError) as refused:
        call(marked, sparql)  # type: ignore[operator]

    assert says in str(refused.value)


def test_query_returns_a_table_a_boolean_or_triples_depending_on_the_query_form(marked: World) -> None:
    assert isinstance(query(marked, "SELECT ?s { ?s a sk:Floor }"), Table)
    assert query(marked, "ASK { ?s a sk:Floor }") is True
    made = query(marked, "CONSTRUCT { ?s a sk:Floor } WHERE { ?s a sk:Floor }")
    assert isinstance(made, Constructed)
    assert sorted(made.statements) == [("floor_1", "rdf:type", "sk:Floor"), ("floor_2", "rdf:type", "sk:Floor")]
    assert "scene:floor_1" in made.turtle

"""Computed relations answer as if every pair of them were stored."""

from __future__ import annotations

import re
import zlib
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import count
from pathlib import Path
from typing import ClassVar

import pyoxigraph as ox
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_py.errors import UnknownName, UsageError
from skiros_py.world.element import Placement, Value
from skiros_py.world.ontology import Ontology
from skiros_py.world.queries.answering import Question, Table, ask, construct, mentioned_relations, select, typed
from skiros_py.world.reasoners.registry import Answer, Reasoner, Reasoners
from skiros_py.world.store import projection
from skiros_py.world.store.projection import Projection
from skiros_py.world.store.store import COMPUTED_GRAPH, QuadStore, Rows
from skiros_py.world.view import WorldView
from skiros_py.world.world import World

from ..rdflib_store import RdflibStore  # noqa: TID252  the tests are no installed package

ROOT = Path(__file__).parents[4]
ONTOLOGY = Ontology.load([ROOT / "ontologies"])
RELATIONS = ("sk:near", "sk:leftOf")


def drawn(subject: str, relation: str, object_: str) -> bool:
    """One pair in four, by lot, but always the same."""
    return subject != object_ and zlib.crc32(f"{subject} {relation} {object_}".encode()) % 4 == 0


def letters(view: WorldView, a: Value, b: Value) -> Value | None:
    if not isinstance(a, str) or not isinstance(b, str):
        raise TypeError
    view.element(a)
    return float(len(a) + len(b)) if a != b else None


class Lottery(Reasoner):
    name = "lottery"
    relations = frozenset(RELATIONS)
    functions: ClassVar = {"sk:letters": letters}
    asked: ClassVar[list[tuple[int, int]]] = []

    def answer(self, view: WorldView, subject: str, relation: str, object_: str) -> Answer:
        return Answer(drawn(subject, relation, object_), "by lot")

    def pairs(self, view, relation, subjects, objects):  # type: ignore[no-untyped-def]
        subjects = tuple(subjects)
        self.asked.append((len(subjects), len(objects)))
        return super().pairs(view, relation, subjects, objects)


REASONERS = Reasoners([Lottery()])


def a_world(parts: int = 5) -> World:
    world = World(ONTOLOGY, reasoners=REASONERS)
    with world.transaction("test", "a few things") as tx:
        tx.add("sk:Floor", id="floor")
        for place in ("pallet_a", "pallet_b"):
            tx.add("kitting:Pallet", id=place, placement=Placement("sk:on", "floor"))
        for number in range(parts):
            class_ = ("kitting:Starter", "kitting:Alternator")[number % 2]
            place = ("pallet_a", "pallet_b")[number % 3 % 2]
            tx.add(class_, id=f"part_{number}", placement=Placement("sk:in", place))
    return world


WORLD = a_world()


def all_pairs(world: World, store: QuadStore, relations: frozenset[str]) -> None:
    names = world.ontology.names
    for relation in sorted(relations):
        for below in REASONERS.narrowest(world.ontology, relation):
            for a in world.instances("sk:SpatialThing"):
                for b in world.instances("sk:SpatialThing"):
                    if drawn(a, below, b):
                        ends = ox.NamedNode(names.iri(a)), ox.NamedNode(names.iri(relation)), ox.NamedNode(names.iri(b))
                        store.add(ox.Quad(*ends, COMPUTED_GRAPH))


def oracle(world: World, sparql: str, make: Callable[[], QuadStore] = QuadStore) -> object:
    """The answer where every pair of the relations that the query mentions is stored."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(projection, "QuadStore", make)
        store = Projection(world.snapshot()).store
    question = Question.of(world.ontology.names, sparql, {})
    mentioned = mentioned_relations(world.ontology, question.iris)
    all_pairs(world, store, frozenset(r for r in mentioned if r in RELATIONS or r == "sk:computed"))
    answer = store.query(question.sparql)
    assert isinstance(answer, Rows)
    table = typed(world.ontology.names, answer)
    assert isinstance(table, Table)
    return counted(table.rows)


def counted(rows: list[dict[str, Value | None]]) -> Counter[tuple[tuple[str, str], ...]]:
    """Rows in no order; rdflib leaves those without any value out."""
    said = (row for row in rows if any(value is not None for value in row.values()))
    return Counter(tuple(sorted((name, repr(value)) for name, value in row.items())) for row in said)


# ---------------------------------------------------------------- queries by lot

ends = st.sampled_from(
    ["?a", "?b", "?c", "?a", "?b", "?c", "scene:part_0", "scene:pallet_a", "scene:part_3", "[]", "_:x"]
)
predicates = st.sampled_from(
    [
        "sk:near",
        "sk:leftOf",
        "sk:near",
        "sk:in",
        "sk:on",
        "a",
        "rdf:type/rdfs:subClassOf*",
        "?p",
        "^sk:near",
        "sk:near/sk:in",
        "sk:in/^sk:in",
        "sk:near/sk:leftOf",
        "sk:near|sk:in",
        "sk:near?",
        "sk:near+",
        "^sk:leftOf/sk:near",
        "!sk:in",
        "!(sk:near|^sk:in)",
        "(sk:near/sk:near)?",
        "(sk:near|^sk:leftOf)",
        "sk:computed",
        "sk:in*",
        "(^sk:near)*",
    ]
)
objects = st.one_of(ends, st.sampled_from(["kitting:Starter", "kitting:Part"]))
triples = st.builds("{} {} {} .".format, ends, predicates, objects)
blocks = st.lists(triples, min_size=1, max_size=3).map(" ".join)
filters = st.sampled_from(
    [
        "FILTER(?a = scene:part_0)",
        "FILTER(?b IN (scene:part_0, scene:part_1))",
        "FILTER(?a != ?b)",
        "FILTER(BOUND(?c))",
        "FILTER(scene:part_2 = ?b && ?a != ?b)",
        "FILTER(?a = scene:part_1 || ?b = scene:part_0)",
    ]
)
tables = st.sampled_from(
    [
        "VALUES ?a { scene:part_0 scene:part_1 }",
        "VALUES (?a ?b) { (scene:part_0 UNDEF) (scene:part_1 scene:part_2) }",
        "BIND(scene:part_0 AS ?z)",
        "VALUES ?p { sk:near sk:in }",
    ]
)


def nested(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    return st.one_of(
        st.builds("{} OPTIONAL {{ {} }}".format, inner, inner),
        st.builds("{} OPTIONAL {{ {} {} }}".format, inner, inner, filters),
        st.builds("{{ {} }} UNION {{ {} }}".format, inner, inner),
        st.builds("{} MINUS {{ {} }}".format, inner, inner),
        st.builds("{} FILTER NOT EXISTS {{ {} }}".format, inner, inner),
        st.builds("{} FILTER EXISTS {{ {} }}".format, inner, inner),
        st.builds("{{ {} }} {{ {} }}".format, inner, inner),
        st.builds("{} {{ SELECT DISTINCT ?a {{ {} }} }}".format, inner, inner),
        st.builds("{{ SELECT ?b (COUNT(?a) AS ?n) {{ {} }} GROUP BY ?b }} {}".format, inner, inner),
        # Of nothing, "?" and "*" make a path from each thing to itself: whatever there is in a graph.
        st.builds(
            "{} GRAPH ?g {{ {} }}".format, inner, inner.filter(lambda block: not re.search(r"\w[*?]|\)[*?]", block))
        ),
        st.builds("{} {}".format, inner, filters),
        st.builds("{} {}".format, tables, inner),
    )


groups = st.recursive(blocks, nested, max_leaves=4)


def apart(sparql: str) -> str:
    """Labels of blank nodes may be used in one group only, and a variable may be given a value once only."""
    number = count()
    return re.sub(r"_:x|\?z", lambda name: f"{name[0]}{next(number)}", sparql)


@settings(max_examples=150, deadline=None, derandomize=True)  # some by lot would take for ever
@given(groups.map(apart))
def test_a_query_for_a_computed_relation_answers_as_if_every_pair_were_stored(group: str) -> None:
    sparql = f"SELECT * {{ {group} }}"

    assert counted(select(WORLD, sparql)) == oracle(WORLD, sparql)


HARD = {
    "what_is_optional_need_not_hold": "{ ?c a kitting:Pallet OPTIONAL { ?b sk:on ?c } } { ?b sk:near ?c }",
    "what_is_outside_says_nothing_of_an_option": "?b a kitting:Starter { ?c sk:on ?d OPTIONAL { ?b sk:leftOf ?c } }",
    "nor_of_what_is_taken_away": "?b a kitting:Starter { ?c rdfs:label ?d MINUS { ?b sk:leftOf ?c } }",
    "nor_of_what_must_not_be": "?b a kitting:Starter { ?c rdfs:label ?d FILTER NOT EXISTS { ?b sk:leftOf ?c } }",
    "nor_of_what_is_counted": "?a a kitting:Starter { SELECT ?b (COUNT(?a) AS ?n) { ?a sk:near ?b } GROUP BY ?b }",
    "nor_of_what_is_cut_off": "?a a kitting:Starter { SELECT ?a { ?a sk:near ?b } ORDER BY DESC(?a) LIMIT 5 }",
    "nor_of_names_within_a_subquery": "?a a kitting:Alternator { SELECT ?b { ?a sk:near ?b } }",
    "one_choice_is_not_the_other": "{ { ?a a kitting:Starter } UNION { ?a a kitting:Pallet } } { ?a sk:near ?b }",
    "stations_of_two_paths_are_two": "?a sk:in/sk:on ?b OPTIONAL { ?d sk:on/rdf:type ?e ; sk:near ?a }",
    "an_option_within_an_option": "?a sk:on ?b OPTIONAL { ?c sk:near ?a OPTIONAL { ?d sk:leftOf ?c ; sk:in ?b } }",
    "a_variable_stands_for_all_mentioned": "VALUES ?p { sk:near sk:leftOf } scene:part_0 ?p ?b",
    "all_but_one_stand_for_the_others": "scene:part_0 !sk:near ?b . ?b sk:leftOf* ?c",
    "a_blank_node_is_a_variable": "[] sk:near ?a ; sk:in [ sk:leftOf ?b ] .",
}


@pytest.mark.parametrize("group", HARD.values(), ids=HARD)
def test_constraints_around_a_computed_pattern_never_change_the_result(group: str) -> None:
    sparql = f"SELECT * {{ {group} }}"

    found = counted(select(WORLD, sparql))

    assert found == oracle(WORLD, sparql)
    assert found


plain = blocks.filter(lambda block: "!" not in block)  # it cannot read inverses there
simple = st.one_of(plain, st.builds("{} OPTIONAL {{ {} }}".format, plain, plain))
simple = st.one_of(simple, st.builds("{{ {} }} UNION {{ {} }}".format, plain, plain))
simple = st.one_of(simple, st.builds("{} MINUS {{ {} }}".format, plain, plain))
simple = st.one_of(simple, st.builds("{} FILTER NOT EXISTS {{ {} }}".format, plain, plain))


@settings(max_examples=60, deadline=None, derandomize=True)
@given(simple.map(apart))
def test_a_query_answers_as_rdflib_does_where_every_pair_is_stored(group: str) -> None:
    sparql = f"SELECT DISTINCT ?a ?b ?c {{ {group} }}"

    assert counted(select(WORLD, sparql)) == oracle(WORLD, sparql, RdflibStore)


# ---------------------------------------------------------------- only what is mentioned, only for that query


@pytest.fixture
def asked() -> Iterator[list[tuple[int, int]]]:
    """How many subjects and objects the reasoner was asked about, each time."""
    Lottery.asked.clear()
    yield Lottery.asked
    Lottery.asked.clear()


@pytest.mark.parametrize(
    "sparql",
    [
        "SELECT ?b { scene:part_0 sk:near ?b }",
        "SELECT ?b { scene:part_0 <https://w3id.org/skiros-py/core#near> ?b }",
        "SELECT ?b { scene:part_0 <https://w3id.org/skiros-py/core#n\\u0065ar> ?b }",
        "PREFIX other: <https://w3id.org/skiros-py/core#n> SELECT ?b { scene:part_0 other:ear ?b }",
        "SELECT ?b { ?b ^sk:near scene:part_0 }",
        "SELECT ?b { ?a sk:near ?b FILTER(?a = scene:part_0) }",
        "SELECT ?b { VALUES ?a { scene:part_0 } ?a sk:near ?b }",
        "SELECT ?b { BIND(scene:part_0 AS ?a) ?a sk:near ?b }",
    ],
)
def test_a_computed_pattern_with_a_bound_end_evaluates_only_that_end(sparql: str, asked: list[tuple[int, int]]) -> None:
    everything = WORLD.instances("sk:SpatialThing")

    found = {row["b"] for row in select(WORLD, sparql)}

    assert found == {b for b in everything if drawn("part_0", "sk:near", b)}
    assert asked == [(1, len(everything))]


def test_a_parameter_may_name_the_relation_and_its_ends(asked: list[tuple[int, int]]) -> None:
    ends = {"a": "part_0", "b": "part_3"}

    assert ask(WORLD, "ASK { $a $how $b }", how="sk:leftOf", **ends) == drawn("part_0", "sk:leftOf", "part_3")
    assert asked == [(1, 1)]


def test_constraints_around_a_computed_pattern_reduce_the_evaluated_candidates(asked: list[tuple[int, int]]) -> None:
    starters = WORLD.instances("kitting:Starter")

    select(WORLD, "SELECT * { ?a a kitting:Starter OPTIONAL { ?a sk:near ?b . ?b a kitting:Alternator } }")
    select(WORLD, "SELECT * { ?a a kitting:Starter FILTER NOT EXISTS { ?a sk:near scene:part_1 } }")

    assert asked == [(len(starters), len(WORLD.instances("kitting:Alternator"))), (len(starters), 1)]


def test_a_computed_relation_that_a_query_does_not_name_is_not_evaluated(asked: list[tuple[int, int]]) -> None:
    select(WORLD, "SELECT * { ?a ?p ?b }")
    select(WORLD, "SELECT * { ?a rdfs:label 'sk:near' } # sk:near")
    select(WORLD, "SELECT * { ?a sk:in/sk:on ?b }", entailed=True)

    assert asked == []


def test_computed_pairs_are_not_visible_to_later_queries() -> None:
    everything = "SELECT * { ?a ?p ?b }"
    before = counted(select(WORLD, everything))
    select(WORLD, "SELECT * { ?a sk:near ?b }")
    with pytest.raises(UsageError):
        select(WORLD, "SELECT * { ?a sk:near ?b FILTER(?) }")

    assert counted(select(WORLD, everything)) == before
    with WORLD.store.opened() as (store, _):
        assert store.quads(COMPUTED_GRAPH) == []


def test_computed_pairs_of_parallel_queries_are_isolated() -> None:
    wanted = {r: len(select(WORLD, f"SELECT * {{ ?a {r} ?b }}")) for r in RELATIONS}

    def count_both(relation: str) -> bool:
        other = next(r for r in RELATIONS if r != relation)
        stray = f"{{ ?a {relation} ?b }} UNION {{ ?a ?p ?b FILTER(STR(?p) = '{ONTOLOGY.names.iri(other)}') }}"
        return len(select(WORLD, f"SELECT * {{ {stray} }}")) == wanted[relation]

    with ThreadPoolExecutor(4) as threads:
        assert all(threads.map(count_both, RELATIONS * 20))


def test_a_move_shows_in_the_next_answer() -> None:
    world = a_world()
    query = "SELECT ?a { ?a sk:near scene:floor ; sk:in scene:pallet_b } ORDER BY ?a"
    select(world, query)
    with world.transaction("test", "moved") as tx:
        for part in world.instances("kitting:Part"):
            tx.place(part, "sk:in", "pallet_b")

    near = [part for part in world.instances("kitting:Part") if drawn(part, "sk:near", "floor")]
    assert [row["a"] for row in select(world, query)] == sorted(near)


def test_a_computed_super_relation_holds_where_a_sub_relation_holds() -> None:
    found = {row["b"] for row in select(WORLD, "SELECT ?b { scene:part_0 sk:computed ?b }")}

    everything = WORLD.instances("sk:SpatialThing")
    assert found == {b for b in everything if any(drawn("part_0", r, b) for r in RELATIONS)}


def test_a_query_can_combine_computed_relations_and_owl_entailments() -> None:
    found = select(WORLD, "SELECT ?a { ?a sk:near scene:part_0 ; sk:placement ?b ; a kitting:Part }", entailed=True)

    near = {part for part in WORLD.instances("kitting:Part") if drawn(part, "sk:near", "part_0")}
    assert {row["a"] for row in found} == near


def test_a_construct_query_can_use_a_computed_relation() -> None:
    made = construct(WORLD, "CONSTRUCT { ?a sk:near ?b } WHERE { ?a sk:near ?b . ?a a kitting:Starter }")

    pairs = {(a, b) for a in WORLD.instances("kitting:Starter") for b in WORLD.instances("sk:SpatialThing")}
    assert {(s, o) for s, _, o in made.statements} == {(a, b) for a, b in pairs if drawn(a, "sk:near", b)}
    assert "sk:near" in made.turtle


# ---------------------------------------------------------------- what cannot be worked out


def test_too_many_pairs_are_refused_before_they_are_looked_at(asked: list[tuple[int, int]]) -> None:
    world = a_world(parts=1001)

    with pytest.raises(UsageError, match=r"sk:near .* pairs of elements, and 1,000,000 are the most: bind an end"):
        select(world, "SELECT * { ?a sk:near ?b }")
    assert asked == []
    assert select(world, "SELECT * { scene:part_0 sk:near ?b } LIMIT 1") != []


def test_a_relation_that_no_reasoner_computes_is_named() -> None:
    with pytest.raises(UnknownName, match="computed relation 'sk:above'"):
        select(WORLD, "SELECT * { ?a sk:above ?b }")


# ---------------------------------------------------------------- functions


def test_a_reasoners_function_can_be_called_in_a_query() -> None:
    query = "SELECT ?n { BIND(sk:letters(scene:floor, scene:part_0) AS ?n) }"
    longest = "SELECT ?a { ?a a kitting:Pallet FILTER(sk:letters(?a, scene:floor) > 12.5) }"

    assert select(WORLD, query) == [{"n": 11.0}]
    assert {row["a"] for row in select(WORLD, longest)} == {"pallet_a", "pallet_b"}


@pytest.mark.parametrize(
    "call", ["sk:letters(scene:floor, scene:floor)", "sk:letters(1, 2)", "sk:letters(scene:floor)"]
)
def test_a_function_without_an_answer_leaves_its_variable_unbound(call: str) -> None:
    assert select(WORLD, f"SELECT ?n {{ BIND({call} AS ?n) }}") == [{"n": None}]


def test_an_unknown_function_is_named() -> None:
    with pytest.raises(UsageError, match="core#nothing"):
        select(WORLD, "SELECT ?n { BIND(sk:nothing(1) AS ?n) }")

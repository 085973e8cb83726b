"""Computed relations answer as if every pair of them were stored."""

from __future__ import annotations

import re
import zlib
from collections import Counter
from collections.abc import Callable
from itertools import count
from pathlib import Path
from typing import ClassVar

import pyoxigraph as ox
from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_py.world.element import Placement, Value
from skiros_py.world.ontology import Ontology
from skiros_py.world.queries import Table, select
from skiros_py.world.queries.answering import Question, mentioned_relations, typed
from skiros_py.world.reasoners.reasoner import Answer, Reasoner
from skiros_py.world.reasoners.registry import Reasoners
from skiros_py.world.store import Projection, QuadStore
from skiros_py.world.store.oxigraph import OxigraphStore
from skiros_py.world.store.rdflib_memory import RdflibStore
from skiros_py.world.store.store import COMPUTED_GRAPH, Rows
from skiros_py.world.view import WorldView
from skiros_py.world.world import World

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


def oracle(world: World, sparql: str, make: Callable[[], QuadStore] = OxigraphStore) -> object:
    """The answer where every pair of the relations that the query mentions is stored."""
    store = Projection(*world.state(), make).store
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


@settings(max_examples=150, deadline=None)
@given(groups.map(apart))
def test_a_query_answers_as_if_every_pair_were_stored(group: str) -> None:
    sparql = f"SELECT * {{ {group} }}"

    assert counted(select(WORLD, sparql)) == oracle(WORLD, sparql)


plain = blocks.filter(lambda block: "!" not in block)  # it cannot read inverses there
simple = st.one_of(plain, st.builds("{} OPTIONAL {{ {} }}".format, plain, plain))
simple = st.one_of(simple, st.builds("{{ {} }} UNION {{ {} }}".format, plain, plain))
simple = st.one_of(simple, st.builds("{} MINUS {{ {} }}".format, plain, plain))
simple = st.one_of(simple, st.builds("{} FILTER NOT EXISTS {{ {} }}".format, plain, plain))


@settings(max_examples=60, deadline=None)
@given(simple.map(apart))
def test_a_query_answers_as_rdflib_does_where_every_pair_is_stored(group: str) -> None:
    sparql = f"SELECT DISTINCT ?a ?b ?c {{ {group} }}"

    assert counted(select(WORLD, sparql)) == oracle(WORLD, sparql, RdflibStore)

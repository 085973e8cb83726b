"""The triples follow the world, change by change, and hold what a new projection of it would."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Sequence
from pathlib import Path

import pyoxigraph as ox
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_py.errors import MissingExtra, WorldError
from skiros_py.geometry import Pose
from skiros_py.world.change import Change
from skiros_py.world.element import Placement
from skiros_py.world.index import Index
from skiros_py.world.names import LEARNED_GRAPH, SCENE_GRAPH
from skiros_py.world.ontology import Ontology
from skiros_py.world.past import MemoryLog, Past
from skiros_py.world.scene.files import load_scene
from skiros_py.world.store import projection
from skiros_py.world.store.projection import Projection, TripleStore, entailed_store
from skiros_py.world.store.store import INFERRED_GRAPH, QuadStore
from skiros_py.world.world import World

from ..rdflib_store import RdflibStore  # noqa: TID252  the tests are no installed package

ROOT = Path(__file__).parents[4]
ONTOLOGY = Ontology.load([ROOT / "ontologies"])
SCENE = ox.NamedNode(SCENE_GRAPH)
LEARNED = ox.NamedNode(LEARNED_GRAPH)


@pytest.fixture(params=[QuadStore, RdflibStore])
def make(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> type:
    """The store that projections are written to: the one that serves, or the naive one."""
    monkeypatch.setattr(projection, "QuadStore", request.param)
    store: type = request.param
    return store


def a_world() -> World:
    return load_scene(ONTOLOGY, ROOT / "scenes" / "kitting.ttl")


def node(name: str) -> ox.NamedNode:
    return ox.NamedNode(ONTOLOGY.names.iri(name))


def held(triples: TripleStore) -> set[ox.Quad]:
    with triples.opened() as (store, _):
        return set(store.quads())


def said_of(triples: TripleStore, subject: str) -> dict[str, list[str]]:
    """What the store says of a thing, by predicate."""
    found: dict[str, list[str]] = {}
    for quad in held(triples):
        if quad.subject == node(subject):
            found.setdefault(ONTOLOGY.names.name(quad.predicate.value), []).append(quad.object.value)  # type: ignore[union-attr]
    return found


def fresh(world: World) -> set[ox.Quad]:
    return set(Projection(world.snapshot()).store.quads())


# ---------------------------------------------------------------- graphs


@pytest.mark.usefixtures("make")
def test_there_is_a_graph_for_each_ontology_file_and_for_the_scene() -> None:
    store = Projection(a_world().snapshot()).store

    assert set(store.graphs()) == {source.iri for source in ONTOLOGY.sources} | {SCENE_GRAPH}


def test_a_learned_concept_is_in_the_learned_graph_until_it_is_removed() -> None:
    world = a_world()
    triples = TripleStore(world)
    before = held(triples)
    with world.transaction("teacher", "this is a mug") as tx:
        mug = tx.add("kitting:Starter", "mug", properties={"sk:mass": 0.75}, learned=True)
    with triples.opened() as (store, _):
        learned = store.quads(LEARNED)

    assert {(quad.subject, quad.object.value) for quad in learned} >= {(node(mug), "mug"), (node(mug), "0.75")}
    assert {quad.subject for quad in learned} == {node(mug)}
    with world.transaction("teacher", "no more") as tx:
        tx.remove(mug)
    assert held(triples) == before


# ---------------------------------------------------------------- change by change


@pytest.mark.usefixtures("make")
def test_the_store_follows_a_world_change_by_change() -> None:
    world = a_world()
    triples = TripleStore(world)
    with world.transaction("test", "a new part") as tx:
        tx.add("kitting:Starter", "late", id="late_1", placement=Placement("sk:in", "pallet_a"))
    assert said_of(triples, "late_1")["sk:in"] == [node("pallet_a").value]

    with world.transaction("test", "picked") as tx:
        tx.place("late_1", "sk:heldBy", "gripper_1")
        tx.set("late_1", "sk:pose", Pose())
    said = said_of(triples, "late_1")
    assert ("sk:in" in said, said["sk:heldBy"], len(said["sk:pose"])) == (False, [node("gripper_1").value], 1)

    with world.transaction("test", "unknown again") as tx:
        tx.set("late_1", "sk:pose", None)
    assert "sk:pose" not in said_of(triples, "late_1")

    with world.transaction("test", "put down") as tx:
        tx.place("late_1", "sk:in", "pallet_b")
    with world.transaction("test", "gone") as tx:
        tx.remove("late_1")
    assert said_of(triples, "late_1") == {}
    assert triples.version == world.version


def test_the_goals_are_followed() -> None:
    world = a_world()
    triples = TripleStore(world)
    for goals in (["ObjectAtLocation(Starter, kit_1_d)"], [], list(world.goals)):
        with world.transaction("test", "other goals") as tx:
            tx.set_goals(goals)

        assert sorted(said_of(triples, "this").get("sk:goal", [])) == sorted(goals)
        assert "rdf:type" in said_of(triples, "this")


def test_a_refused_transaction_leaves_nothing_in_the_store() -> None:
    world = a_world()
    triples = TripleStore(world)
    before = held(triples)

    with contextlib.suppress(WorldError), world.transaction("test", "impossible") as tx:
        tx.set("starter_1", "sk:missing", True)
        tx.place("starter_1", "sk:in", "nowhere")
    assert world.version == triples.version

    assert held(triples) == before


def test_removing_a_thing_takes_all_triples_with_it_in_and_out() -> None:
    world = a_world()
    triples = TripleStore(world)
    with world.transaction("test", "no kit") as tx:
        tx.remove("kit_1")

    gone = {node(name) for name in ("kit_1", "kit_1_a", "kit_1_b", "kit_1_c", "kit_1_d")}

    assert not [quad for quad in held(triples) if quad.subject in gone or quad.object in gone]
    assert held(triples) == fresh(world)


names = st.sampled_from(["starter_1", "kit_1", "kit_1_a", "pallet_a", "robot_1", "gripper_1", "kit_table", "floor"])
writes = st.one_of(
    st.tuples(st.just("place"), names, st.sampled_from(["sk:in", "sk:on", "sk:heldBy"]), names),
    st.tuples(st.just("set"), names, st.just("sk:pose"), st.sampled_from([Pose(), Pose.of(1, 2, 3, yaw=1), None])),
    st.tuples(st.just("set"), names, st.just("sk:missing"), st.sampled_from([True, None])),
    st.tuples(st.just("unrelate"), names, st.just("sk:hasA"), names),
    st.tuples(st.just("set_goals"), st.sampled_from([["InKit(Starter, kit_1)"], []])),
    st.tuples(st.just("remove"), names),
)


@settings(max_examples=25, deadline=None)
@given(st.lists(st.lists(writes, min_size=1, max_size=3), max_size=6))
def test_after_random_transactions_the_store_equals_a_freshly_built_one(
    transactions: list[list[tuple[str, ...]]],
) -> None:
    world = a_world()
    triples = TripleStore(world)
    for transaction in transactions:
        with contextlib.suppress(WorldError), world.transaction("test", "random") as tx:
            for what, *arguments in transaction:
                getattr(tx, what)(*arguments)

        assert held(triples) == fresh(world)


# ---------------------------------------------------------------- a log that forgets


class ForgetfulLog(MemoryLog):
    """Remembers nothing older than a version, as a compacted journal."""

    forgotten = 0

    def since(self, version: int) -> Sequence[Change]:
        if version < self.forgotten:
            raise WorldError("forgotten")
        return super().since(version)


def test_a_store_older_than_the_kept_changes_is_rebuilt() -> None:
    log = ForgetfulLog()
    world = World(ONTOLOGY, past=Past(Index(ONTOLOGY), log=log))
    triples = TripleStore(world)
    for number in range(3):
        with world.transaction("test", "one more") as tx:
            tx.add("sk:Floor", f"floor {number}", id=f"floor_{number}")
    log.forgotten = 2

    assert said_of(triples, "floor_2")["rdfs:label"] == ["floor 2"]
    assert (held(triples), triples.version) == (fresh(world), world.version)

    with world.transaction("test", "and on it goes") as tx:
        tx.remove("floor_0")
    with triples.opened() as (store, state):
        assert set(store.quads()) == fresh(world)
        assert "floor_0" not in state.ids()


# ---------------------------------------------------------------- what OWL entails

FAMILY = """
@prefix f: <http://example.org/family#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
f: a owl:Ontology .
f:Machine a owl:Class . f:Mill a owl:Class ; rdfs:subClassOf f:Machine .
f:Fraese a owl:Class ; owl:equivalentClass f:Mill .
f:feeds a owl:ObjectProperty ; owl:inverseOf f:fedBy . f:fedBy a owl:ObjectProperty .
f:beside a owl:ObjectProperty , owl:SymmetricProperty .
f:after a owl:ObjectProperty , owl:TransitiveProperty .
f:touches a owl:ObjectProperty ; rdfs:subPropertyOf f:beside .
f:m1 a f:Mill ; f:feeds f:m2 ; f:touches f:m2 ; f:after f:m2 .
f:m2 a f:Fraese ; f:after f:m3 .
f:m3 a f:Machine .
"""


def entailments(make: type) -> QuadStore:
    stated: QuadStore = make()
    parsed = ox.parse(FAMILY.encode(), format=ox.RdfFormat.TURTLE)
    stated.bulk_load(ox.Quad(q.subject, q.predicate, q.object, SCENE) for q in parsed)
    return entailed_store(stated)


@pytest.mark.parametrize(
    ("subject", "predicate", "object_"),
    [
        ("f:m2", "f:fedBy", "f:m1"),
        ("f:m2", "f:beside", "f:m1"),
        ("f:m1", "f:beside", "f:m2"),
        ("f:m1", "f:after", "f:m3"),
        ("f:m1", "a", "f:Machine"),
        ("f:m2", "a", "f:Mill"),
        ("f:m2", "a", "f:Machine"),
    ],
    ids=["inverse", "symmetric", "sub_relation", "transitive", "subclass", "equivalent", "equivalent_subclass"],
)
def test_owl_entailments_are_in_the_inferred_graph(make: type, subject: str, predicate: str, object_: str) -> None:
    prefix = "PREFIX f: <http://example.org/family#>"
    triple = f"{subject} {predicate} {object_}"
    store = entailments(make)

    assert store.query(f"{prefix} ASK {{ GRAPH <{INFERRED_GRAPH.value}> {{ {triple} }} }}") is True


def test_entailment_without_its_library_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "reasonable", None)

    with pytest.raises(MissingExtra, match="entailment needs the extra 'ontology'"):
        entailments(QuadStore)


def test_invalid_entailments_are_not_inferred() -> None:
    store = entailments(QuadStore)

    for triple in ("f:m3 f:after f:m1", "f:m3 a f:Mill", "f:m2 f:feeds f:m1", "f:m2 f:touches f:m1"):
        assert store.query(f"PREFIX f: <http://example.org/family#> ASK {{ {triple} }}") is False


def test_stated_triples_are_not_repeated_as_inferred() -> None:
    store = entailments(QuadStore)

    said = [(quad.subject, quad.predicate, quad.object) for quad in store.quads()]

    assert len(said) == len(set(said))


def test_the_store_with_entailments_is_separate_and_is_rebuilt_for_each_version() -> None:
    world = a_world()
    triples = TripleStore(world)
    asked = f"ASK {{ <{node('starter_1').value}> <{node('sk:placement').value}> <{node('pallet_b').value}> }}"
    with triples.opened(entailed=True) as (first, _):
        assert first.query(asked) is False
    with triples.opened(entailed=True) as (again, _):
        assert again is first
    with world.transaction("test", "carried over") as tx:
        tx.place("starter_1", "sk:in", "pallet_b")

    with triples.opened(entailed=True) as (second, _):
        assert second.query(asked) is True
    with triples.opened() as (stated, _):
        assert stated.query(asked) is False
        assert INFERRED_GRAPH.value not in stated.graphs()

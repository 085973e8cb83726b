"""The index, the store and the file are projections of the same changes: random writes keep them equal."""

from __future__ import annotations

import contextlib
from pathlib import Path

import pyoxigraph as ox
import rdflib
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from skiros_py.errors import WorldError
from skiros_py.geometry import Pose
from skiros_py.world.abstract import abstract_individuals
from skiros_py.world.element import Placement, is_abstract
from skiros_py.world.names import SCENE_GRAPH
from skiros_py.world.ontology import Ontology
from skiros_py.world.overlay import Overlay
from skiros_py.world.reasoners.registry import NO_REASONERS
from skiros_py.world.scene.files import load_scene
from skiros_py.world.scene.writer import scene_turtle
from skiros_py.world.terms import Family
from skiros_py.world.transaction import Transaction
from skiros_py.world.world import World

ROOT = Path(__file__).parents[3]
ONTOLOGY = Ontology.load([ROOT / "ontologies"])
NAMES = ["starter_1", "alternator_1", "relay_box_1", "kit_1", "kit_1_a", "kit_1_b", "pallet_a", "rack_1", "robot_1"]
NAMES += ["gripper_1", "deck_1", "floor", "kit_table", "starter_2", "kit_2"]

names = st.sampled_from(NAMES)
writes = st.one_of(
    st.tuples(st.just("place"), names, st.sampled_from(["sk:in", "sk:on", "sk:at", "sk:heldBy"]), names),
    st.tuples(st.just("relate"), names, st.sampled_from(["sk:hasA", "sk:poseFrame", "sk:mountedOn"]), names),
    st.tuples(st.just("unrelate"), names, st.sampled_from(["sk:hasA", "sk:poseFrame"]), names),
    st.tuples(st.just("set"), names, st.just("sk:missing"), st.sampled_from([True, False, None])),
    st.tuples(st.just("set"), names, st.just("sk:pose"), st.sampled_from([Pose(), Pose.of(1, 2, 3, yaw=1), None])),
    st.tuples(st.just("remove"), names),
    st.tuples(
        st.just("add"),
        st.sampled_from(["kitting:Starter", "kitting:Kit"]),
        st.none(),
        st.none(),
        st.none(),
        st.builds(Placement, st.sampled_from(["sk:in", "sk:on"]), names),
    ),
)


def do(tx: Transaction, write: tuple[object, ...]) -> None:
    getattr(tx, str(write[0]))(*write[1:])


def naive(world: World) -> rdflib.Graph:
    return rdflib.Graph().parse(data=scene_turtle(world.snapshot()), format="turtle")


def statements(graph: rdflib.Graph) -> set[tuple[str, str, str]]:
    name = ONTOLOGY.names.name
    found = {(name(str(s)), name(str(p)), name(str(o))) for s, p, o in graph if not isinstance(o, rdflib.Literal)}
    return {statement for statement in found if statement[1] in ONTOLOGY.relations}


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.lists(st.lists(writes, min_size=1, max_size=3), max_size=8))
def test_random_transactions_keep_everything_in_one_place_and_all_projections_equal(
    transactions: list[list[tuple[object, ...]]],
) -> None:
    world = load_scene(ONTOLOGY, ROOT / "scenes" / "kitting.ttl")
    for transaction in transactions:
        with contextlib.suppress(WorldError), world.transaction("test", "random") as tx:
            for write in transaction:
                do(tx, write)

    graph = naive(world)
    said = statements(graph)
    every_element_is_in_one_place(world, said)
    the_index_answers_as_the_graph(world, graph, said)
    the_store_holds_the_same_triples(world, graph)
    replaying_the_changes_gives_the_same_index(world)


def values(graph: rdflib.Graph) -> set[tuple[object, ...]]:
    """Statements by value: 60 and 60.0 are one number."""
    return {(s, p, o.toPython() if isinstance(o, rdflib.Literal) else o) for s, p, o in graph}


def every_element_is_in_one_place(world: World, said: set[tuple[str, str, str]]) -> None:
    for element in world.instances("sk:Element"):
        ties = [r for s, r, _ in said if s == element and ONTOLOGY.is_placement(r)]
        ties += [r for _, r, o in said if o == element and r == "sk:hasA"]
        root = ONTOLOGY.is_a(world.element(element).type, "sk:Root")
        spatial = ONTOLOGY.is_a(world.element(element).type, "sk:SpatialThing")
        assert len(ties) == 1 or (not ties and (root or not spatial))


def the_index_answers_as_the_graph(world: World, graph: rdflib.Graph, said: set[tuple[str, str, str]]) -> None:
    elements = world.instances("sk:Element")
    assert {(s, r, o) for s, r, o in world.snapshot().statements() if not is_abstract(s)} == said
    for relation in (r for r in ONTOLOGY.relations if ONTOLOGY.family(r) is not Family.COMPUTED):
        below = ONTOLOGY.sub_relations(relation)
        for element in elements:
            objects = {o for s, r, o in said if s == element and r in below}
            subjects = {s for s, r, o in said if o == element and r in below}
            assert world.objects(element, relation) == tuple(sorted(objects))
            assert world.subjects(relation, element) == tuple(sorted(subjects))
    for class_ in ONTOLOGY.subclasses("sk:Element"):
        iris = [rdflib.URIRef(ONTOLOGY.names.iri(below)) for below in ONTOLOGY.subclasses(class_)]
        found = {ONTOLOGY.names.name(str(s)) for iri in iris for s in graph.subjects(rdflib.RDF.type, iri)}
        assert world.instances(class_) == tuple(sorted(found))


def the_store_holds_the_same_triples(world: World, graph: rdflib.Graph) -> None:
    with world.store.opened() as (store, _):
        quads = store.quads(ox.NamedNode(SCENE_GRAPH))
    held = rdflib.Graph()
    for quad in quads:
        held.parse(data=f"{quad.triple} .", format="nt")
    graph.remove((None, rdflib.OWL.imports, None))
    graph.remove((None, rdflib.RDF.type, rdflib.OWL.Ontology))
    assert values(held) == values(graph)


def replaying_the_changes_gives_the_same_index(world: World) -> None:
    replayed = abstract_individuals(ONTOLOGY, NO_REASONERS).copy()
    for change in world.changes:
        for edit in change.edits:
            replayed.apply(edit)
    assert list(replayed.statements()) == list(world.snapshot().statements())
    for element in world.instances("sk:Element"):
        assert replayed.element(element) == world.element(element)
        assert replayed.placement(element) == world.placement(element)


moves = st.tuples(st.sampled_from(["starter_1", "robot_1", "kit_1"]), st.sampled_from(["sk:in", "sk:on"]), names)


@settings(max_examples=60, deadline=None)
@given(st.lists(moves, max_size=10))
def test_an_overlay_answers_like_a_world_with_the_same_changes(moved: list[tuple[str, str, str]]) -> None:
    world = load_scene(ONTOLOGY, ROOT / "scenes" / "kitting.ttl")
    overlay = Overlay(world.snapshot())
    for element, relation, place in moved:
        with contextlib.suppress(WorldError), world.transaction("test", "random") as tx:
            tx.place(element, relation, place)
        if world.placement(element) == Placement(relation, place):
            overlay.place(element, relation, place)

    for element in world.instances("sk:Element"):
        assert overlay.placement(element) == world.placement(element)
        for relation in ("sk:placement", "sk:in", "sk:on", "sk:hasA"):
            assert overlay.objects(element, relation) == world.objects(element, relation)
            assert overlay.subjects(relation, element) == world.subjects(relation, element)

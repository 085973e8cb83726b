from __future__ import annotations

import pytest

from skiros_py.errors import UsageError
from skiros_py.geometry import Pose
from skiros_py.world.queries.answering import Text, ask, select
from skiros_py.world.world import World

PARTS_IN = "SELECT ?part ?mass { ?part sk:in $place ; a ?class . ?class rdfs:subClassOf* kitting:Part ; sk:mass ?mass }"


def test_one_query_can_combine_ontology_and_scene(world: World) -> None:
    rows = select(world, PARTS_IN + " ORDER BY ?part", place="pallet_a")

    assert rows == [
        {"part": "alternator_1", "mass": 0.9},
        {"part": "relay_box_1", "mass": 0.25},
        {"part": "starter_1", "mass": 0.8},
    ]


def test_a_query_sees_every_transaction(world: World) -> None:
    select(world, "SELECT * { ?s sk:heldBy ?o }")
    with world.transaction("pick", "fingers closed") as tx:
        tx.place("starter_1", "sk:heldBy", "gripper_1")
        tx.set("starter_1", "sk:pose", Pose())

    rows = select(world, "SELECT ?s ?pose { ?s sk:heldBy $by ; sk:pose ?pose }", by="gripper_1")

    assert rows == [{"s": "starter_1", "pose": Pose()}]
    assert not ask(world, "ASK { scene:starter_1 sk:in ?anywhere }")
    assert world.store.version == world.version


def test_the_goals_can_be_asked_for(world: World) -> None:
    rows = select(world, "SELECT ?goal { ?scene a sk:Scene ; sk:goal ?goal } ORDER BY ?goal")

    assert tuple(row["goal"] for row in rows) == world.goals


def test_each_statement_is_returned_once(world: World) -> None:
    rows = select(world, "SELECT ?robot { ?robot a sk:Robot }")

    assert rows == [{"robot": "robot_1"}]


def test_bound_values_cannot_inject_query_text(world: World) -> None:
    nasty = '" } DROP ALL # \\'

    assert not ask(world, "ASK { ?s rdfs:label $label }", label=Text(nasty))
    assert ask(world, "ASK { ?s rdfs:label $label }", label=Text("rack"))
    assert ask(world, "ASK { scene:camera_1 sk:width $w }", w=320)
    with pytest.raises(UsageError, match="is no name"):
        ask(world, "ASK { ?s sk:in $place }", place="pallet_a> ?o . <x")


@pytest.mark.parametrize(
    ("query", "says"),
    [
        ("SELECT * { ?s ?p }", "does not parse"),
        ("ASK { ?s ?p ?o }", "is no SELECT"),
        ("SELECT * { SERVICE <http://example.org/sparql> { ?s ?p ?o } }", "asks another server"),
        ("SELECT * { ?s sk:in $place }", "nothing is bound to \\$place"),
    ],
)
def test_a_query_that_cannot_be_run_is_refused(world: World, query: str, says: str) -> None:
    with pytest.raises(UsageError, match=says):
        select(world, query)


def test_keywords_in_strings_are_not_keywords(world: World) -> None:
    assert select(world, "SELECT ?s { ?s rdfs:label 'SERVICE $x' } # SERVICE $y") == []

from __future__ import annotations

import json
import math
from collections.abc import Callable

import pytest

from skiros_py.errors import UnknownName, WorldError
from skiros_py.geometry import Pose
from skiros_py.world.change import Change, ElementEdit, PlacementEdit, PropertyEdit
from skiros_py.world.element import Placement
from skiros_py.world.ontology import Ontology
from skiros_py.world.transaction import Transaction
from skiros_py.world.world import World


def refusal(world: World, write: Callable[[Transaction], object]) -> str:
    version = world.version
    with pytest.raises(WorldError) as caught, world.transaction("test", "try it") as tx:
        write(tx)
    assert world.version == version
    return str(caught.value)


def test_an_element_has_one_placement_across_all_placement_relations(world: World) -> None:
    with world.transaction("pick", "fingers closed") as tx:
        tx.place("starter_1", "sk:heldBy", "gripper_1")

    assert world.placement("starter_1") == Placement("sk:heldBy", "gripper_1")
    assert world.objects("starter_1", "sk:placement") == ("gripper_1",)
    assert "starter_1" not in world.subjects("sk:in", "pallet_a")


def test_changes_are_visible_only_after_the_transaction(world: World) -> None:
    with world.transaction("pick", "fingers closed") as tx:
        tx.place("starter_1", "sk:heldBy", "gripper_1")

        assert world.related("starter_1", "sk:in", "pallet_a")
        assert tx.view.related("starter_1", "sk:heldBy", "gripper_1")


def test_an_exception_in_the_transaction_discards_its_changes(world: World) -> None:
    before = world.version

    def write_and_fail() -> None:
        with world.transaction("pick", "a fault") as tx:
            tx.place("starter_1", "sk:heldBy", "gripper_1")
            tx.add("kitting:Starter", placement=Placement("sk:in", "pallet_a"))
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        write_and_fail()

    assert world.version == before
    assert world.placement("starter_1") == Placement("sk:in", "pallet_a")
    assert world.instances("kitting:Starter") == ("starter_1",)


def test_a_snapshot_never_changes(world: World) -> None:
    before = world.snapshot()

    with world.transaction("pick", "fingers closed") as tx:
        tx.place("starter_1", "sk:heldBy", "gripper_1")
        tx.set("starter_1", "sk:missing", True)

    assert before.placement("starter_1") == Placement("sk:in", "pallet_a")
    assert before.subjects("sk:in", "pallet_a") == ("alternator_1", "relay_box_1", "starter_1")
    assert before.value("starter_1", "sk:missing") is None


def test_ids_are_counted_per_class_and_never_used_again(world: World) -> None:
    place = Placement("sk:in", "pallet_a")
    with world.transaction("delivery", "a new part") as tx:
        third = tx.add("kitting:RelayBox", placement=place)
    with world.transaction("delivery", "taken back") as tx:
        tx.remove(third)

    with world.transaction("delivery", "another") as tx:
        fourth = tx.add("kitting:RelayBox", placement=place)

    assert (third, fourth) == ("relay_box_3", "relay_box_4")
    assert "never used again" in refusal(world, lambda tx: tx.add("kitting:RelayBox", id=third, placement=place))


def test_a_change_records_author_reason_time_and_previous_values(world: World) -> None:
    world.clock = lambda: 12.5

    with world.transaction("look", "seen on the pallet") as tx:
        tx.set("starter_1", "sk:pose", Pose.of(1, 2, 3))
        tx.place("starter_1", "sk:on", "floor")
        tx.set("starter_1", "rdfs:label", "the starter")

    assert world.changes[-1] == Change(
        2,
        "look",
        "seen on the pallet",
        12.5,
        (
            PropertyEdit("starter_1", "rdfs:label", "starter", "the starter"),
            PropertyEdit("starter_1", "sk:pose", None, Pose.of(1, 2, 3)),
            PlacementEdit("starter_1", Placement("sk:in", "pallet_a"), Placement("sk:on", "floor")),
        ),
    )
    assert json.loads(json.dumps(world.changes[-1].as_json()))["edits"][1]["new"]["position"] == [1, 2, 3]


def test_only_the_net_effect_is_a_change(world: World) -> None:
    before = world.version

    with world.transaction("test", "there and back") as tx:
        tx.place("starter_1", "sk:on", "floor")
        tx.remove(tx.add("kitting:Starter", placement=Placement("sk:on", "floor")))
        tx.place("starter_1", "sk:in", "pallet_a")

    assert world.version == before


def test_changes_written_by_a_subscriber_are_delivered_in_order(world: World) -> None:
    seen: list[int] = []

    def react(change: Change) -> None:
        if change.author == "look":
            with world.transaction("reasoner", "follows from it") as tx:
                tx.set("starter_1", "sk:missing", False)

    def fail(_: Change) -> None:
        raise RuntimeError

    world.subscribe(react)
    world.subscribe(fail)
    stop = world.subscribe(lambda change: seen.append(change.number))
    with world.transaction("look", "not there") as tx:
        tx.set("starter_1", "sk:missing", True)
    stop()
    with world.transaction("look", "there") as tx:
        tx.set("starter_1", "sk:missing", True)

    assert seen == [2, 3]
    assert world.version == 5


def test_removing_an_element_removes_its_parts_and_moves_their_content_to_its_place(world: World) -> None:
    with world.transaction("put", "it lies there") as tx:
        tx.place("starter_1", "sk:in", "kit_1_a")

    with world.transaction("operator", "kit is done") as tx:
        tx.remove("kit_1")

    assert not world.has("kit_1")
    assert not world.has("kit_1_a")
    assert world.placement("starter_1") == Placement("sk:on", "kit_table")
    assert isinstance(world.changes[-1].edits[-1], ElementEdit)


def test_the_part_held_by_a_removed_robot_is_at_the_robots_place(world: World) -> None:
    with world.transaction("pick", "fingers closed") as tx:
        tx.place("starter_1", "sk:heldBy", "gripper_1")
        tx.place("robot_1", "sk:at", "pallet_a")

    with world.transaction("operator", "driven away") as tx:
        tx.remove("robot_1")

    assert world.instances("sk:Device") == ()
    assert world.placement("starter_1") == Placement("sk:in", "pallet_a")


def test_a_pose_whose_frame_is_removed_is_no_longer_known(world: World) -> None:
    with world.transaction("look", "seen") as tx:
        tx.set("starter_1", "sk:pose", Pose.of(0.1, 0, 0.5))
        tx.relate("starter_1", "sk:poseFrame", "rack_1")

    with world.transaction("operator", "cleared") as tx:
        tx.remove("rack_1")

    assert world.value("starter_1", "sk:pose") is None
    assert world.objects("starter_1", "sk:poseFrame") == ()


def test_a_functional_relation_replaces_its_object(world: World) -> None:
    with world.transaction("operator", "starts elsewhere") as tx:
        tx.relate("robot_1", "sk:startLocation", "pallet_a")

    assert world.objects("robot_1", "sk:startLocation") == ("pallet_a",)


def test_a_refusal_lists_all_faults_with_the_allowed_alternatives(world: World) -> None:
    def write(tx: Transaction) -> None:
        tx.place("starter_1", "sk:heldBy", "kit_1")
        tx.add("kitting:Startr")
        tx.set("starter_1", "sk:mas", 1.0)

    text = refusal(world, write)

    assert "transaction of test (try it) refused" in text
    assert "object must be a sk:Gripper, and kit_1 is a kitting:Kit" in text
    assert "there may be: sk:hasA, sk:in, sk:mayBeIn, sk:on" in text
    assert "Did you mean 'kitting:Starter'" in text
    assert "Did you mean 'sk:mass'" in text


@pytest.mark.parametrize(
    ("write", "says"),
    [
        (lambda tx: tx.place("robot_1", "sk:on", "deck_1"), "robot_1 is inside itself: robot_1 -> deck_1 -> robot_1"),
        (lambda tx: tx.place("starter_2", "sk:in", "kit_1_a"), "unknown element 'starter_2'. Did you mean 'starter_1'"),
        (lambda tx: tx.place("starter_1", "sk:in", "kit_9"), "unknown element 'kit_9'"),
        (lambda tx: tx.place("starter_1", "sk:hasA", "kit_1"), "does not place starter_1: use one of sk:at, sk:heldBy"),
        (lambda tx: tx.place("starter_1", "sk:placement", "kit_1"), "use one of sk:at, sk:heldBy"),
        (lambda tx: tx.add("kitting:Starter"), "starter_2 (kitting:Starter) is nowhere"),
        (lambda tx: tx.add("sk:Scene"), "is no sk:Element"),
        (lambda tx: tx.add("owl:Class"), "never changed at run time"),
        (lambda tx: tx.set("kitting:Starter", "sk:mass", 1.0), "never changed at run time"),
        (lambda tx: tx.relate("starter_1", "rdfs:subClassOf", "kit_1"), "never changed at run time"),
        (lambda tx: tx.relate("starter_1", "sk:fitsIn", "kit_1_a"), "computed by a reasoner and never stored"),
        (lambda tx: tx.relate("starter_1", "sk:structure", "kit_1_a"), "whole family: use one of sk:hasA"),
        (lambda tx: tx.relate("pallet_a", "sk:hasA", "kit_1_a"), "a piece has one owner"),
        (lambda tx: tx.place("kit_1_a", "sk:on", "floor"), "it can have no placement of its own"),
        (lambda tx: tx.unrelate("kit_1", "sk:hasA", "kit_1_a"), "kit_1_a (kitting:Compartment) is nowhere"),
        (lambda tx: tx.unrelate("starter_1", "sk:in", "pallet_a"), "place it elsewhere instead"),
        (lambda tx: tx.unrelate("arm_1", "sk:hasA", "deck_1"), "is not stated"),
        (lambda tx: tx.remove("floor"), "kit_table would be nowhere"),
        (lambda tx: tx.set("starter_1", "sk:pose", Pose((math.nan, 0.0, 0.0))), "needs a pose"),
        (lambda tx: tx.set("starter_1", "sk:pose", "0 0 0 0 0 0"), "needs a pose"),
        (lambda tx: tx.set("starter_1", "sk:mass", math.inf), "needs a finite number"),
        (lambda tx: tx.set("starter_1", "sk:solid", '[{"kind": "ball"}]'), "needs a JSON text"),
        (lambda tx: tx.set("rack_1", "sk:maxGap", 0.1), "belongs to a sk:Gripper, and rack_1 is a kitting:Rack"),
        (lambda tx: tx.set("rack_1", "rdfs:label", None), "needs a text"),
        (lambda tx: tx.relate("kit_1", "sk:poseFrame", "kit_1_a"), "has its own frame as sk:poseFrame"),
        (lambda tx: tx.add("kitting:Kit", id="kit-2", placement=Placement("sk:on", "floor")), "'kit-2' is no id"),
        (lambda tx: tx.add("kitting:Kit", id="this", placement=Placement("sk:on", "floor")), "the scene itself"),
    ],
)
def test_a_change_that_violates_the_ontology_is_refused(
    world: World, write: Callable[[Transaction], object], says: str
) -> None:
    assert says in refusal(world, write)


def test_a_thread_cannot_open_a_transaction_within_another(world: World) -> None:
    with (
        world.transaction("outer", "first"),
        pytest.raises(WorldError, match="outer has a transaction open"),
        world.transaction("inner", "second"),
    ):
        pass


def test_writing_to_a_finished_transaction_is_refused(world: World) -> None:
    with world.transaction("test", "nothing") as tx:
        pass

    with pytest.raises(WorldError, match="is over"):
        tx.place("starter_1", "sk:on", "floor")


def test_an_unknown_id_is_refused_with_the_nearest_known_id(world: World) -> None:
    with pytest.raises(UnknownName, match="Did you mean 'starter_1'"):
        world.element("starter1")


def test_an_element_without_a_value_has_the_value_of_its_class(world: World) -> None:
    assert world.value("starter_1", "sk:mass") == 0.8

    with world.transaction("scale", "weighed") as tx:
        tx.set("starter_1", "sk:mass", 0.75)

    assert world.value("starter_1", "sk:mass") == 0.75


def test_a_new_world_is_empty(ontology: Ontology) -> None:
    world = World(ontology)

    assert (world.version, world.instances("sk:Element"), world.goals) == (0, (), ())

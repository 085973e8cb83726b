"""Drafts are added all at once; copies, instances and what is learned are drafts of what there is."""

from __future__ import annotations

import pytest

from skiros_py.errors import UnknownName, UsageError, WorldError
from skiros_py.geometry import Pose
from skiros_py.world.branches import Draft, add_draft, draft_of, instantiate, learn
from skiros_py.world.element import Placement
from skiros_py.world.world import World


def test_a_draft_comes_with_all_that_is_reached_from_it(world: World) -> None:
    kit = Draft("kitting:Kit", "second kit", relations=[("sk:on", "kit_table")])
    left = kit.relate("sk:hasA", Draft("kitting:Compartment", "left", {"sk:pose": Pose.of(0.1, 0, 0)}))
    left.relate("sk:poseFrame", kit)
    starter = left.relate("^sk:in", Draft("kitting:Starter", id="my_starter"))

    with world.transaction("operator", "a second kit") as tx:
        ids = add_draft(tx, kit)

    assert list(ids) == [kit, left, starter]
    assert ids == {kit: "kit_2", left: "compartment_1", starter: "my_starter"}
    assert world.element("kit_2").label == "second kit"
    assert world.placement("kit_2") == Placement("sk:on", "kit_table")
    assert world.objects("kit_2", "sk:hasA") == ("compartment_1",)
    assert world.objects("compartment_1", "sk:poseFrame") == ("kit_2",)
    assert world.value("compartment_1", "sk:pose") == Pose.of(0.1, 0, 0)
    assert world.placement("my_starter") == Placement("sk:in", "compartment_1")
    assert world.element("my_starter").label == "Starter"


def test_drafts_that_refer_to_each_other_are_added_once() -> None:
    first, second = Draft("kitting:Starter"), Draft("kitting:Starter")
    first.relate("sk:poseFrame", second)
    second.relate("^sk:poseFrame", first)

    assert first.all() == [first, second]
    assert second.all() == [second, first]


def test_two_equal_drafts_become_two_elements(world: World) -> None:
    pallet = Draft("kitting:Pallet", relations=[("sk:on", "floor")])
    for _ in range(2):
        pallet.relate("^sk:in", Draft("kitting:Starter"))

    with world.transaction("delivery", "a pallet") as tx:
        ids = add_draft(tx, pallet)

    assert world.subjects("sk:in", ids[pallet]) == ("starter_2", "starter_3")


def test_a_draft_with_an_invalid_part_is_not_added_at_all(world: World) -> None:
    kit = Draft("kitting:Kit", relations=[("sk:on", "kit_table")])
    kit.relate("sk:hasA", Draft("kitting:Compartmnt"))
    before = world.version

    with (
        pytest.raises(WorldError, match="Did you mean 'kitting:Compartment'"),
        world.transaction("operator", "a kit") as tx,
    ):
        add_draft(tx, kit)

    assert world.version == before
    assert world.instances("kitting:Kit") == ("kit_1",)


def test_a_copy_has_the_pieces_the_contents_and_their_relations_but_no_place(world: World) -> None:
    with world.transaction("put", "it lies there") as tx:
        tx.place("starter_1", "sk:in", "kit_1_a")
        tx.set("starter_1", "sk:mass", 0.75)

    with world.transaction("operator", "another one") as tx:
        copy = draft_of(tx.view, "kit_1")
        assert not [relation for relation, _ in copy.relations if relation in ("sk:on", "sk:in")]
        copy.relate("sk:on", "floor")
        ids = add_draft(tx, copy)

    pieces = world.objects(ids[copy], "sk:hasA")
    (starter,) = world.subjects("sk:in", pieces[0])
    assert [world.element(piece).label for piece in pieces] == [f"compartment {letter}" for letter in "ABCD"]
    assert all(world.objects(piece, "sk:poseFrame") == (ids[copy],) for piece in pieces)
    assert world.element(starter).properties == {"sk:mass": 0.75}
    assert world.placement("starter_1") == Placement("sk:in", "kit_1_a")


def test_a_copy_keeps_a_pose_only_if_its_frame_is_copied_too(world: World) -> None:
    kit = draft_of(world, "kit_1")
    by_label = {draft.label: draft for draft in kit.all()}

    assert "sk:pose" not in kit.properties
    assert kit.properties["sk:drivingPose"] == world.value("kit_1", "sk:drivingPose")
    assert by_label["compartment A"].properties["sk:pose"] == world.value("kit_1_a", "sk:pose")


def test_a_piece_is_copied_without_the_frame_that_is_not_copied(world: World) -> None:
    piece = draft_of(world, "kit_1_a")

    assert piece.relations == []
    assert piece.properties == {}


def test_a_copy_keeps_plain_relations_to_others(world: World) -> None:
    with world.transaction("operator", "starts there") as tx:
        tx.relate("robot_1", "sk:startLocation", "pallet_a")

    assert ("sk:startLocation", "pallet_a") in draft_of(world, "robot_1").relations


def test_a_copy_follows_the_given_relations_only(world: World) -> None:
    assert [draft.class_ for draft in draft_of(world, "pallet_b", "sk:hasA").all()] == ["kitting:Shelf"]
    assert [draft.class_ for draft in draft_of(world, "pallet_b").all()] == [
        "kitting:Shelf",
        "kitting:Compressor",
        "kitting:RelayBox",
    ]


def test_copying_along_a_computed_relation_is_refused(world: World) -> None:
    with pytest.raises(UsageError, match="sk:near is computed"):
        draft_of(world, "kit_1", "sk:near")


def test_instantiating_an_abstract_element_adds_it_with_its_parts_to_the_scene(world: World) -> None:
    with world.transaction("operator", "a second kit") as tx:
        kit = instantiate(tx, "kitting:standard_kit", Placement("sk:on", "kit_table"))

    pieces = world.objects(kit, "sk:hasA")
    template = world.objects("kitting:standard_kit", "sk:hasA")
    assert kit == "kit_2"
    assert world.placement(kit) == Placement("sk:on", "kit_table")
    assert [world.element(p).label for p in pieces] == [world.element(t).label for t in template]
    assert [world.value(p, "sk:pose") for p in pieces] == [world.value(t, "sk:pose") for t in template]
    assert all(world.objects(piece, "sk:poseFrame") == (kit,) for piece in pieces)


def test_only_abstract_elements_can_be_instantiated(world: World) -> None:
    with world.transaction("test", "try it") as tx:
        with pytest.raises(UsageError, match="'kit_1' is in the scene already"):
            instantiate(tx, "kit_1")
        with pytest.raises(UnknownName, match="unknown element 'kitting:standard_kt'"):
            instantiate(tx, "kitting:standard_kt")

    assert world.instances("kitting:Kit") == ("kit_1",)


def test_a_learned_concept_remains_after_its_source_is_removed(world: World) -> None:
    with world.transaction("put", "it lies there") as tx:
        tx.place("starter_1", "sk:in", "kit_1_a")
    with world.transaction("teacher", "that is how a kit looks") as tx:
        learned = learn(tx, "kit_1")
    with world.transaction("operator", "done") as tx:
        tx.remove("kit_1")

    pieces = world.objects(learned, "sk:hasA")
    assert learned == "learned:kit_1"
    assert len(pieces) == 4
    assert [world.element(name).type for name in world.subjects("sk:in", pieces[0])] == ["kitting:Starter"]
    assert world.placement(learned) is None


def test_a_learned_concept_has_no_relations_to_the_scene(world: World) -> None:
    with world.transaction("operator", "starts there") as tx:
        tx.relate("robot_1", "sk:startLocation", "pallet_a")
    with world.transaction("teacher", "such a robot") as tx:
        robot = learn(tx, "robot_1")

    assert world.objects(robot, "sk:startLocation") == ()
    assert len(world.objects(robot, "sk:hasA")) == 3


def test_a_learned_concept_is_instantiated_unchanged(world: World) -> None:
    with world.transaction("teacher", "there and back") as tx:
        again = instantiate(tx, learn(tx, "kit_1"), Placement("sk:on", "kit_table"))

    old, new = (world.objects(kit, "sk:hasA") for kit in ("kit_1", again))
    assert [world.value(piece, "sk:pose") for piece in new] == [world.value(piece, "sk:pose") for piece in old]
    assert [world.element(piece).label for piece in new] == [world.element(piece).label for piece in old]


@pytest.mark.parametrize("name", ["kitting:standard_kit", "learned:kit_1"])
def test_learning_from_an_abstract_element_is_refused(world: World, name: str) -> None:
    with world.transaction("teacher", "shown") as tx:
        learn(tx, "kit_1")

    with (
        world.transaction("teacher", "again") as tx,
        pytest.raises(UsageError, match=f"'{name}' is abstract already"),
    ):
        learn(tx, name)

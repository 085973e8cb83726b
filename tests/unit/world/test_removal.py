"""What is removed takes its pieces along and leaves what lay in them somewhere that the ontology allows."""

from __future__ import annotations

import pytest

from skiros_py.errors import WorldError
from skiros_py.world.element import Placement
from skiros_py.world.world import World


def remove(world: World, element: str) -> None:
    with world.transaction("operator", "taken away") as tx:
        tx.remove(element)


def refusal(world: World, element: str) -> str:
    before = world.version
    with pytest.raises(WorldError) as caught:
        remove(world, element)
    assert world.version == before
    return str(caught.value)


def test_what_lay_in_it_goes_where_it_was_by_the_relation_by_which_it_was_there(world: World) -> None:
    remove(world, "pallet_a")

    for part in ("alternator_1", "relay_box_1", "starter_1"):
        assert world.placement(part) == Placement("sk:on", "floor")


def test_what_cannot_be_there_in_the_same_way_keeps_its_own(world: World) -> None:
    with world.transaction("drive", "arrived") as tx:
        tx.place("robot_1", "sk:at", "pallet_a")
        tx.place("starter_1", "sk:on", "deck_1")

    remove(world, "robot_1")

    assert world.placement("starter_1") == Placement("sk:on", "pallet_a")


def test_a_held_element_and_its_owner_cannot_be_removed(world: World) -> None:
    with world.transaction("pick", "fingers closed") as tx:
        tx.place("starter_1", "sk:heldBy", "gripper_1")

    assert "starter_1 is held by gripper_1: have it put down before it is removed" in refusal(world, "starter_1")


def test_everything_that_would_be_nowhere_is_named(world: World) -> None:
    text = refusal(world, "floor")

    for name in ("kit_table", "pallet_a", "pallet_b", "rack_1"):
        assert f"{name} would be nowhere: place it elsewhere first" in text


def test_a_piece_is_removed_alone_and_what_lay_in_it_goes_where_the_whole_is(world: World) -> None:
    with world.transaction("put", "it lies there") as tx:
        tx.place("starter_1", "sk:in", "kit_1_a")

    remove(world, "kit_1_a")

    assert world.objects("kit_1", "sk:hasA") == ("kit_1_b", "kit_1_c", "kit_1_d")
    assert world.placement("starter_1") == Placement("sk:on", "kit_table")


def test_relations_of_others_to_it_go_with_it(world: World) -> None:
    with world.transaction("operator", "starts there") as tx:
        tx.relate("robot_1", "sk:startLocation", "pallet_b")

    remove(world, "pallet_b")

    assert world.objects("robot_1", "sk:startLocation") == ()


def test_what_is_learned_leaves_what_lay_in_it_in_no_place(world: World) -> None:
    with world.transaction("teacher", "shown") as tx:
        kit = tx.add("kitting:Kit", learned=True)
        starter = tx.add("kitting:Starter", learned=True)
        tx.place(starter, "sk:in", kit)

    remove(world, kit)

    assert world.placement(starter) is None

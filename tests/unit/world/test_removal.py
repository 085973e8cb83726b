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


def test_the_content_of_a_removed_element_moves_to_its_place_by_its_placement_relation(world: World) -> None:
    remove(world, "pallet_a")

    for part in ("alternator_1", "relay_box_1", "starter_1"):
        assert world.placement(part) == Placement("sk:on", "floor")


def test_content_that_cannot_use_the_placement_relation_of_the_removed_element_keeps_its_own(world: World) -> None:
    with world.transaction("drive", "arrived") as tx:
        tx.place("robot_1", "sk:at", "pallet_a")
        tx.place("starter_1", "sk:on", "deck_1")

    remove(world, "robot_1")

    assert world.placement("starter_1") == Placement("sk:on", "pallet_a")


def test_a_held_element_and_its_owner_cannot_be_removed(world: World) -> None:
    with world.transaction("pick", "fingers closed") as tx:
        tx.place("starter_1", "sk:heldBy", "gripper_1")

    assert "starter_1 is held by gripper_1: have it put down before it is removed" in refusal(world, "starter_1")


def test_every_element_that_would_lose_its_place_is_named(world: World) -> None:
    text = refusal(world, "floor")

    for name in ("kit_table", "pallet_a", "pallet_b", "rack_1"):
        assert f"{name} would be nowhere: place it elsewhere first" in text


def test_removing_a_part_keeps_the_whole_and_moves_its_content_to_the_place_of_the_whole(world: World) -> None:
    with world.transaction("put", "it lies there") as tx:
        tx.place("starter_1", "sk:in", "kit_1_a")

    remove(world, "kit_1_a")

    assert world.objects("kit_1", "sk:hasA") == ("kit_1_b", "kit_1_c", "kit_1_d")
    assert world.placement("starter_1") == Placement("sk:on", "kit_table")


def test_relations_to_a_removed_element_are_removed(world: World) -> None:
    with world.transaction("operator", "starts there") as tx:
        tx.relate("robot_1", "sk:startLocation", "pallet_b")

    remove(world, "pallet_b")

    assert world.objects("robot_1", "sk:startLocation") == ()


def test_the_content_of_a_removed_learned_concept_has_no_place(world: World) -> None:
    with world.transaction("teacher", "shown") as tx:
        kit = tx.add("kitting:Kit", learned=True)
        starter = tx.add("kitting:Starter", learned=True)
        tx.place(starter, "sk:in", kit)

    remove(world, kit)

    assert world.placement(starter) is None

"""Branches hold what hangs on an element, each thing once, by the narrowest relation that ties it."""

from __future__ import annotations

import pytest

from skiros_py.errors import UnknownName, UsageError
from skiros_py.world.branches import branch, children, parent, tree
from skiros_py.world.element import Placement
from skiros_py.world.world import World

COMPARTMENTS = tuple(f"kit_1_{letter}" for letter in "abcd")


def test_the_children_of_an_element_are_its_parts_and_the_elements_placed_in_it(world: World) -> None:
    with world.transaction("put", "it lies there") as tx:
        tx.place("starter_1", "sk:in", "kit_1")

    assert children(world, "kit_1") == (*COMPARTMENTS, "starter_1")
    assert children(world, "kit_1", "sk:hasA") == COMPARTMENTS
    assert children(world, "kit_1", "sk:in") == ("starter_1",)
    assert children(world, "starter_1") == ()


def test_a_relation_read_backwards_turns_children_and_parent_around(world: World) -> None:
    assert children(world, "kit_1", "^sk:poseFrame") == COMPARTMENTS
    assert parent(world, "kit_1_a", "^sk:poseFrame") == "kit_1"
    assert children(world, "starter_1", "^sk:in") == ("pallet_a",)
    assert parent(world, "pallet_b", "^sk:on") is None


def test_children_and_parent_of_one_relation_are_inverse(world: World) -> None:
    for relation in ("sk:hasA", "sk:on", "sk:in", "sk:placement", "^sk:poseFrame", "^sk:mountedOn"):
        for element in world.instances("sk:Element"):
            above = parent(world, element, relation)
            hanging_on = [name for name in world.instances("sk:Element") if element in children(world, name, relation)]
            assert hanging_on == ([above] if above else [])


def test_a_parent_is_the_owner_or_the_place(world: World) -> None:
    assert parent(world, "kit_1_a") == "kit_1"
    assert parent(world, "kit_1") == "kit_table"
    assert parent(world, "floor") is None


def test_the_parent_of_an_element_with_several_parents_is_refused_as_ambiguous(world: World) -> None:
    with pytest.raises(UsageError, match="arm_1 hangs on camera_1 and force_torque_1 and gripper_1 and robot_1: name"):
        parent(world, "arm_1", "sk:hasA", "sk:mountedOn")


@pytest.mark.parametrize("ask", [children, parent, branch])
def test_an_unknown_name_is_refused_with_the_nearest_known_name(world: World, ask: object) -> None:
    assert callable(ask)
    with pytest.raises(UnknownName, match="unknown element 'kit_9'"):
        ask(world, "kit_9")
    with pytest.raises(UnknownName, match=r"unknown relation 'sk:hazA'\. Did you mean 'sk:hasA'"):
        ask(world, "kit_1", "sk:hazA")


def test_each_node_of_a_branch_has_its_depth_and_its_most_specific_relation(world: World) -> None:
    walked = [(depth, node.element.id, node.relation) for depth, node in branch(world, "kit_table").walk()]

    assert walked == [
        (0, "kit_table", None),
        (1, "kit_1", "sk:on"),
        *[(2, name, "sk:hasA") for name in COMPARTMENTS],
    ]


def test_a_branch_over_inverse_relations_names_the_inverse_relations(world: World) -> None:
    up = [(node.element.id, node.relation) for _, node in branch(world, "starter_1", "^sk:placement").walk()]

    assert up == [("starter_1", None), ("pallet_a", "^sk:in"), ("floor", "^sk:on")]


def test_a_branch_follows_the_given_relations_only(world: World) -> None:
    assert [node.element.id for _, node in branch(world, "floor", "sk:hasA").walk()] == ["floor"]


def test_the_trees_hold_everything_in_the_scene_once(world: World) -> None:
    trees = tree(world)
    walked = [node.element.id for root in trees for _, node in root.walk()]

    assert [root.element.id for root in trees] == ["floor", "unknown_location"]
    assert sorted(walked) == list(world.instances("sk:Element"))


def test_an_element_that_is_not_spatial_is_a_root(world: World) -> None:
    with world.transaction("test", "a skill") as tx:
        tx.add("sk:Skill", id="a_skill")

    assert [root.element.id for root in tree(world)] == ["a_skill", "floor", "unknown_location"]


def test_an_element_in_a_cycle_appears_once_in_the_branch(world: World) -> None:
    walked = [node.element.id for _, node in branch(world, "starter_1", "sk:in", "^sk:in").walk()]

    assert sorted(walked) == ["alternator_1", "pallet_a", "relay_box_1", "starter_1"]


def test_an_element_with_several_parents_appears_at_its_smallest_depth(world: World) -> None:
    found = branch(world, "robot_1", "sk:hasA", "sk:mountedOn")

    assert [(depth, node.element.id) for depth, node in found.walk()][:2] == [(0, "robot_1"), (1, "arm_1")]
    assert [node.element.id for node in found.children] == ["arm_1", "base_1", "deck_1"]


def test_a_branch_of_depth_one_thousand_is_read(world: World) -> None:
    with world.transaction("test", "a tower") as tx:
        below = "floor"
        for number in range(1000):
            tx.add("kitting:Kit", id=f"tray_{number}", placement=Placement("sk:on", below))
            below = f"tray_{number}"

    depths = [depth for depth, _ in branch(world, "tray_0").walk()]
    assert depths == list(range(1000))

"""The world as it is seen: where everything is believed to be, and what it looks like."""

from __future__ import annotations

import math

import pytest

from skiros_py.api.view import ViewElement, WorldView
from skiros_py.geometry import Pose
from skiros_py.station.world.view import view_of
from skiros_py.testing import world_of
from skiros_py.world.world import World

PANDA = "https://w3id.org/skiros-py/robots/mobile_panda"


def kitting() -> World:
    return world_of("kitting")


def seen(view: WorldView) -> dict[str, ViewElement]:
    return {element.id: element for element in view.elements}


def position(element: ViewElement) -> tuple[float, ...]:
    assert element.pose is not None
    return element.pose.position


def test_each_element_of_a_view_has_the_kind_given_by_its_class() -> None:
    view = seen(view_of(kitting().snapshot()))

    kinds = {name: element.kind for name, element in view.items()}
    assert kinds["starter_1"] == "part"
    assert kinds["pallet_a"] == kinds["kit_1"] == kinds["kit_1_a"] == kinds["kit_table"] == "place"
    assert (kinds["rack_1"], kinds["floor"], kinds["robot_1"], kinds["base_1"]) == (
        "furniture",
        "floor",
        "robot",
        "device",
    )


def test_abstract_elements_and_elements_without_a_place_are_not_in_the_view() -> None:
    world = kitting()
    names = set(seen(view_of(world.snapshot())))

    assert not names & set(world.abstracts("sk:Element"))
    assert not names & {"unknown_location", "camera_1", *world.instances("sk:Module")}
    assert {"starter_1", "floor"} <= names


def test_the_pose_of_a_part_follows_the_frame_of_its_whole() -> None:
    view = seen(view_of(kitting().snapshot()))

    assert position(view["kit_1_a"]) == pytest.approx((-1.477, -0.073, 0.506))
    assert (view["kit_1_a"].owner, view["kit_1_a"].hollow, view["kit_1"].hollow) == ("kit_1", True, False)


def test_a_part_not_yet_seen_has_a_place_but_no_pose() -> None:
    view = seen(view_of(kitting().snapshot()))

    assert (view["starter_1"].pose, view["starter_1"].place) == (None, "pallet_a")


def test_a_carried_element_has_its_pose_in_the_frame_of_its_base() -> None:
    world = world_of("kitting_carried")
    here, there = (seen(view_of(world.snapshot(), None, {"base_1": Pose.of(x, 0, 0)})) for x in (0.0, 3.0))

    riding = {name for name, element in here.items() if element.carrier == "base_1"}
    assert {"deck_1", "kit_1", "kit_1_a"} <= riding
    assert {name: here[name] for name in riding} == {name: there[name] for name in riding}


def test_a_robot_has_the_pose_of_its_base_and_none_if_that_is_unknown() -> None:
    index = kitting().snapshot()
    there = seen(view_of(index, None, {"base_1": Pose.of(1.0, 2.0, 0.0)}))

    assert position(there["robot_1"]) == position(there["base_1"]) == (1.0, 2.0, 0.0)
    assert seen(view_of(index))["robot_1"].pose is None


def test_a_held_element_has_its_pose_in_the_tool_frame() -> None:
    world = kitting()
    grasp = Pose.of(0.0, 0.01, 0.02)
    with world.transaction(author="grasp", reason="felt") as tx:
        tx.place("starter_1", "sk:heldBy", "gripper_1")
        tx.relate("starter_1", "sk:poseFrame", "gripper_1")
        tx.set("starter_1", "sk:pose", grasp)

    part = seen(view_of(world.snapshot()))["starter_1"]

    assert (part.held_by, part.pose, part.carrier) == ("gripper_1", None, None)
    assert part.in_hand is not None
    assert part.in_hand.position == grasp.position


def test_elements_with_equal_own_shapes_share_one_shape_key() -> None:
    solid = '[{"kind": "cylinder", "size": [0.1, 0.2], "at": [0, 0, 0.1]}]'
    pallets = [
        f"scene:pallet_{n} a kitting:Pallet ; sk:on scene:floor ; sk:solid '{solid}'^^rdf:JSON ;"
        f' sk:pose "{n} 0 0 0 0 0"^^sk:poseLiteral .'
        for n in range(2)
    ]
    usual = 'scene:pallet_9 a kitting:Pallet ; sk:on scene:floor ; sk:pose "9 0 0 0 0 0"^^sk:poseLiteral .'
    view = view_of(world_of("\n".join([*pallets, usual])).snapshot())

    keys = [seen(view)[f"pallet_{n}"].shape for n in (0, 1, 9)]
    assert keys[0] == keys[1] != keys[2] == "kitting:Pallet"
    (block,) = view.shapes[keys[0] or ""]
    assert (block.kind, block.size, block.pose.position) == ("cylinder", (0.1, 0.2), (0.0, 0.0, 0.1))


def test_a_floor_is_a_sheet_below_the_ground() -> None:
    view = view_of(kitting().snapshot())

    (sheet,) = view.shapes[seen(view)["floor"].shape or ""]
    assert sheet.size[:2] == (7.4, 6.0)
    assert sheet.pose.position[2] + sheet.size[2] / 2.0 == pytest.approx(0.0)


def test_a_partial_view_contains_the_requested_elements_and_those_that_move_with_them() -> None:
    world = kitting()

    view = view_of(world.snapshot(), ["kit_1", "nothing", "unknown_location"])

    assert set(seen(view)) == {"kit_1", "kit_1_a", "kit_1_b", "kit_1_c", "kit_1_d"}
    assert view.gone == ("nothing", "unknown_location")
    assert set(view.shapes) == {"kitting:Kit", "kitting:Compartment"}
    assert {"robot_1", "deck_1"} <= set(seen(view_of(world.snapshot(), ["base_1"])))


def test_a_removed_element_is_no_longer_in_the_view() -> None:
    world = kitting()
    with world.transaction(author="anna", reason="tidy") as tx:
        tx.remove("starter_1")

    assert view_of(world.snapshot(), ["starter_1"]).gone == ("starter_1",)
    assert "starter_1" not in seen(view_of(world.snapshot()))


def test_the_version_of_an_element_is_that_of_its_last_change() -> None:
    world = kitting()
    with world.transaction(author="anna", reason="moved") as tx:
        tx.set("pallet_a", "sk:pose", Pose.of(4.0, 1.0, 0.0))

    view = view_of(world.snapshot())

    assert seen(view)["pallet_a"].version == view.version == world.version
    assert seen(view)["pallet_b"].version < view.version


def test_a_chain_of_3000_frames_is_resolved() -> None:
    deep = 3000
    chain = [
        f"scene:pallet_{n} a kitting:Pallet ; sk:on scene:floor ; sk:poseFrame scene:pallet_{n - 1} ;"
        ' sk:pose "0.001 0 0 0 0 0"^^sk:poseLiteral .'
        for n in range(1, deep)
    ]
    first = 'scene:pallet_0 a kitting:Pallet ; sk:on scene:floor ; sk:pose "0 0 0 0 0 0"^^sk:poseLiteral .'
    view = seen(view_of(world_of("\n".join([first, *chain])).snapshot()))

    assert math.isclose(position(view[f"pallet_{deep - 1}"])[0], 0.001 * (deep - 1), rel_tol=1e-6)

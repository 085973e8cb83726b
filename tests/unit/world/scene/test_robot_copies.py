"""A scene with several robots of one kind: each gets pieces of its own."""

from __future__ import annotations

from pathlib import Path

import pytest

from skiros_py.devices.arm import ArmSpec
from skiros_py.devices.camera import CameraSpec
from skiros_py.devices.gripper import GripperSpec
from skiros_py.errors import FileError
from skiros_py.skills.cell_reader import read_cell
from skiros_py.testing.tiny import world_of
from skiros_py.world.element import Placement
from skiros_py.world.ontology import Ontology
from skiros_py.world.scene.files import load_scene, save_scene
from skiros_py.world.world import World

PANDA = "https://w3id.org/skiros-py/robots/mobile_panda"
TWO = """
scene:base_1 sk:pose "0 0 0 0 0 0"^^sk:poseLiteral .
scene:robot_2 a sk:Robot ; rdfs:label "second" ; sk:builtLike scene:robot_1 .
scene:base_2 sk:pose "0 2 0 0 0 0"^^sk:poseLiteral .
"""


def two(text: str = TWO) -> World:
    return world_of(text, imports=[PANDA])


def test_a_robot_built_like_another_has_pieces_of_its_own_with_its_own_number() -> None:
    world = two()

    assert world.objects("robot_2", "sk:hasA") == ("arm_2", "base_2", "deck_2")
    assert world.objects("arm_2", "sk:hasA") == ("camera_2", "force_torque_2", "gripper_2")
    assert world.objects("arm_2", "sk:mountedOn") == ("base_2",)
    assert world.objects("deck_2", "sk:poseFrame") == ("base_2",)


def test_a_copied_robot_differs_for_its_driver_only_in_names_and_start_pose() -> None:
    one, other = read_cell(two(), ["robot_1", "robot_2"]).robots

    assert (one.model, one.of(ArmSpec)[0].home, one.of(CameraSpec)[0].width) == (
        other.model,
        other.of(ArmSpec)[0].home,
        other.of(CameraSpec)[0].width,
    )
    assert other.of(GripperSpec)[0].arm == "arm_2"
    assert (one.start.position, other.start.position) == ((0.0, 0.0, 0.0), (0.0, 2.0, 0.0))


def test_statements_about_a_copied_robot_override_the_original() -> None:
    station = "scene:station_1 a sk:Station ; sk:on scene:floor . scene:robot_2 sk:at scene:station_1 ."
    told = f"{station} scene:base_2 sk:maxLinear 0.3 ."

    world = two(TWO + told)

    assert world.element("robot_2").label == "second"
    assert world.placement("robot_2") == Placement("sk:at", "station_1")
    assert world.value("base_2", "sk:maxLinear") == 0.3
    assert world.value("base_1", "sk:maxLinear") == 0.8


def test_the_map_pose_of_a_base_is_not_copied() -> None:
    world = two(TWO.replace('scene:base_2 sk:pose "0 2 0 0 0 0"^^sk:poseLiteral .', ""))

    assert world.value("base_2", "sk:pose") is None


def test_a_piece_without_the_number_of_its_robot_gets_that_of_the_copy() -> None:
    world = two(TWO + "scene:robot_1 sk:hasA scene:lamp . scene:lamp a sk:Device .")

    assert "lamp_2" in world.objects("robot_2", "sk:hasA")


def test_a_saved_scene_contains_all_statements_of_a_copied_robot(ontology: Ontology, tmp_path: Path) -> None:
    world = two()

    save_scene(world, tmp_path / "saved.ttl")

    assert "builtLike" not in (tmp_path / "saved.ttl").read_text(encoding="utf-8")
    again = load_scene(ontology, tmp_path / "saved.ttl")
    assert again.objects("robot_2", "sk:hasA") == world.objects("robot_2", "sk:hasA")


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("scene:robot_3 a sk:Robot ; sk:builtLike scene:robot_9 .", "robot_9"),
        ("scene:robot_3 a sk:Robot ; sk:builtLike scene:robot_2 .", "name one that is described in full"),
        ("scene:robot_3 a sk:Robot ; sk:builtLike scene:robot_3 .", "name one that is described in full"),
        ("scene:robot_2 sk:builtLike scene:base_1 .", "may be like one other robot"),
    ],
)
def test_a_robot_that_cannot_be_copied_is_refused_with_its_line(text: str, reason: str) -> None:
    with pytest.raises(FileError, match=reason) as refused:
        two(TWO + text)

    assert refused.value.line is not None


CELL = "<https://w3id.org/skiros-py/robots/ur10e_cell>"
OTHER_KIND = f"""
scene:base_1 sk:pose "0 0 0 0 0 0"^^sk:poseLiteral .
scene:robot_2 a sk:Robot ; sk:builtLike {CELL} ; sk:at scene:unknown_location ; sk:pose "0 2 0 0 0 0"^^sk:poseLiteral .
"""


def test_robots_of_two_kinds_are_in_one_scene_by_the_file_that_describes_the_second() -> None:
    world = two(OTHER_KIND)

    one, other = read_cell(world, ["robot_1", "robot_2"]).robots
    assert (one.model, other.model) == ("mobile_panda", "ur10e_cell")
    assert world.objects("robot_2", "sk:hasA") == ("arm_2",)
    assert world.objects("arm_2", "sk:hasA") == ("camera_2", "force_torque_2", "gripper_2")
    assert world.objects("gripper_2", "sk:mountedOn") == ("arm_2",)
    assert (one.of(GripperSpec)[0].max_gap, other.of(GripperSpec)[0].max_gap) == (0.08, 0.14)


def test_a_file_that_nobody_has_or_that_describes_no_robot_is_refused_with_its_line() -> None:
    missing = OTHER_KIND.replace("robots/ur10e_cell", "robots/crane")
    none = OTHER_KIND.replace("robots/ur10e_cell", "robots/three_finger_gripper")

    for text, reason in ((missing, "robots/crane"), (none, "must describe one robot")):
        with pytest.raises(FileError, match=reason) as refused:
            two(text)
        assert refused.value.line is not None

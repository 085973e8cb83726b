"""The shipped scenes make sense: what stands where, and that the robot can work there."""

from __future__ import annotations

from pathlib import Path

import pytest

from skiros_py.geometry import Pose, Solid
from skiros_py.world.branches import Branch, tree
from skiros_py.world.ontology import Ontology
from skiros_py.world.poses import map_pose
from skiros_py.world.scene.files import load_scene
from skiros_py.world.world import World


def test_the_scene_tree_follows_placements_and_parts_from_its_roots(world: World) -> None:
    def outline(node: Branch) -> dict[str, object]:
        return {child.element.id: outline(child) for child in node.children}

    roots = {node.element.id: node for node in tree(world)}

    assert list(roots) == ["floor", "unknown_location"]
    assert outline(roots["unknown_location"]) == {
        "robot_1": {
            "arm_1": {"camera_1": {}, "force_torque_1": {}, "gripper_1": {}},
            "base_1": {"localiser_1": {}, "scanner_1": {}},
            "deck_1": {},
        }
    }
    robot = roots["unknown_location"].children[0]
    assert (robot.relation, robot.children[0].relation) == ("sk:at", "sk:hasA")


def test_a_docked_robot_stands_48_cm_in_front_of_the_near_edge(world: World) -> None:
    near_edge = {"pallet_a": (4.7, 1.6), "pallet_b": (4.7, -1.6), "kit_1": (-1.3, 0.0)}
    for place, (x, y) in near_edge.items():
        frame, dock = map_pose(world, place), world.value(place, "sk:drivingPose")
        assert isinstance(frame, Pose)
        assert isinstance(dock, Pose)

        base = frame @ dock

        assert base.position == pytest.approx((x - 0.48 if x > 0 else x + 0.48, y, 0.0))


def test_every_compartment_is_in_reach_of_the_docked_arm(ontology: Ontology, world: World, root: Path) -> None:
    carried = load_scene(ontology, root / "scenes" / "kitting_carried.ttl")
    for name in world.instances("kitting:Compartment"):
        on_table, on_deck = map_pose(world, name), map_pose(carried, name)
        assert on_table is not None
        assert on_deck is not None

        assert 0.10 + 0.07 <= -1.3 - on_table.position[0] <= 0.40 - 0.07
        assert 0.30 <= on_deck.distance(Pose.of(0.22, 0, on_deck.position[2])) <= 0.62


def test_parts_can_be_grasped_across_y(ontology: Ontology) -> None:
    for part in ontology.subclasses("kitting:Part")[1:]:
        solid, width = ontology.class_value(part, "sk:solid"), ontology.class_value(part, "sk:graspWidth")
        assert isinstance(solid, str)
        assert isinstance(width, float)
        low, high = Solid.from_json(solid).bounds()

        assert width <= 0.068
        assert high[1] - low[1] == pytest.approx(width)
        assert low[2] == pytest.approx(0.0)

"""Boxes as read from worlds."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from skiros_py.geometry import Pose, Solid
from skiros_py.world.element import Placement
from skiros_py.world.ontology import Ontology
from skiros_py.world.overlay import Overlay
from skiros_py.world.poses import map_pose, write_pose
from skiros_py.world.reasoners.boxes import MAP, read_boxes
from skiros_py.world.world import World

ONTOLOGY = Ontology.load([Path(__file__).parents[4] / "ontologies"])

numbers = st.floats(-2.0, 2.0)
lengths = st.floats(0.01, 1.0)
poses = st.builds(lambda x, y, z, r, p, w: Pose.of(x, y, z, roll=r, pitch=p, yaw=w), *[numbers] * 6)
blocks = st.builds(
    lambda size, at, rpy: {"kind": "box", "size": size, "at": at, "rpy": rpy},
    *[st.lists(some, min_size=3, max_size=3) for some in (lengths, numbers, numbers)],
)
solids = st.lists(blocks, min_size=1, max_size=3).map(json.dumps)


def empty_world(*things: str) -> World:
    world = World(ONTOLOGY)
    with world.transaction("test", "a floor") as tx:
        tx.add("sk:Floor", id="floor")
        for thing in things:
            tx.add("sk:Object", id=thing, placement=Placement("sk:on", "floor"))
    return world


@settings(max_examples=50, deadline=None)
@given(solids, poses, poses)
def test_a_bounding_box_encloses_its_shape_tightly(solid: str, own: Pose, frame: Pose) -> None:
    world = empty_world("thing", "table")
    with world.transaction("test", "shapes and poses") as tx:
        tx.set("thing", "sk:solid", solid)
        write_pose(tx, "thing", own, "table")
        write_pose(tx, "table", frame)
    box = read_boxes(world, ["thing"])

    pose = map_pose(world, "thing")
    assert pose is not None
    corners = np.vstack(
        [
            pose.apply(block.pose.apply(np.array(np.meshgrid(*[[-0.5, 0.5]] * 3)).reshape(3, 8).T * block.size))
            for block in Solid.from_json(solid).primitives
        ]
    )
    local = (corners - box.centres[0]) @ box.axes[0]
    assert np.allclose(local.max(axis=0), box.halves[0], atol=1e-6)
    assert np.allclose(local.min(axis=0), -box.halves[0], atol=1e-6)
    assert np.allclose(box.axes[0], Rotation.from_quat(pose.orientation).as_matrix(), atol=1e-9)


def test_a_box_uses_the_shape_of_the_element_then_of_its_class_then_its_size() -> None:
    world = empty_world("lump")
    with world.transaction("test", "things") as tx:
        tx.add("kitting:RelayBox", id="usual", placement=Placement("sk:on", "floor"))
        own = {"sk:solid": '[{"kind": "box", "size": [2, 2, 2]}]'}
        tx.add("kitting:RelayBox", id="odd", properties=own, placement=Placement("sk:on", "floor"))
        tx.set("floor", "sk:size", (8.0, 6.0))
    box = read_boxes(world, ["usual", "odd", "floor", "lump"])

    assert box.halves == pytest.approx(np.array([[0.0295, 0.020, 0.027], [1, 1, 1], [4, 3, 0], [0, 0, 0]]))
    assert box.sized.tolist() == [True, True, True, False]


def test_a_hollow_class_makes_hollow_boxes() -> None:
    world = empty_world()
    with world.transaction("test", "a compartment") as tx:
        tx.add("kitting:Compartment", id="room", placement=Placement("sk:on", "floor"))

    assert read_boxes(world, ["room", "floor"]).hollow.tolist() == [True, False]


def test_an_element_without_a_pose_is_the_root_frame_of_itself_and_its_dependants() -> None:
    world = empty_world("gripper", "held", "free")
    with world.transaction("test", "held") as tx:
        write_pose(tx, "held", Pose.of(0, 0, 0.1), "gripper")
        write_pose(tx, "free", Pose())
    roots = read_boxes(world, ["held", "gripper", "free", "floor"]).roots

    assert roots[0] == roots[1] != MAP
    assert roots[2] == MAP
    assert roots[3] not in (MAP, roots[0])


def test_a_frame_cycle_in_an_overlay_has_no_pose_in_the_map() -> None:
    world = empty_world("a", "b", "c")
    with world.transaction("test", "poses") as tx:
        for thing, frame in (("a", None), ("b", "a"), ("c", "b")):
            write_pose(tx, thing, Pose(), frame)
    supposed = Overlay(world)
    supposed.set_relation("a", "sk:poseFrame", "b")

    assert MAP not in read_boxes(supposed, ["a", "b", "c"]).roots


def test_a_tower_of_a_thousand_frames_is_read() -> None:
    things = [f"t{number}" for number in range(1000)]
    world = empty_world(*things)
    with world.transaction("test", "a tower") as tx:
        for below, above in zip([None, *things], things, strict=False):
            write_pose(tx, above, Pose.of(0, 0, 0.01), below)

    assert read_boxes(world, things[::-1]).centres[0] == pytest.approx([0, 0, 10.0])

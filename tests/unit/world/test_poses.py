"""Frame trees against products of matrices."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_py.errors import UnknownName, WorldError
from skiros_py.geometry import Array, Pose
from skiros_py.world.element import Placement
from skiros_py.world.ontology import Ontology
from skiros_py.world.overlay import Overlay
from skiros_py.world.poses import attach, map_pose, move, pose_in, pose_on, write_pose
from skiros_py.world.world import World

ONTOLOGY = Ontology.load([Path(__file__).parents[3] / "ontologies" / "core.ttl"])

Tree = list[tuple[int | None, Pose]]
"""Of each thing, on which earlier one it hangs (None: the map) and its pose there."""

numbers = st.floats(-3.0, 3.0)
poses = st.builds(lambda x, y, z, r, p, w: Pose.of(x, y, z, roll=r, pitch=p, yaw=w), *[numbers] * 6)


@st.composite
def trees(draw: st.DrawFn) -> Tree:
    size = draw(st.integers(2, 7))
    return [(draw(st.none() | st.integers(0, at - 1)) if at else None, draw(poses)) for at in range(size)]


def world_of(tree: Tree) -> World:
    world = World(ONTOLOGY)
    with world.transaction("test", "a tree of frames") as tx:
        tx.add("sk:Floor", id="floor")
        for at, (above, pose) in enumerate(tree):
            tx.add("sk:Object", id=f"thing_{at}", placement=Placement("sk:on", "floor"))
            write_pose(tx, f"thing_{at}", pose, None if above is None else f"thing_{above}")
    return world


def matrix(tree: Tree, at: int) -> Array:
    above, pose = tree[at]
    return pose.matrix() if above is None else matrix(tree, above) @ pose.matrix()


def assert_same(pose: Pose | None, expected: Array) -> None:
    assert pose is not None
    assert np.allclose(pose.matrix(), expected, atol=1e-9)


@settings(max_examples=50, deadline=None)
@given(trees(), st.data())
def test_a_pose_in_any_frame_equals_the_matrix_product(tree: Tree, data: st.DataObject) -> None:
    one, other = (data.draw(st.integers(0, len(tree) - 1)) for _ in range(2))
    world = world_of(tree)

    assert_same(map_pose(world, f"thing_{one}"), matrix(tree, one))
    expected = np.linalg.inv(matrix(tree, other)) @ matrix(tree, one)
    assert_same(pose_in(world, f"thing_{one}", f"thing_{other}"), expected)


@settings(max_examples=50, deadline=None)
@given(trees(), st.data())
def test_an_attached_element_keeps_its_map_pose_and_then_moves_with_its_frame(tree: Tree, data: st.DataObject) -> None:
    frame = data.draw(st.integers(0, len(tree) - 2))
    thing, last = f"thing_{len(tree) - 1}", len(tree) - 1
    world = world_of(tree)
    with world.transaction("test", "taken along") as tx:
        attach(tx, thing, f"thing_{frame}")

    assert_same(map_pose(world, thing), matrix(tree, last))
    assert world.objects(thing, "sk:poseFrame") == (f"thing_{frame}",)

    push = data.draw(poses)
    above, pose = tree[frame]
    with world.transaction("test", "the frame moves") as tx:
        write_pose(tx, f"thing_{frame}", pose @ push, None if above is None else f"thing_{above}")
    moved = matrix(tree, frame) @ push.matrix() @ np.linalg.inv(matrix(tree, frame)) @ matrix(tree, last)
    assert_same(map_pose(world, thing), moved)


def test_a_detached_element_keeps_its_map_pose() -> None:
    world = world_of([(None, Pose.of(1, 2, 0, yaw=1.0)), (0, Pose.of(0.5, 0, 0))])
    before = map_pose(world, "thing_1")
    with world.transaction("test", "put down") as tx:
        attach(tx, "thing_1", None)
    with world.transaction("test", "the frame moves on") as tx:
        write_pose(tx, "thing_0", Pose())

    assert before is not None
    assert_same(map_pose(world, "thing_1"), before.matrix())
    assert world.objects("thing_1", "sk:poseFrame") == ()


def test_elements_in_a_frame_of_unknown_pose_have_known_relative_poses() -> None:
    world = world_of([(None, Pose()), (0, Pose.of(1, 0, 0)), (0, Pose.of(0, 2, 0))])
    with world.transaction("test", "lost") as tx:
        write_pose(tx, "thing_0", None)

    assert map_pose(world, "thing_1") is None
    assert_same(pose_in(world, "thing_1", "thing_2"), Pose.of(1, -2, 0).matrix())
    assert_same(pose_in(world, "thing_1", "thing_0"), Pose.of(1, 0, 0).matrix())
    assert pose_in(world, "thing_1", "floor") is None


def test_a_thing_cannot_be_attached_where_its_pose_is_not_known() -> None:
    world = world_of([(None, Pose()), (None, Pose())])

    with (
        pytest.raises(WorldError, match="thing_0 cannot be attached to floor: its pose there is not known"),
        world.transaction("test", "nonsense") as tx,
    ):
        attach(tx, "thing_0", "floor")
    assert world.version == 1


def test_a_frame_cycle_is_refused_in_a_world_and_gives_no_pose_in_an_overlay() -> None:
    world = world_of([(None, Pose()), (0, Pose())])

    with pytest.raises(WorldError, match="has its own frame as sk:poseFrame"), world.transaction("test", "?") as tx:
        write_pose(tx, "thing_0", Pose(), "thing_1")
    supposed = Overlay(world)
    supposed.set_relation("thing_0", "sk:poseFrame", "thing_1")
    assert map_pose(supposed, "thing_0") is None


def test_the_pose_of_an_unknown_element_or_frame_is_refused() -> None:
    world = world_of([(None, Pose()), (None, Pose())])

    with pytest.raises(UnknownName, match="unknown element 'thing_9'"):
        pose_in(world, "thing_9", None)
    with pytest.raises(UnknownName, match="unknown element 'thing_9'"):
        pose_in(world, "thing_0", "thing_9")


def test_a_frame_with_a_sensed_pose_ends_the_frame_chain() -> None:
    one, two, three = Pose((1.0, 0.0, 0.0)), Pose((0.0, 2.0, 0.0)), Pose((0.0, 0.0, 3.0))
    world = world_of([(None, one), (0, two), (1, three)])
    sensed = {"thing_0": Pose((9.0, 0.0, 0.0)), "thing_2": Pose((7.0, 7.0, 7.0))}

    assert pose_on(world, "thing_2", sensed.get) == ("thing_0", Pose((9.0, 2.0, 3.0)))  # its own is not asked for
    assert pose_on(world, "thing_2") == (None, Pose((1.0, 2.0, 3.0)))
    assert pose_on(world, "floor", sensed.get) is None


def test_what_is_placed_on_a_thing_comes_along_when_it_is_moved_whatever_frame_its_pose_is_in() -> None:
    world = World(ONTOLOGY)
    with world.transaction("test", "a table") as tx:
        tx.add("sk:Floor", id="floor")
        for name, below, frame, pose in (
            ("table", "floor", None, Pose((1.0, 0.0, 0.0))),
            ("tray", "table", None, Pose.of(1.2, 0.1, 0.7, yaw=0.3)),
            ("cup", "tray", "tray", Pose((0.1, 0.0, 0.0))),
            ("lid", "cup", None, Pose((1.3, 0.1, 0.8))),
            ("box", "floor", None, Pose((1.5, 0.0, 0.0))),
        ):
            tx.add("sk:Surface", id=name, placement=Placement("sk:on", below))
            write_pose(tx, name, pose, frame)
        tx.add("sk:Object", id="lost", placement=Placement("sk:on", "table"))
    names = ("table", "tray", "cup", "lid", "box")
    before = {name: map_pose(world, name) for name in names}

    with world.transaction("test", "it stands elsewhere") as tx:
        move(tx, "table", Pose.of(1.1, -0.2, 0.0, yaw=0.5))

    by = Pose.of(1.1, -0.2, 0.0, yaw=0.5).matrix() @ np.linalg.inv(Pose((1.0, 0.0, 0.0)).matrix())
    for name in ("table", "tray", "cup", "lid"):
        assert_same(map_pose(world, name), by @ (before[name] or Pose()).matrix())
    assert map_pose(world, "box") == before["box"]
    assert map_pose(world, "lost") is None
    assert world.objects("cup", "sk:poseFrame") == ("tray",)
    with world.transaction("test", "unknown") as tx, pytest.raises(WorldError, match="where it was is not known"):
        move(tx, "lost", Pose())

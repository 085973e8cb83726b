"""A picture for the planner of an arm says where robots were and what they held when it was taken."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pytest

from skiros_primitives.views import depth_view
from skiros_py.geometry import Pose
from skiros_py.motion.voxels import explained
from skiros_py.ports.motion import DepthView, Obstacle
from skiros_py.ports.values import CameraIntrinsics, DepthImage
from skiros_py.skills.context import RunContext
from skiros_py.skills.surroundings import map_pose, obstacles
from skiros_py.station.session import Options, Session
from skiros_py.world import vocabulary as v
from skiros_py.world.poses import write_pose

INTRINSICS = CameraIntrinsics(320, 240, 226.0, 226.0, 159.5, 119.5, 0.05, 2.0)


@pytest.fixture(scope="module")
def context() -> Iterator[RunContext]:
    with Session("kitting", Options(fake=True)) as session:
        session.cycle.step()
        yield session.runtime.context


def view(context: RunContext, around: Sequence[Obstacle] = ()) -> DepthView:
    depth = np.arange(320 * 240, dtype=np.float32).reshape(240, 320)
    image = DepthImage(context.board.snapshot, depth, np.zeros((240, 320, 3), np.uint8), INTRINSICS)
    return depth_view(context, "arm_1", image, "camera_1", around)


def test_the_links_of_a_robot_are_where_it_was_and_nothing_else(context: RunContext) -> None:
    tree = context.frames.at(context.board.snapshot)
    links = [f"panda_link{number}" for number in range(1, 8)] + ["panda_hand", "tcp"]
    places = np.array([pose.position for link in links if (pose := tree.link("arm_1", link)) is not None])

    moving = view(context).moving

    assert len(places) == len(links)
    assert explained(places, moving).all()
    assert not explained(np.add(places[-1:], (0.0, 0.0, -0.15)), moving).any()


def test_parts_that_were_not_seen_yet_explain_what_lies_where_they_were_put(
    context: RunContext, monkeypatch: pytest.MonkeyPatch
) -> None:
    around = obstacles(context, parts=False)
    pallet, empty = (map_pose(context, place) for place in ("pallet_a", "kit_table"))
    assert pallet is not None
    assert empty is not None
    on_pallet, on_table = ((place @ Pose((0.05, 0.05, 0.50))).position for place in (pallet, empty))
    monkeypatch.setattr("skiros_primitives.views._NEAR", 20.0)

    known = view(context, around).known

    higher = np.add((on_pallet, on_table), (0.0, 0.0, 0.25))
    assert explained(np.array([on_pallet]), known).all()
    assert not explained(np.array([on_pallet]), around).any()
    assert not explained(higher, known).any()


def test_the_rays_of_the_smaller_picture_are_rays_of_the_picture(context: RunContext) -> None:
    small = view(context)
    k = small.intrinsics

    assert small.depth.shape == (k.height, k.width) == (120, 160)
    assert small.depth[30, 40] == 60 * 320 + 80
    assert (40 - k.cx) / k.fx == pytest.approx((80 - INTRINSICS.cx) / INTRINSICS.fx)
    assert (30 - k.cy) / k.fy == pytest.approx((60 - INTRINSICS.cy) / INTRINSICS.fy)


def test_what_is_held_moves_with_the_hand(context: RunContext) -> None:
    below = context.frames.at(context.board.snapshot).located("arm_1") @ Pose((0.0, 0.0, 0.2))
    with context.world.transaction(author="test", reason="grasped") as tx:
        tx.place("starter_1", v.HELD_BY, "gripper_1")
        write_pose(tx, "starter_1", Pose((0.0, 0.0, 0.2)), "gripper_1")

    held = [one for one in view(context).moving if one.id == "starter_1"]

    assert [one.pose.position for one in held] == [pytest.approx(below.position)]

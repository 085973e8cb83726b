"""Paths of bases: their poses, and the floor that an outline covers on them."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from skiros_py.geometry import Pose, wrap_angle
from skiros_py.ports.paths import BaseLeg, BasePath, Path, PosePath, placed, swept

OUTLINE = ((-0.3, -0.2), (0.4, -0.2), (0.4, 0.2), (-0.3, 0.2))
START = Pose.of(1.0, 2.0, 0.0, yaw=0.5)
NUMBERS = st.floats(-3.0, 3.0)
LEGS = st.lists(st.builds(BaseLeg, NUMBERS, NUMBERS, st.booleans()), max_size=3).map(tuple)
POSES = st.builds(lambda x, y, yaw: Pose.of(x, y, 0.0, yaw=yaw), NUMBERS, NUMBERS, NUMBERS)
PATHS = st.one_of(st.builds(BasePath, LEGS, NUMBERS), st.builds(PosePath, st.lists(POSES, max_size=3).map(tuple)))


@given(PATHS)
def test_the_poses_of_a_path_follow_all_legs_in_small_steps(path: Path) -> None:
    driven, poses = zip(*path.poses(START, way=0.2, turn=0.1), strict=True)

    assert (driven[0], poses[0]) == (0.0, START)
    assert list(driven) == sorted(driven)
    assert driven[-1] == len(path.legs)
    for here, there in pairwise(poses):
        assert here.distance(there) <= 0.2 + 1e-9
        assert abs(wrap_angle(there.yaw - here.yaw)) <= 0.1 + 1e-9


def test_a_leg_is_a_turn_followed_by_a_straight_forward_or_backward_drive() -> None:
    path = BasePath((BaseLeg(3.0, 2.0), BaseLeg(2.0, 2.0, backwards=True)), math.pi / 2.0)

    found = list(path.poses(START))
    turned = [pose for driven, pose in found if driven == 0.0][-1]
    there = next(pose for driven, pose in found if driven == 2.0)

    assert (turned.position, turned.yaw) == (START.position, pytest.approx(0.0))
    assert (there.position, there.yaw) == ((2.0, 2.0, 0.0), pytest.approx(0.0))
    assert found[-1][1].yaw == pytest.approx(math.pi / 2.0)


def test_the_swept_area_covers_the_outline_everywhere_on_the_path() -> None:
    path = BasePath((BaseLeg(3.0, 4.0),), -2.0)
    area = shapely.buffer(shapely.union_all(swept(OUTLINE, (pose for _, pose in path.poses(START)))), 0.005)

    assert all(area.contains(placed(OUTLINE, pose)) for _, pose in path.poses(START, way=0.03, turn=0.02))


def test_without_an_outline_the_swept_area_is_empty() -> None:
    assert placed((), START).is_empty

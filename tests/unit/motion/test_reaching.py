"""Claims about reach: what an arm reaches from where its base stands, without motions."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from skiros_py.errors import UnknownName
from skiros_py.geometry import Pose, Solid
from skiros_py.motion.pinocchio.arm_motion import ArmMotion
from skiros_py.ports.motion import Obstacle, ReachRequest

HOME = (-1.5708, -0.6, 0.0, -2.4, 0.0, 1.9, 0.7854)


def above(x: float, z: float) -> tuple[tuple[Pose, ...], ...]:
    return tuple((Pose.of(x, 0.0, z, roll=math.pi, yaw=yaw),) for yaw in (0.0, math.pi / 2.0))


def request(*bases: Pose, **changes: Any) -> ReachRequest:
    return replace(ReachRequest("arm", bases, (above(0.7, 0.8), above(0.9, 0.8)), HOME, enough=9), **changes)


def test_what_is_reached_depends_on_where_the_base_stands(motion: ArmMotion) -> None:
    far, near, beyond = motion.reach(request(Pose((-0.1, 0.0, 0.0)), Pose(), Pose((-2.0, 0.0, 0.0))))

    assert far[0] is not None
    assert far[1] is None
    assert near[0] is not None
    assert near[1] is not None
    assert beyond == (None, None)


def test_joints_are_inside_their_limits(motion: ArmMotion) -> None:
    (reached,) = motion.reach(request(Pose()))

    assert all(left is not None and 0.0 <= left <= 1.0 for left in reached)


def test_what_is_inside_something_is_not_reached_unless_it_may_be_touched(motion: ArmMotion) -> None:
    block = Obstacle("block", Solid.box(0.05, 0.05, 0.10), Pose((0.9, 0.0, 0.745)))
    blocked = request(Pose(), obstacles=(block,))

    ((_, refused),) = motion.reach(blocked)
    ((_, touched),) = motion.reach(replace(blocked, touching=frozenset({"block"})))

    assert refused is None
    assert touched is not None


def test_all_poses_of_an_alternative_have_to_be_reached(motion: ArmMotion) -> None:
    (low,), (high,) = above(0.7, 0.8)[:1], above(0.7, 1.6)[:1]

    ((alone, both),) = motion.reach(request(Pose(), targets=((low,), ((*low, *high),))))

    assert alone is not None
    assert both is None


def test_it_stops_after_enough_bases(motion: ArmMotion) -> None:
    there = Pose()

    assert len(motion.reach(request(there, there, there, enough=2))) == 2


def test_an_unknown_arm_is_refused(motion: ArmMotion) -> None:
    with pytest.raises(UnknownName):
        motion.reach(request(Pose(), device="leg"))

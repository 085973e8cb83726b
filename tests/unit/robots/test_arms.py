"""What holds for the arm of each robot: it is free at home, and its reachable poses are solved."""

from __future__ import annotations

from functools import cache

import numpy as np
import pinocchio as pin
import pytest

from skiros_py.devices.arm import ArmSpec
from skiros_py.motion.pinocchio.arm_model import ArmModel, arm_model
from skiros_py.motion.pinocchio.collision import self_collision_pairs
from skiros_py.motion.pinocchio.kinematics import IkSolver
from skiros_py.station.session import Options, Session

SCENES = ("kitting", "kitting_iiwa", "kitting_cell", "kitting_fanuc")
pytestmark = pytest.mark.parametrize("scene", SCENES)


@cache
def arm_of(scene: str) -> ArmModel:
    with Session(scene, Options(fake=True)) as session:
        robot = session.spec.robots[0]
    return arm_model(robot, robot.of(ArmSpec)[0])


def test_links_do_not_touch_each_other_at_home(scene: str) -> None:
    arm = arm_of(scene)
    shapes, pairs = arm.collision_shapes(0.14), self_collision_pairs(arm)
    for first, second in pairs:
        shapes.addCollisionPair(pin.CollisionPair(shapes.getGeometryId(first), shapes.getGeometryId(second)))
    data = shapes.createData()
    for request in data.collisionRequests:
        request.security_margin = 0.005

    assert len(pairs) > 20
    assert not pin.computeCollisions(arm.model, arm.model.createData(), shapes, data, np.array(arm.spec.home), True)


def test_of_1000_reachable_poses_998_are_solved_within_the_joint_limits(scene: str) -> None:
    arm = arm_of(scene)
    rng, solver, home = np.random.default_rng(11), IkSolver(arm), np.array(arm.spec.home)
    solved = 0
    for _ in range(1000):
        target = arm.tip_pose(rng.uniform(arm.lower, arm.upper))
        found = solver.branches(target.homogeneous, home, (arm.lower, arm.upper), rng, count=1)
        for q in found[:1]:
            error = pin.log6(arm.tip_pose(q).actInv(target)).vector
            close = np.linalg.norm(error[:3]) < 2e-4 and np.linalg.norm(error[3:]) < 1e-3
            solved += bool(close) and bool(np.all((arm.lower <= q) & (q <= arm.upper)))

    assert solved >= 998

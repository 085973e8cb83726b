"""Claims about inverse kinematics."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from skiros_py.devices.arm import ArmSpec
from skiros_py.devices.gripper import GripperSpec
from skiros_py.geometry import Array, Pose
from skiros_py.motion.pinocchio.arm_model import ArmModel, arm_model
from skiros_py.motion.pinocchio.kinematics import IkSolver
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.kinematics import write_robot_urdf


@pytest.fixture(scope="module")
def arm(robot: RobotSpec, tmp_path_factory: pytest.TempPathFactory) -> ArmModel:
    directory: Path = tmp_path_factory.mktemp("urdf")
    return ArmModel(write_robot_urdf(robot.model, directory), robot.of(ArmSpec)[0], robot.of(GripperSpec))


def limits(arm: ArmModel) -> tuple[Array, Array]:
    return arm.lower, arm.upper


def test_reachable_poses_are_solved_within_the_joint_limits(arm: ArmModel) -> None:
    rng, solver, solved = np.random.default_rng(11), IkSolver(arm), 0
    for _ in range(1000):
        target = arm.tip_pose(rng.uniform(arm.lower, arm.upper))

        for q in solver.branches(target.homogeneous, np.array(arm.spec.home), limits(arm), rng, count=1):
            error = pin.log6(arm.tip_pose(q).actInv(target)).vector
            close = np.linalg.norm(error[:3]) < 2e-4 and np.linalg.norm(error[3:]) < 1e-3
            solved += close and bool(np.all((arm.lower <= q) & (q <= arm.upper)))
            break

    assert solved >= 995


def test_several_distinct_solutions_are_sorted_by_distance(arm: ArmModel) -> None:
    home = np.array(arm.spec.home)
    target = arm.tip_pose(home + 0.2)

    found = IkSolver(arm).branches(target.homogeneous, home, limits(arm), np.random.default_rng(0), count=6)

    assert len(found) >= 6
    assert all(np.abs(a - b).max() > 0.3 for i, a in enumerate(found) for b in found[:i])
    distances = [float(np.linalg.norm(q - home)) for q in found]
    assert distances == sorted(distances)


def test_an_unreachable_pose_has_no_solution(arm: ArmModel) -> None:
    away, home = pin.SE3(np.eye(3), np.array([3.0, 0.0, 0.5])).homogeneous, np.array(arm.spec.home)

    found = IkSolver(arm).branches(away, home, limits(arm), np.random.default_rng(0), restarts=5)

    assert found == []


ARMS = {
    "mobile_panda": [f"panda_joint{n}" for n in range(1, 8)],
    "mobile_iiwa": [f"lbr_iiwa_joint_{n}" for n in range(1, 8)],
    "ur10e_cell": [
        f"{name}_joint" for name in ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
    ],
}


@pytest.mark.parametrize("model", list(ARMS))
def test_no_pose_that_an_arm_takes_counts_as_surely_out_of_reach(model: str) -> None:
    spec = ArmSpec("arm", tuple(ARMS[model]), "tcp", (0.0,) * len(ARMS[model]))
    arm, rng = arm_model(RobotSpec("robot", model, (spec,)), spec), np.random.default_rng(7)
    range_ = arm.upper - arm.lower

    for posture in rng.uniform(arm.lower - 0.2 * range_, arm.upper + 0.2 * range_, (3000, len(range_))):
        q = np.clip(posture, arm.lower, arm.upper)  # often at limits, where an arm is longest
        assert not arm.is_beyond_reach(arm.tip_pose(q).homogeneous)


def test_a_pose_is_surely_out_of_reach_where_the_wrist_would_be_too_high(arm: ArmModel) -> None:
    straight, leaning = (
        Pose.of(0.5, 0.0, 1.25) @ Pose.of(0.0, 0.0, 0.0, pitch=-tilt) @ Pose.of(0.0, 0.0, 0.0, roll=np.pi)
        for tilt in (0.0, np.pi / 3.0)
    )

    assert np.linalg.norm(np.subtract(straight.position, arm.shoulder)) < arm.reach
    assert arm.is_beyond_reach(straight.matrix())
    assert not arm.is_beyond_reach(leaning.matrix())


def test_the_gripper_links_are_those_that_move_with_the_tip(arm: ArmModel) -> None:
    expected = {"panda_hand", "panda_leftfinger", "panda_rightfinger", "tcp", "camera_optical"}

    assert arm.gripper_links == expected

"""Claims about the search by roboplan: its scene is what a task says, and what it cannot do is searched otherwise."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from skiros_py.devices.arm import ArmSpec
from skiros_py.geometry import Array, Pose, Solid
from skiros_py.motion.pinocchio.arm_motion import ArmMotion
from skiros_py.motion.pinocchio.roboplan import RoboplanRrt
from skiros_py.ports.adapters import GivenPorts, InstalledPorts
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.kinematics import InverseKinematics
from skiros_py.ports.motion import (
    Cone,
    Constraint,
    Held,
    JointMove,
    MotionRequest,
    Obstacle,
    SamplingPlanner,
    SearchTask,
)

LEFT, RIGHT = (-2.3, -0.2, 0.0, -2.2, 0.0, 2.0, 0.7854), (-0.8, -0.2, 0.0, -2.2, 0.0, 2.0, 0.7854)
POST = Obstacle("post", Solid.box(0.06, 0.06, 1.0), Pose((0.75, 0.0, 0.0)))


class Asked:
    """Takes what it is asked for, and finds nothing."""

    name = "asked"
    task: SearchTask

    def search(self, task: SearchTask) -> Sequence[Array] | None:
        self.task = task
        return None


@pytest.fixture(scope="module")
def planner(robot: RobotSpec) -> RoboplanRrt:
    return RoboplanRrt(robot, robot.of(ArmSpec)[0])


def task(
    robot: RobotSpec,
    *obstacles: Obstacle,
    start: tuple[float, ...] = LEFT,
    held: Held | None = None,
    base: Pose | None = None,
    constraints: tuple[Constraint, ...] = (),
) -> SearchTask:
    asked = Asked()
    solver = InstalledPorts((robot,)).port(InverseKinematics, "arm")
    motion = ArmMotion(robot, GivenPorts({InverseKinematics: solver, SamplingPlanner: asked}), reflexes=False)
    request = MotionRequest("arm", start, base or Pose(), ((JointMove(RIGHT),),), obstacles, held, 0.04, seed=2)
    motion.plan(replace(request, constraints=constraints))
    return asked.task


def assert_clear(path: Sequence[Array] | None, task: SearchTask) -> None:
    assert path is not None
    assert np.array_equal(path[0], task.start)
    assert np.array_equal(path[-1], task.goal)
    assert all(task.straight(one, other) for one, other in pairwise(path))


def length(path: Sequence[Array] | None) -> float:
    assert path is not None
    return sum(float(np.linalg.norm(other - one)) for one, other in pairwise(path))


def test_what_stands_there_is_put_in_and_out_of_the_scene(planner: RoboplanRrt, robot: RobotSpec) -> None:
    free, blocked = task(robot), task(robot, POST)
    straight = float(np.linalg.norm(free.goal - free.start))

    paths = [planner.first_path(one) for one in (free, blocked, free, blocked)]

    assert length(paths[0]) == pytest.approx(straight)
    assert length(paths[1]) > straight + 0.01
    assert length(paths[2]) == pytest.approx(straight)
    assert paths[1] is not None
    assert paths[3] is not None
    assert np.array_equal(paths[1], paths[3])
    assert_clear(paths[1], blocked)


def test_what_stands_there_is_seen_from_where_the_base_is(planner: RoboplanRrt, robot: RobotSpec) -> None:
    base = Pose.of(3.0, -2.0, 0.0, yaw=2.0)
    moved = replace(POST, pose=base @ POST.pose)

    here, there = planner.first_path(task(robot, POST)), planner.first_path(task(robot, moved, base=base))

    assert length(there) > float(np.linalg.norm(np.subtract(RIGHT, LEFT))) + 0.01
    assert length(here) > float(np.linalg.norm(np.subtract(RIGHT, LEFT))) + 0.01


def test_what_is_held_is_part_of_the_scene(planner: RoboplanRrt, robot: RobotSpec) -> None:
    """A long rod below the hand, and a low wall over which the empty hand passes."""
    wall = Obstacle("wall", Solid.box(0.5, 0.04, 0.55), Pose((0.7, 0.0, 0.0)))
    rod = Held(Solid.box(0.03, 0.03, 0.35), Pose.of(0.0, 0.0, 0.36, roll=math.pi))
    empty, holding = task(robot, wall), task(robot, wall, held=rod)
    straight = float(np.linalg.norm(empty.goal - empty.start))

    assert length(planner.first_path(empty)) == pytest.approx(straight)
    assert_clear(path := planner.search(holding), holding)
    assert length(path) > straight + 0.1


def test_a_start_that_is_too_near_to_something_is_searched_otherwise(planner: RoboplanRrt, robot: RobotSpec) -> None:
    """The hand stands 2 mm over a block, where it began: it may stay as near, but come no nearer."""
    block = Obstacle("block", Solid.box(0.1, 0.1, 0.1), Pose((0.585, -0.326, 0.764 - 0.102)))
    blocked = task(robot, block, POST)

    assert planner.first_path(blocked) is None
    assert_clear(planner.search(blocked), blocked)


def test_constraints_are_searched_with_otherwise(planner: RoboplanRrt, robot: RobotSpec) -> None:
    down = Cone((0.0, 0.0, 1.0), (0.0, 0.0, -1.0), math.radians(15.0))
    upright = task(robot, POST, constraints=(down,))

    assert_clear(planner.search(upright), upright)

"""Claims about how far an arm keeps away from things, how fast it comes near to them, and how it leaves them."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from skiros_py.devices.arm import ArmSpec
from skiros_py.geometry import Array, Pose, Primitive, Solid
from skiros_py.motion.pinocchio.arm_model import ArmModel, arm_model
from skiros_py.motion.pinocchio.arm_motion import ArmMotion
from skiros_py.motion.pinocchio.collision import CollisionScene
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.motion import JointMove, LineMove, MotionPlan, MotionRequest, NoMotion, Obstacle, PoseMove

LEFT, RIGHT = (-2.3, -0.2, 0.0, -2.2, 0.0, 2.0, 0.7854), (-0.8, -0.2, 0.0, -2.2, 0.0, 2.0, 0.7854)
ERROR = 0.03
PERIOD = 1.0 / 200.0


@pytest.fixture(scope="module")
def arm(robot: RobotSpec) -> ArmModel:
    return arm_model(robot, robot.of(ArmSpec)[0])


def wall(x: float, *, error: float = ERROR) -> Obstacle:
    """A wall in front of the robot, all across the way of its arm."""
    return Obstacle("wall", Solid.box(0.04, 2.0, 2.0), Pose((x + 0.02, 0.0, 0.0)), error)


def furthest(arm: ArmModel) -> float:
    """Returns how far ahead the arm is on its straight way from left to right [m]."""
    way = np.linspace(LEFT, RIGHT, 50)
    ahead = (wall(x, error=0.0) for x in np.arange(0.5, 1.4, 0.01))
    return next(one.pose.position[0] - 0.02 for one in ahead if nearer(arm, one, way, 0.0) == 0)


def nearer(arm: ArmModel, thing: Obstacle, postures: Array, distance: float) -> int:
    """Returns in how many postures the arm is nearer to something than a distance [m]."""
    scene = CollisionScene(arm, (), Pose(), (thing,), None, 0.04)
    return sum(not scene.checker(distance).clear(posture) for posture in postures)


def request(*moves: JointMove | PoseMove | LineMove, around: tuple[Obstacle, ...] = ()) -> MotionRequest:
    return MotionRequest("arm", LEFT, Pose(), (moves,), around, gap=0.04)


def found(answer: MotionPlan | NoMotion) -> MotionPlan:
    assert isinstance(answer, MotionPlan), answer
    return answer


def test_a_free_motion_keeps_away_by_the_error_of_where_a_thing_is(motion: ArmMotion, arm: ArmModel) -> None:
    near = wall(furthest(arm) + 0.01)

    exact = found(motion.plan(request(JointMove(RIGHT), around=(replace(near, error=0.0),))))
    plan = found(motion.plan(request(JointMove(RIGHT), around=(near,))))

    assert nearer(arm, near, exact.legs[0].positions, ERROR) > 0
    assert nearer(arm, near, plan.legs[0].positions, ERROR) == 0
    assert plan.share == 1.0


def test_where_there_is_no_room_it_keeps_away_by_less_and_is_slower(motion: ArmMotion, arm: ArmModel) -> None:
    thing = wall(furthest(arm) + 0.01)
    start = np.linspace(LEFT, RIGHT, 3)[1]
    goal = JointMove((float(start[0]) + 0.05, *start[1:].tolist()))
    blocked = replace(request(goal, around=(thing,)), start=tuple(start.tolist()))

    plan = found(motion.plan(blocked))
    exact = found(motion.plan(replace(blocked, obstacles=(replace(thing, error=0.0),))))

    assert plan.share < 1.0
    assert len(plan.legs[0].positions) > len(exact.legs[0].positions)
    assert ("panda_hand", "wall") in plan.refusals[0].touches


def test_things_with_an_error_may_be_approached_from_above_as_before(motion: ArmMotion, bench: SimpleNamespace) -> None:
    """How high a thing is has no such error: where a part lies, the table is as near as ever."""
    pick = bench.pick("relay", Pose.of(0.75, 0.0, 0.5), 0.5)

    plan = found(motion.plan(replace(pick, obstacles=tuple(replace(one, error=ERROR) for one in pick.obstacles))))

    assert plan.share == 1.0


def test_a_line_may_touch_what_it_ends_at_but_not_what_stands_beside_that_in_one_body(
    motion: ArmMotion, bench: SimpleNamespace
) -> None:
    part = Pose.of(0.75, 0.0, 0.5)
    pick = bench.pick("relay", part, 0.5)
    table = bench.table(0.5)
    board = Primitive("box", (0.2, 0.8, 0.02), Pose((0.0, 0.0, 0.5 + 0.12)))  # a hand's height over the part
    shelf = replace(table, solid=Solid((*table.solid.primitives, board)))
    start = found(motion.plan(pick)).legs[0].positions[-1]
    above, down, _ = pick.routes[0]
    beside = bench.table(0.5, name="shelf")
    assert isinstance(down, LineMove)
    line = replace(down, touching=frozenset({"table", "part"}))
    begun = replace(pick, start=tuple(start.tolist()), routes=((line,),))

    open_ = motion.plan(begun)
    covered = motion.plan(replace(begun, obstacles=(shelf, pick.obstacles[1])))

    assert isinstance(above, PoseMove)
    assert beside.solid == table.solid
    assert isinstance(open_, MotionPlan)
    assert isinstance(covered, NoMotion)
    assert "table" in covered.reason


def test_the_last_stretch_before_a_line_is_slow(motion: ArmMotion, bench: SimpleNamespace, arm: ArmModel) -> None:
    pick = bench.pick("compressor", Pose.of(0.72, 0.12, 0.5, yaw=0.6), 0.5, seed=4)

    aside = (pick.start[0] - 1.2, *pick.start[1:])
    approach = found(motion.plan(replace(pick, start=aside))).legs[0].positions

    tips = np.array([arm.tip_pose(posture).translation for posture in approach])
    speeds = np.linalg.norm(np.diff(tips, axis=0), axis=1) / PERIOD
    last = np.linalg.norm(tips[1:] - tips[-1], axis=1) < 0.18
    assert speeds[last].max() <= 0.27
    assert speeds.max() > 0.4


def test_an_arm_that_seems_to_stick_deep_in_something_may_leave_it_but_not_come_back_into_it(
    motion: ArmMotion, arm: ArmModel
) -> None:
    hand = arm.tip_pose(np.array(LEFT)).translation
    block = Obstacle("block", Solid.box(0.14, 0.14, 0.3), Pose((*hand[:2].tolist(), float(hand[2]) - 0.1)))
    away = tuple(np.add(LEFT, (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)).tolist())

    left = found(motion.plan(request(JointMove(away), around=(block,))))
    back = motion.plan(replace(request(JointMove(LEFT), around=(block,)), start=away))

    assert nearer(arm, block, left.legs[0].positions[:1], -0.03) == 1
    assert nearer(arm, block, left.legs[0].positions[-1:], 0.0) == 0
    assert isinstance(back, NoMotion)


def test_of_several_postures_for_a_look_a_roomy_one_is_taken(motion: ArmMotion, arm: ArmModel) -> None:
    """The elbow may point to either side; a post stands on one of them."""
    tip = arm.tip_pose(np.array(LEFT))
    rotation = Pose.from_matrix(tip.homogeneous)
    free = found(motion.plan(replace(request(PoseMove(rotation)), start=RIGHT)))
    elbow = arm.joint_places(free.legs[0].positions[-1])[3]
    aside = Obstacle("post", Solid.box(0.04, 0.04, 1.6), Pose((float(elbow[0]), float(elbow[1]) - 0.135, 0.0)))

    plan = found(motion.plan(replace(request(PoseMove(rotation), around=(aside,)), start=RIGHT)))

    ends = plan.legs[0].positions[-1:], free.legs[0].positions[-1:]
    assert nearer(arm, aside, ends[1], 0.05) == 1
    assert nearer(arm, aside, ends[0], 0.05) == 0

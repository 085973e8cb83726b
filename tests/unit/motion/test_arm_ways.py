"""Claims about the ways of moving: reflexes, searches by name, constraints, and why a way was not taken."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from skiros_py.devices.arm import ArmSpec
from skiros_py.geometry import Array, Pose, Solid
from skiros_py.motion.pinocchio.arm_model import arm_model, se3
from skiros_py.motion.pinocchio.arm_motion import ArmMotion
from skiros_py.motion.pinocchio.collision import CollisionScene, Fault
from skiros_py.motion.pinocchio.free_moves import KeptPaths
from skiros_py.motion.pinocchio.kinematics import IkSolver, kinematics_of
from skiros_py.motion.pinocchio.lines import Lines
from skiros_py.motion.sampling import Prm, RrtConnect
from skiros_py.ports.adapters import GivenPorts, InstalledPorts
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.kinematics import InverseKinematics
from skiros_py.ports.motion import (
    Cone,
    Held,
    JointMove,
    KeepOut,
    LineMove,
    MotionPlan,
    MotionRequest,
    NoMotion,
    Obstacle,
    PoseMove,
    SamplingPlanner,
)

LEFT, RIGHT = (-2.3, -0.2, 0.0, -2.2, 0.0, 2.0, 0.7854), (-0.8, -0.2, 0.0, -2.2, 0.0, 2.0, 0.7854)
FORWARD = (0.0, 0.3, 0.0, -1.2, 0.0, 1.5, 0.7854)
POST = Obstacle("post", Solid.box(0.06, 0.06, 1.0), Pose((0.75, 0.0, 0.0)))
WALL = Obstacle("wall", Solid.box(0.04, 0.04, 1.0), Pose((0.5, 0.0, 0.0)))


def tip(posture: Array | tuple[float, ...]) -> Pose:
    angles = {f"panda_joint{number}": float(angle) for number, angle in enumerate(posture, start=1)}
    return kinematics_of("mobile_panda").pose("tcp", angles)


def request(
    start: tuple[float, ...], *moves: JointMove | PoseMove | LineMove, obstacles: tuple[Obstacle, ...] = ()
) -> MotionRequest:
    return MotionRequest("arm", start, Pose(), (moves,), obstacles, gap=0.04)


def found(answer: MotionPlan | NoMotion) -> MotionPlan:
    assert isinstance(answer, MotionPlan), answer
    return answer


@pytest.fixture(scope="module")
def fresh(robot: RobotSpec) -> ArmMotion:
    """Without paths kept from other tests."""
    return ArmMotion(robot)


# ---------------------------------------------------------------- reflexes


def test_in_free_space_the_joints_are_interpolated(fresh: ArmMotion) -> None:
    plan = found(fresh.plan(request(LEFT, JointMove(RIGHT))))

    assert plan.planners == ("joint interpolation",)
    assert plan.refusals == ()


def test_where_the_arc_of_the_joints_collides_the_straight_line_of_the_tip_is_taken(fresh: ArmMotion) -> None:
    """The post is outside of the line between both ends, on the arc around the shoulder."""
    plan = found(fresh.plan(request(LEFT, JointMove(RIGHT), obstacles=(POST,))))
    points = np.array([tip(row).position for row in plan.legs[0].positions[::10]])
    way = points[-1] - points[0]
    off = np.cross(points - points[0], way / np.linalg.norm(way))

    assert plan.planners == ("straight line",)
    assert np.linalg.norm(off, axis=1).max() < 0.005
    assert plan.legs[0].positions[-1] == pytest.approx(RIGHT, abs=1e-9)
    assert [(one.planner, one.cause) for one in plan.refusals] == [("joint interpolation", "collision")]
    assert "post" in plan.refusals[0].reason


def test_where_neither_is_possible_it_is_searched_and_the_reasons_of_both_are_kept(fresh: ArmMotion) -> None:
    plan = found(fresh.plan(request(LEFT, JointMove(RIGHT), obstacles=(POST, WALL))))

    assert plan.planners == ("rrt-connect",)
    causes = {one.planner: (one.cause, one.reason) for one in plan.refusals}
    assert causes["joint interpolation"][0] == "collision"
    assert "wall" in causes["straight line"][1]


def line(posture: tuple[float, ...], x: float, y: float, z: float) -> LineMove:
    """A line that moves the tip, without turning it, from where it is."""
    return LineMove(Pose((x, y, z)) @ tip(posture))


class Counted(IkSolver):
    """Counts how often joint angles are looked for."""

    count = 0

    def solve(self, *args: Any, **options: Any) -> Array | None:
        self.count += 1
        return super().solve(*args, **options)


def test_the_postures_of_a_line_are_found_once_however_often_it_is_checked(robot: RobotSpec) -> None:
    arm = arm_model(robot, robot.of(ArmSpec)[0])
    start, goal = np.array(LEFT), line(LEFT, 0.0, 0.1, 0.0).pose
    solver, wall = Counted(arm), Obstacle("wall", Solid.box(1.0, 0.02, 1.0), Pose((0.0, 0.07, 0.0)) @ tip(LEFT))
    wall = replace(wall, pose=Pose((*wall.pose.position[:2], 0.0)))
    checks = [CollisionScene(arm, (), Pose(), some, None, 0.04).checker(0.002) for some in ((), (), (wall,))]
    lines = Lines(arm, solver)

    first = lines.follow(start, se3(goal), checks[0])
    searched = solver.count
    again, stopped = (lines.follow(start, se3(goal), check) for check in checks[1:])

    assert solver.count == searched > 10
    assert not isinstance(first, Fault)
    assert np.array_equal(first, again)
    assert isinstance(stopped, Fault)
    assert "wall" in stopped.reason


def test_lines_of_routes_that_begin_farther_away_than_the_best_one_ends_are_not_followed(robot: RobotSpec) -> None:
    arm = robot.of(ArmSpec)[0]
    counts = []
    for others in ((), (RIGHT,)):
        solver = Counted(arm_model(robot, arm))
        motion = ArmMotion(robot, GivenPorts({InverseKinematics: solver, SamplingPlanner: RrtConnect()}))
        routes = [(JointMove(one), line(one, 0.0, 0.0, 0.1)) for one in (LEFT, *others)]

        plan = found(motion.plan(MotionRequest("arm", LEFT, Pose(), tuple(routes), gap=0.04)))

        assert plan.route == 0
        counts.append(solver.count)

    assert counts[0] == counts[1] > 10


def test_a_line_through_a_singular_posture_is_refused_as_that(fresh: ArmMotion) -> None:
    answer = fresh.plan(request(FORWARD, line(FORWARD, -0.9, 0.0, 0.0)))

    assert isinstance(answer, NoMotion)
    (refusal,) = answer.refusals
    assert (refusal.planner, answer.values) == ("straight line", {"cause": "singularity"})
    assert "mm after its start" in answer.reason


def test_a_line_that_a_joint_limit_ends_names_the_joint(fresh: ArmMotion) -> None:
    answer = fresh.plan(request(FORWARD, line(FORWARD, 0.0, 0.0, -0.9)))

    assert isinstance(answer, NoMotion)
    assert answer.values == {"cause": "limits"}
    assert "panda_joint2 comes to its limit" in answer.reason


def test_a_line_beyond_the_reach_of_the_arm_says_so(fresh: ArmMotion) -> None:
    answer = fresh.plan(request(FORWARD, line(FORWARD, 0.0, 0.0, 0.9)))

    assert isinstance(answer, NoMotion)
    assert answer.values == {"cause": "reach"}
    assert "reaches no further" in answer.reason


def test_joint_angles_beyond_a_limit_are_refused_with_the_joint_and_its_limits(fresh: ArmMotion) -> None:
    ends = fresh.plan(request(LEFT, JointMove((*LEFT[:3], 0.5, *LEFT[4:]))))
    starts = fresh.plan(request((*LEFT[:3], 0.5, *LEFT[4:]), JointMove(LEFT)))

    for answer in (ends, starts):
        assert isinstance(answer, NoMotion)
        assert answer.values == {"cause": "limits"}
        assert "panda_joint4 at 0.500 rad, outside its limits of -3.142 to 0.000 rad" in answer.reason


def test_a_pose_inside_a_wall_is_refused_with_the_name_of_the_wall(fresh: ArmMotion) -> None:
    inside = Pose((*WALL.pose.position[:2], 0.5), (1.0, 0.0, 0.0, 0.0))

    answer = fresh.plan(request(LEFT, PoseMove(inside), obstacles=(WALL,)))

    assert isinstance(answer, NoMotion)
    assert answer.values == {"cause": "collision", "bodies": ["wall"]}
    assert "would touch wall" in answer.reason


def test_why_nothing_is_possible_is_data_for_each_route(fresh: ArmMotion) -> None:
    away, outside = PoseMove(Pose((50.0, 0.0, 0.0))), JointMove((9.0,) * 7)

    answer = fresh.plan(replace(request(LEFT), routes=((away,), (outside,))))

    assert isinstance(answer, NoMotion)
    assert [(one.route, one.move, one.cause) for one in answer.refusals] == [(0, 0, "reach"), (1, 0, "limits")]


# ---------------------------------------------------------------- searches


@pytest.mark.parametrize("name", ["rrt-connect", "prm", "est"])
def test_an_arm_is_searched_for_by_the_planner_that_it_names(robot: RobotSpec, name: str) -> None:
    motion = ArmMotion(replace(robot, adapters=(("arm", (name,)),)))

    plan = found(motion.plan(request(LEFT, JointMove(RIGHT), obstacles=(POST, WALL))))

    assert plan.planners == (name,)


def test_without_a_name_it_is_rrt_connect(robot: RobotSpec) -> None:
    assert InstalledPorts((robot,)).port(SamplingPlanner, "arm").name == "rrt-connect"


def test_the_search_in_python_replaces_that_of_roboplan(robot: RobotSpec) -> None:
    solver = InstalledPorts((robot,)).port(InverseKinematics, "arm")
    motion = ArmMotion(robot, GivenPorts({InverseKinematics: solver, SamplingPlanner: RrtConnect()}))

    plan = found(motion.plan(request(LEFT, JointMove(RIGHT), obstacles=(POST, WALL))))

    assert plan.planners == ("rrt-connect",)


def test_a_searched_path_is_reused_where_it_is_still_clear(robot: RobotSpec) -> None:
    motion = ArmMotion(robot)
    near = tuple(angle + 0.002 for angle in LEFT)
    across = Obstacle("wall", Solid.box(0.5, 0.02, 1.4), Pose((0.75, 0.0, 0.0)))

    first = found(motion.plan(request(LEFT, JointMove(RIGHT), obstacles=(POST, WALL))))
    second = found(motion.plan(replace(request(near, JointMove(RIGHT), obstacles=(POST, WALL)), seed=5)))
    other = motion.plan(request(near, JointMove(RIGHT), obstacles=(POST, across)))

    assert first.planners == ("rrt-connect",)
    assert second.planners == ("kept path",)
    assert second.legs[0].positions[0] == pytest.approx(near)
    assert not (isinstance(other, MotionPlan) and other.planners == ("kept path",))


def test_paths_are_kept_by_both_ends_and_by_what_stands_there() -> None:
    kept, path = KeptPaths(), [np.zeros(2), np.ones(2), np.full(2, 2.0)]
    kept.between(path[0], path[-1], "shelf").append(path)

    assert kept.between(path[0] + 0.01, path[-1] - 0.01, "shelf") == [path]
    assert kept.between(path[0] + 0.2, path[-1], "shelf") == []
    assert kept.between(path[0], path[-1], "table") == []


# ---------------------------------------------------------------- constraints


@pytest.mark.parametrize("search", [False, True])
def test_what_is_held_stays_upright_on_the_whole_way(robot: RobotSpec, fresh: ArmMotion, search: bool) -> None:
    start = tuple(fresh_posture(robot, Pose.of(0.45, -0.45, 0.75, roll=math.pi)))
    goal = Pose.of(0.45, 0.45, 0.75, roll=math.pi, yaw=1.0)
    upright = Cone.upright(tip(start), math.radians(12.0))
    motion = ArmMotion(robot, reflexes=False) if search else fresh
    asked = replace(request(start, PoseMove(goal)), constraints=(upright,))

    plan = found(motion.plan(asked))
    tilts = [tilt(tip(row)) for row in plan.legs[0].positions[::5]]

    assert max(tilts) <= math.radians(12.5)
    assert (plan.planners == ("rrt-connect",)) == search


def test_a_goal_that_breaks_a_constraint_is_refused_with_the_angle(fresh: ArmMotion) -> None:
    tilted = tuple(np.add(LEFT, (0.0, 0.0, 0.0, 0.0, 0.0, 0.6, 0.0)))

    answer = fresh.plan(replace(request(LEFT, JointMove(tilted)), constraints=(Cone.upright(tip(LEFT), 0.2),)))

    assert isinstance(answer, NoMotion)
    assert "34 deg, of 11" in answer.reason
    assert {one.cause for one in answer.refusals} == {"constraint"}


def test_a_keep_out_volume_is_not_entered_even_by_a_line_that_may_touch(fresh: ArmMotion) -> None:
    start, (x, y, z) = tip(LEFT), tip(LEFT).position
    down = LineMove(Pose((x, y, z - 0.15), start.orientation), touching=frozenset({"volume"}))
    box = Solid.box(0.3, 0.3, 0.045)
    below = Pose((x, y, z - 0.15))

    touching = fresh.plan(request(LEFT, down, obstacles=(Obstacle("volume", box, below),)))
    kept_out = fresh.plan(replace(request(LEFT, down), constraints=(KeepOut("volume", box, below),)))

    assert isinstance(touching, MotionPlan)
    assert isinstance(kept_out, NoMotion)
    assert "would enter volume" in kept_out.reason
    assert kept_out.refusals[0].cause == "constraint"


def test_a_free_motion_goes_around_a_keep_out_volume(fresh: ArmMotion) -> None:
    volume = KeepOut("volume", POST.solid, POST.pose)

    plan = found(fresh.plan(replace(request(LEFT, JointMove(RIGHT)), constraints=(volume,))))

    assert plan.planners != ("joint interpolation",)
    assert plan.refusals[0].cause == "constraint"


# ---------------------------------------------------------------- limits


def test_joints_accelerate_as_the_description_of_the_arm_says(robot: RobotSpec) -> None:
    arm = robot.of(ArmSpec)[0]
    others = tuple(device for device in robot.devices if device is not arm)
    slow = replace(robot, devices=(*others, replace(arm, accelerations=(1.0,) * 7)))

    plan = found(ArmMotion(slow).plan(request(LEFT, JointMove(RIGHT))))
    rates = np.abs(np.diff(plan.legs[0].velocities, axis=0)) * 200.0

    assert 0.7 < rates.max() <= 1.05


def test_with_a_load_joints_accelerate_as_before_however_strong_they_are(robot: RobotSpec) -> None:
    arm = robot.of(ArmSpec)[0]
    others = tuple(device for device in robot.devices if device is not arm)
    motion = ArmMotion(replace(robot, devices=(*others, replace(arm, accelerations=(20.0,) * 7))))
    held = Held(Solid.box(0.05, 0.05, 0.05), Pose.of(0.0, 0.0, 0.03, roll=math.pi))
    empty = request(LEFT, JointMove((*LEFT[:5], 2.6, 1.5)))

    rates = [
        float(np.abs(np.diff(found(motion.plan(one)).legs[0].velocities, axis=0)).max() * 200.0)
        for one in (empty, replace(empty, held=held))
    ]

    assert rates[0] > 8.0
    assert rates[1] <= 7.6


def test_an_arm_of_unknown_accelerations_has_those_of_a_weak_joint(robot: RobotSpec) -> None:
    arm = robot.of(ArmSpec)[0]

    assert arm_model(robot, arm).acceleration == pytest.approx(np.full(7, 7.5))


def fresh_posture(robot: RobotSpec, pose: Pose) -> Array:
    """Returns a posture whose tip is at a pose."""
    arm = robot.of(ArmSpec)[0]
    model, rng = arm_model(robot, arm), np.random.default_rng(0)
    solver = InstalledPorts((robot,)).port(InverseKinematics, "arm")
    return solver.branches(pose.matrix(), np.array(arm.home), (model.lower, model.upper), rng, count=1)[0]


def tilt(pose: Pose) -> float:
    """Returns the angle between the tool and straight down [rad]."""
    return math.acos(min(1.0, -float(pose.matrix()[2, 2])))


def test_a_planner_may_be_given_by_the_caller(robot: RobotSpec) -> None:
    solver = InstalledPorts((robot,)).port(InverseKinematics, "arm")
    motion = ArmMotion(robot, GivenPorts({InverseKinematics: solver, SamplingPlanner: Prm()}), reflexes=False)

    assert found(motion.plan(request(LEFT, JointMove(RIGHT)))).planners == ("prm",)

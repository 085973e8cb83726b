"""Claims about whole arm motions: what is found, what is refused, and that what is found is safe."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from skiros_py.errors import UnknownName
from skiros_py.geometry import Pose, Solid
from skiros_py.motion.pinocchio.arm_motion import ArmMotion
from skiros_py.motion.pinocchio.kinematics import kinematics_of
from skiros_py.ports.motion import Held, JointMove, LineMove, MotionPlan, NoMotion, Obstacle, PoseMove


def found(answer: MotionPlan | NoMotion) -> MotionPlan:
    assert isinstance(answer, MotionPlan), answer
    return answer


def link(positions: Sequence[float], name: str) -> Pose:
    """Returns the pose of a link in the frame of the base."""
    angles = {f"panda_joint{number}": float(angle) for number, angle in enumerate(positions, start=1)}
    return kinematics_of("mobile_panda").pose(name, angles)


def refused(answer: MotionPlan | NoMotion) -> str:
    assert isinstance(answer, NoMotion)
    return answer.reason


@pytest.mark.parametrize("height", [0.45, 0.50, 0.60])
def test_parts_anywhere_on_a_table_can_be_grasped_in_both_orientations(
    motion: ArmMotion, bench: SimpleNamespace, height: float
) -> None:
    rng, misses = np.random.default_rng(int(1000 * height)), []
    for k in range(10):
        name, pose = list(bench.PARTS)[k % 4], bench.random_part(rng, height)
        for yaw in (0.0, math.pi):
            answer = motion.plan(bench.pick(name, pose, height, yaws=(yaw,), seed=k))
            if isinstance(answer, NoMotion):
                misses.append((name, pose, yaw, answer.reason))

    assert misses == []


@pytest.mark.parametrize("part", ["starter", "alternator", "compressor"])
def test_every_compartment_of_a_kit_can_be_filled_on_a_table_and_on_the_deck(
    motion: ArmMotion, bench: SimpleNamespace, part: str
) -> None:
    on_table, on_deck = Pose((bench.EDGE + 0.2, 0.0, 0.5)), Pose((-0.27, 0.0, 0.35))
    for at, others in ((on_table, (bench.table(0.5),)), (on_deck, ())):
        for compartment in bench.compartments(at):
            plan = found(motion.plan(bench.place(part, compartment, (bench.kit(at), *others))))
            assert bench.seconds(plan) < 8.0


def test_the_camera_can_look_straight_down_on_every_compartment(motion: ArmMotion, bench: SimpleNamespace) -> None:
    at = Pose((-0.27, 0.0, 0.35))
    camera = link(bench.HOME, "tcp").inverse() @ link(bench.HOME, "camera_optical")
    for compartment in bench.compartments(at):
        for height in (0.34, 0.40, 0.46):
            shots = [compartment @ bench.down(0, 0, height, k * math.pi / 2) for k in range(4)]
            routes = tuple((PoseMove(shot @ camera.inverse()),) for shot in shots)
            request = replace(bench.place("starter", compartment, (bench.kit(at),)), routes=routes)

            plan = found(motion.plan(request))

            seen = link(plan.legs[-1].positions[-1], "camera_optical")
            assert seen.distance(shots[plan.route]) < 2e-4


def test_trajectories_follow_the_route_in_limits_and_lines_are_straight(
    motion: ArmMotion, bench: SimpleNamespace
) -> None:
    request = bench.pick("starter", Pose.of(0.75, 0.1, 0.5, yaw=0.7), 0.5)

    plan = found(motion.plan(request))

    joined = np.vstack([leg.positions for leg in plan.legs])
    assert np.array_equal(joined[0], bench.HOME)
    for leg, after in zip(plan.legs, plan.legs[1:], strict=False):
        assert np.array_equal(leg.positions[-1], after.positions[0])
    assert np.abs(np.diff(joined, axis=0)).max() <= 2.61 / 200.0
    for move, leg in zip(request.routes[plan.route], plan.legs, strict=True):
        tips = [link(q, "tcp") for q in leg.positions]
        assert tips[-1].distance(move.pose) < 2e-4
        if isinstance(move, LineMove):
            points = np.array([tip.position for tip in tips])
            way = points[-1] - points[0]
            off = np.cross(points - points[0], way / np.linalg.norm(way))
            assert np.linalg.norm(off, axis=1).max() < 1e-3
            assert (np.linalg.norm(np.diff(points, axis=0), axis=1) * 200.0).max() <= move.speed + 1e-4
            turns = [2 * math.acos(min(1.0, abs(np.dot(tip.orientation, tips[0].orientation)))) for tip in tips]
            assert max(turns) < 2e-3


def test_a_higher_speed_fraction_is_faster(motion: ArmMotion, bench: SimpleNamespace) -> None:
    there = (-0.5, *bench.HOME[1:])
    request = replace(bench.pick("relay", Pose.of(0.7, 0.0, 0.5), 0.5), routes=((JointMove(there),),))

    times = [bench.seconds(found(motion.plan(replace(request, speed=share)))) for share in (0.3, 1.0)]

    assert times[0] > 1.5 * times[1]


def test_the_same_request_gives_the_same_motion(motion: ArmMotion, bench: SimpleNamespace) -> None:
    pose = Pose.of(0.7, -0.1, 0.6, yaw=1.0)
    posts = tuple(Obstacle(f"post{y}", Solid.box(0.05, 0.05, 1.2), Pose((0.42, y, 0.0))) for y in (-0.35, 0.35))
    request = bench.pick("alternator", pose, 0.6)
    request = replace(request, obstacles=(*request.obstacles, *posts), seed=5)

    first, second = found(motion.plan(request)), found(motion.plan(request))

    assert first.route == second.route
    for one, other in zip(first.legs, second.legs, strict=True):
        assert np.array_equal(one.positions, other.positions)


def test_an_obstacle_on_the_straight_path_is_avoided(motion: ArmMotion, bench: SimpleNamespace) -> None:
    left, right = (-2.3, -0.2, 0.0, -2.2, 0.0, 2.0, 0.7854), (-0.8, -0.2, 0.0, -2.2, 0.0, 2.0, 0.7854)
    post = Obstacle("post", Solid.box(0.06, 0.06, 1.0), Pose((0.75, 0.0, 0.0)))
    request = replace(bench.pick("relay", Pose((0.7, 0, 0.5)), 0.5), start=left, routes=((JointMove(right),),))

    free = found(motion.plan(replace(request, obstacles=())))
    around = found(motion.plan(replace(request, obstacles=(post,))))

    assert np.ptp(free.legs[0].positions[:, 3]) == 0.0  # straight: the elbow keeps its angle
    assert bench.seconds(around) > bench.seconds(free)
    assert np.allclose(around.legs[0].positions[-1], right)


def test_the_nearer_of_two_routes_is_taken(motion: ArmMotion, bench: SimpleNamespace) -> None:
    near, far = list(bench.HOME), list(bench.HOME)
    near[0] += 0.3
    far[0] += 2.0
    request = replace(
        bench.pick("relay", Pose((0.7, 0, 0.5)), 0.5), routes=((JointMove(tuple(far)),), (JointMove(tuple(near)),))
    )

    assert found(motion.plan(request)).route == 1


def test_a_distant_pose_is_reported_as_out_of_reach(motion: ArmMotion, bench: SimpleNamespace) -> None:
    request = replace(bench.pick("relay", Pose((2.5, 0.0, 0.5)), 0.5), obstacles=())

    answer = motion.plan(request)
    reason = refused(answer)

    assert "out of reach" in reason
    assert isinstance(answer, NoMotion)
    assert answer.values == {"cause": "reach"}
    assert "move 1 (to a pose)" in reason


def test_a_straight_motion_that_would_collide_is_refused_and_names_the_obstacle(
    motion: ArmMotion, bench: SimpleNamespace
) -> None:
    request = bench.pick("relay", Pose.of(0.7, 0.0, 0.5), 0.5)
    pose = Pose.of(0.7, 0.0, 0.44)
    through = bench.grasp(pose, 0.032, 0.0, frozenset({"part"}))

    reason = refused(motion.plan(replace(request, routes=(through,), obstacles=request.obstacles[:1])))

    assert "move 2 (straight line)" in reason
    assert "touch table" in reason


def test_only_gripper_and_held_part_may_touch(motion: ArmMotion, bench: SimpleNamespace) -> None:
    wall = Obstacle("wall", Solid.box(0.02, 1.0, 1.2), Pose((0.40, 0.0, 0.0)))  # between arm and table
    request = bench.pick("relay", Pose.of(0.7, 0.0, 0.5), 0.5)
    route = bench.grasp(Pose.of(0.7, 0.0, 0.5), 0.032, 0.0, frozenset({"part", "table", "wall"}))

    reason = refused(motion.plan(replace(request, routes=(route,), obstacles=(*request.obstacles, wall))))

    assert "touch wall" in reason


def test_the_held_part_is_kept_clear_of_obstacles(motion: ArmMotion, bench: SimpleNamespace) -> None:
    request = bench.pick("relay", Pose.of(0.7, 0.0, 0.5), 0.5)
    over = (PoseMove(bench.down(0.7, 0.0, 0.58, 0.0)),)
    empty = replace(request, routes=(over,), obstacles=request.obstacles[:1], gap=0.04)
    holding = replace(empty, held=Held(Solid.box(0.05, 0.04, 0.2), Pose.of(0, 0, 0.15, roll=math.pi)))

    found(motion.plan(empty))
    assert "what it holds would touch table" in refused(motion.plan(holding))


def test_unknown_ids_in_the_allowed_contacts_are_ignored(motion: ArmMotion, bench: SimpleNamespace) -> None:
    request = bench.pick("relay", Pose.of(0.7, 0.0, 0.5), 0.5)
    route = bench.grasp(Pose.of(0.7, 0.0, 0.5), 0.032, 0.0, frozenset({"part", "table", "nobody"}))

    found(motion.plan(replace(request, routes=(route,))))


def test_the_base_pose_is_taken_into_account(motion: ArmMotion, bench: SimpleNamespace) -> None:
    base, part = Pose.of(3.0, -2.0, 0.0, yaw=2.0), Pose.of(0.7, 0.0, 0.5)
    request = bench.pick("relay", part, 0.5)
    moved = tuple(replace(o, pose=base @ o.pose) for o in request.obstacles)
    routes = tuple(tuple(replace(m, pose=base @ m.pose) for m in route) for route in request.routes)

    here = found(motion.plan(request))
    there = found(motion.plan(replace(request, base=base, obstacles=moved, routes=routes)))

    tips = [link(p.legs[1].positions[-1], "tcp") for p in (here, there)]
    assert tips[0].distance(tips[1]) < 4e-4


def test_a_motion_may_start_where_localisation_error_lets_it_touch(motion: ArmMotion, bench: SimpleNamespace) -> None:
    grasped = found(motion.plan(bench.pick("relay", Pose.of(0.7, 0.0, 0.5), 0.5)))
    low = tuple(grasped.legs[1].positions[-1])  # the gripper is around the part, its fingers near the table
    raised = bench.table(0.512)  # ... which stands higher than believed, by more than the gap below the fingers
    home = replace(bench.pick("relay", Pose.of(0.7, 0.0, 0.5), 0.5), start=low, obstacles=(raised,))

    up = LineMove(bench.down(0.7, 0.0, 0.65, math.pi * grasped.route), 0.2)

    found(motion.plan(replace(home, routes=((up, JointMove(bench.HOME)),))))


def test_unknown_arms_are_faults(motion: ArmMotion, bench: SimpleNamespace) -> None:
    with pytest.raises(UnknownName, match="arm"):
        motion.plan(replace(bench.pick("relay", Pose.of(0.7, 0.0, 0.5), 0.5), device="leg"))

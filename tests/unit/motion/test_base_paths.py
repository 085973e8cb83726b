"""Claims about base paths: nothing is touched on the way, docks are left backwards and entered straight ahead."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from skiros_py.geometry import Pose, Primitive, Solid, wrap_angle
from skiros_py.motion.adapters import WorkerPlanner, base_paths
from skiros_py.motion.base_paths import BasePaths
from skiros_py.ports.motion import BasePathRequest, BasePlanner, NoMotion, Obstacle
from skiros_py.ports.paths import BasePath, Layer, floor_area, placed

FOOTPRINT = ((-0.50, -0.28), (0.32, -0.28), (0.32, 0.28), (-0.50, 0.28))
HALF_TABLE, DOCK = 0.30, 0.30 + 0.26 + 0.22  # middle of the table to the base docked at it [m]


def poses_on(path: BasePath, start: Pose) -> Iterator[Pose]:
    """Drives a path in small steps: turn, drive, ..., turn."""
    return (pose for _, pose in path.poses(start, way=0.02, turn=0.05))


def overlap(pose: Pose, obstacles: tuple[Obstacle, ...]) -> float:
    """Returns the area [m²] that the base and the obstacles' corners-by-corners outlines share."""
    base = shapely.Polygon([pose.apply(np.array((x, y, 0.0)))[:2] for x, y in FOOTPRINT])
    return sum(float(shapely.intersection(base, outline(o)).area) for o in obstacles)


def outline(obstacle: Obstacle) -> shapely.Polygon:
    (block,) = obstacle.solid.primitives
    x, y = block.size[0] / 2, block.size[1] / 2
    corners = np.array([(-x, -y, 0.0), (x, -y, 0.0), (x, y, 0.0), (-x, y, 0.0)])
    return shapely.Polygon(obstacle.pose.apply(corners)[:, :2])


def table(name: str, x: float, y: float, yaw: float) -> Obstacle:
    return Obstacle(name, Solid.box(2 * HALF_TABLE, 0.8, 0.5), Pose.of(x, y, 0.0, yaw=yaw))


def dock(at: Obstacle) -> Pose:
    return at.pose @ Pose((-DOCK, 0.0, 0.0))


def planned(start: Pose, goal: Pose, *obstacles: Obstacle) -> BasePath | NoMotion:
    return BasePaths().plan(BasePathRequest(start, goal, (Layer(FOOTPRINT),), obstacles))


def path_of(answer: BasePath | NoMotion) -> BasePath:
    assert isinstance(answer, BasePath), answer
    return answer


@st.composite
def halls(draw: st.DrawFn) -> tuple[Obstacle, ...]:
    rng = np.random.default_rng(draw(st.integers(0, 100_000)))
    tables = (table("from", 0.0, 0.0, rng.uniform(-3, 3)), table("to", 5.0, 1.0, rng.uniform(-3, 3)))
    boxes = [
        Obstacle(
            f"box_{k}",
            Solid.box(*rng.uniform(0.2, 0.8, 2), 1.0),
            Pose.of(rng.uniform(-2, 7), rng.uniform(-3, 4), 0, yaw=rng.uniform(-3, 3)),
        )
        for k in range(draw(st.integers(0, 5)))
    ]
    return (*tables, *boxes)


@settings(max_examples=25, deadline=None)
@given(halls())
def test_the_base_arrives_without_touching_anything(obstacles: tuple[Obstacle, ...]) -> None:
    start, goal = dock(obstacles[0]), dock(obstacles[1])
    assume(overlap(start, obstacles) == 0.0)
    answer = planned(start, goal, *obstacles)
    assume(isinstance(answer, BasePath))

    driven = list(poses_on(path_of(answer), start))

    assert max(overlap(pose, obstacles) for pose in driven) == 0.0
    assert driven[-1].distance(goal) < 1e-6
    assert abs(wrap_angle(driven[-1].yaw - goal.yaw)) < 1e-6


def test_a_path_is_found_in_most_random_halls() -> None:
    rng, ways = np.random.default_rng(0), 0
    for _ in range(20):
        boxes = [
            Obstacle(f"b{k}", Solid.box(0.4, 0.4, 1.0), Pose((rng.uniform(2.2, 2.8), rng.uniform(-3, 3), 0.0)))
            for k in range(4)
        ]
        start, goal = table("from", 0.0, 0.0, math.pi), table("to", 5.0, 0.0, 0.0)
        ways += isinstance(planned(dock(start), dock(goal), start, goal, *boxes), BasePath)

    assert ways >= 18


def test_a_dock_is_left_backwards_and_entered_straight_ahead() -> None:
    first, second = table("first", 2.0, 0.0, 0.0), table("second", 0.0, 3.0, math.pi / 2)

    path = path_of(planned(dock(first), dock(second), first, second))

    poses = list(poses_on(path, dock(first)))
    leaving = [pose for pose in poses if first.pose.distance(pose) < DOCK + 0.15]
    assert leaving[-1].position[0] < dock(first).position[0] - 0.1
    assert all(pose.position[1] == pytest.approx(0.0, abs=1e-3) for pose in leaving)
    assert all(pose.yaw == pytest.approx(0.0, abs=1e-3) for pose in leaving)
    straight = [pose for pose in poses if pose.distance(dock(second)) <= 0.2]
    assert all(pose.yaw == pytest.approx(math.pi / 2, abs=1e-3) for pose in straight)


def test_the_path_in_open_space_is_short() -> None:
    path = path_of(planned(Pose(), Pose.of(3.0, 0.0, 0.0)))

    assert [(leg.x, leg.y) for leg in path.legs][-1] == pytest.approx((3.0, 0.0))
    assert all(abs(leg.y) < 1e-9 for leg in path.legs)


def test_the_path_around_a_wall_has_few_turns() -> None:
    wall = Obstacle("wall", Solid.box(0.2, 3.0, 1.0), Pose((2.0, 0.0, 0.0)))

    path = path_of(planned(Pose(), Pose.of(4.0, 0.0, 0.0), wall))

    length = sum(a.distance(b) for a, b in pairwise(poses_on(path, Pose())))
    assert len(path.legs) <= 2
    assert length < 1.25 * 2 * math.hypot(2.0, 1.5 + 0.65)  # wide corners are driven faster


def test_corners_are_rounded_so_that_the_base_need_not_stop() -> None:
    wall = Obstacle("wall", Solid.box(0.2, 3.0, 1.0), Pose((2.0, 1.5, 0.0)))

    path = path_of(planned(Pose(), Pose.of(4.0, 0.0, 0.0), wall))

    poses = list(poses_on(path, Pose()))
    turning = [abs(wrap_angle(b.yaw - a.yaw)) for a, b in pairwise(poses) if b.distance(a) > 0.001]
    assert len(path.legs) == 1
    assert max(turning) < 0.06


def test_what_sticks_out_above_the_floor_is_kept_from_what_is_as_high() -> None:
    arm = Layer(((0.3, -0.1), (0.7, -0.1), (0.7, 0.1), (0.3, 0.1)), bottom=0.8, top=1.2)
    low, high = (Obstacle("bench", Solid.box(0.5, 0.5, top), Pose((1.0, 0.0, 0.0))) for top in (0.7, 0.9))
    start, goal = Pose((-1.0, 0.0, 0.0)), Pose((0.3, 0.0, 0.0))

    answers = [BasePaths().plan(BasePathRequest(start, goal, (Layer(FOOTPRINT), arm), (o,))) for o in (low, high)]

    assert isinstance(answers[0], BasePath)
    assert isinstance(answers[1], NoMotion)
    assert "touch bench" in answers[1].reason


@pytest.mark.parametrize(("length", "yaw"), [(0.2, 0.0), (0.8, 0.4), (1.5, -0.7)])
def test_a_passage_that_is_0_1_m_wider_than_the_base_is_driven_straight(length: float, yaw: float) -> None:
    middle, side = Pose.of(2.5, 0.4, 0.0, yaw=yaw), 4.0
    walls = tuple(
        Obstacle(f"wall_{k}", Solid.box(length, side, 1.0), middle @ Pose((0.0, sign * (0.33 + side / 2.0), 0.0)))
        for k, sign in enumerate((-1.0, 1.0))
    )
    start, goal = Pose(), Pose.of(5.0, 0.5, 0.0, yaw=0.5)

    path = path_of(planned(start, goal, *walls))

    driven = list(poses_on(path, start))
    room = min(placed(FOOTPRINT, pose).distance(floor_area(o.solid, o.pose)) for pose in driven for o in walls)
    assert room > 0.04
    assert max(pose.distance(Pose()) for pose in driven) < 6.0


def test_a_base_at_its_goal_does_not_move() -> None:
    path = path_of(planned(Pose(), Pose.of(0.003, 0.0, 0.0, yaw=math.radians(0.3))))

    assert path.legs == ()


def test_a_goal_inside_an_obstacle_is_refused_and_names_the_obstacle() -> None:
    answer = planned(Pose(), Pose.of(2.0, 0.0, 0.0), table("bench", 2.2, 0.0, 0.0))

    assert isinstance(answer, NoMotion)
    assert "touch bench" in answer.reason
    assert answer.values == {"cause": "collision"}


def test_several_obstacles_with_one_name_are_all_avoided() -> None:
    """A robot has one for its base and one for its arm."""
    body, arm = (Obstacle("robot_2", Solid.box(0.6, 0.6, 1.0), Pose((x, 0.0, 0.0))) for x in (2.0, 5.0))
    start, goal = Pose(), Pose((3.5, 0.0, 0.0))

    path = path_of(planned(start, goal, body, arm))

    assert max(overlap(pose, (body, arm)) for pose in poses_on(path, start)) == 0.0


def test_a_goal_behind_walls_is_refused() -> None:
    ring = [
        Obstacle(f"wall{k}", Solid.box(0.1, 5.2, 1.0), Pose.of(5 + 2.5 * math.cos(a), 2.5 * math.sin(a), 0, yaw=a))
        for k, a in enumerate(np.arange(4) * math.pi / 2)
    ]

    answer = planned(Pose(), Pose.of(5.0, 0.0, 0.0), *ring)

    assert isinstance(answer, NoMotion)
    assert "no way" in answer.reason


def test_the_obstacle_before_a_dock_is_named_and_not_what_the_base_docks_at() -> None:
    bench, crate = table("bench", 4.0, 0.0, 0.0), Obstacle("crate", Solid.box(0.3, 0.3, 0.5), Pose((2.2, 0.0, 0.0)))

    answer = planned(Pose(), dock(bench), bench, crate)

    assert isinstance(answer, NoMotion)
    assert "crate is in the way" in answer.reason
    assert "bench" not in answer.reason


def test_the_single_obstacle_that_closes_a_way_is_named() -> None:
    walls = [
        Obstacle(f"wall{k}", Solid.box(0.2, 6.0, 1.0), Pose((2.0, sign * 3.8, 0.0))) for k, sign in enumerate((-1, 1))
    ]
    ends = [
        Obstacle(f"end{k}", Solid.box(12.0, 0.2, 1.0), Pose((2.0, sign * 6.9, 0.0))) for k, sign in enumerate((-1, 1))
    ]
    back = [Obstacle(f"back{k}", Solid.box(0.2, 14.0, 1.0), Pose((x, 0.0, 0.0))) for k, x in enumerate((-4.0, 8.0))]
    post = Obstacle("post", Solid.box(0.2, 0.9, 1.0), Pose((2.0, 0.0, 0.0)))

    answer = planned(Pose(), Pose((4.5, 0.0, 0.0)), *walls, *ends, *back, post)

    assert isinstance(answer, NoMotion)
    assert "without post or" in answer.reason


def test_an_enclosed_base_is_refused_with_the_blocking_obstacles() -> None:
    boxes = [Obstacle(n, Solid.box(0.3, 1.0, 1.0), Pose((x, 0.0, 0.0))) for n, x in (("ahead", 0.6), ("behind", -0.75))]

    answer = planned(Pose(), Pose.of(3.0, 0.0, 0.0), *boxes)

    assert isinstance(answer, NoMotion)
    assert "cannot leave" in answer.reason
    assert "behind" in answer.reason or "ahead" in answer.reason


def test_a_thing_overhead_covers_no_floor_and_a_lying_cylinder_covers_its_length() -> None:
    lamp = Obstacle("lamp", Solid.box(1.0, 1.0, 0.1), Pose((0.0, 0.0, 1.7)))
    roll = Solid((Primitive("cylinder", (0.1, 1.0), Pose.of(0, 0, 0.1, pitch=math.pi / 2)),))

    assert floor_area(lamp.solid, lamp.pose).is_empty
    expected = (2.0 - 0.5, 3.0 - 0.1, 2.0 + 0.5, 3.0 + 0.1)
    assert floor_area(roll, Pose((2.0, 3.0, 0.0))).bounds == pytest.approx(expected, abs=0.002)


def test_the_port_answers_from_a_worker_with_its_latency() -> None:
    planner = WorkerPlanner("base paths", base_paths, latency=0.02)
    port: BasePlanner = planner
    try:
        call = port.plan(BasePathRequest(Pose(), Pose.of(2.0, 0.0, 0.0), (Layer(FOOTPRINT),), ()))

        assert call.latency == 0.02
        assert isinstance(call.result(), BasePath)
    finally:
        planner.close()


def test_equal_path_requests_give_equal_paths(bench: SimpleNamespace) -> None:
    start, goal = Pose(), Pose.of(2.0, 1.0, 0.0, yaw=1.0)

    assert planned(start, goal, bench.table(0.5, "t", Pose((1.0, 0.0, 0.0)))) == planned(
        start, goal, bench.table(0.5, "t", Pose((1.0, 0.0, 0.0)))
    )

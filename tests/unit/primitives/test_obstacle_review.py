"""Believed obstacles that a picture sees through are forgotten; what it shows stays."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest

from skiros_primitives.contact import believe_obstacle
from skiros_primitives.obstacle_review import review_obstacles, views_of
from skiros_py.geometry import Pose, Solid
from skiros_py.ports.motion import DepthView, Obstacle
from skiros_py.ports.values import CameraIntrinsics
from skiros_py.skills.context import RunContext
from skiros_py.skills.surroundings import obstacles, solid_of
from skiros_py.station.session import Options, Session
from skiros_py.world import vocabulary as v

CAMERA = CameraIntrinsics(160, 120, 113.0, 113.0, 79.5, 59.5, 0.05, 2.0)
FLOOR, HIGH = 0.0, 1.0
AT = Pose((8.0, 8.0, 0.3))
"""Where an obstacle of 0.1 m is believed to be; the camera is straight above."""


@pytest.fixture
def context() -> Iterator[RunContext]:
    with Session("kitting", Options(fake=True)) as session:
        session.cycle.step()
        yield session.runtime.context


def picture(context: RunContext, depth: np.ndarray, *others: Obstacle) -> DepthView:
    camera, known = Pose.of(*AT.position[:2], HIGH, roll=math.pi), (*obstacles(context, parts=True), *others)
    return DepthView("arm_1", depth.astype(np.float32), CAMERA, camera, 0.0, known)


def flat(depth: float = HIGH - FLOOR) -> np.ndarray:
    return np.full((CAMERA.height, CAMERA.width), depth)


def believed(context: RunContext) -> str:
    return believe_obstacle(context.world, "test", AT, (0.1, 0.1, 0.1), "met")


def test_what_a_picture_sees_through_is_forgotten(context: RunContext) -> None:
    believed(context)

    review_obstacles(context, "look", picture(context, flat()))

    assert not context.world.instances(v.OBSTACLE)
    assert context.world.changes_since(context.world.version - 1)[-1].reason == "a picture sees through it"


@pytest.mark.parametrize("depth", [HIGH - 0.4, HIGH - 0.6, 0.0])
def test_what_a_picture_shows_or_hides_or_does_not_measure_stays(context: RunContext, depth: float) -> None:
    name = believed(context)
    before = solid_of(context.world, name)

    review_obstacles(context, "look", picture(context, flat(depth)))

    assert solid_of(context.world, name) == before


def test_of_what_is_smaller_than_believed_the_rest_stays(context: RunContext) -> None:
    name = believed(context)
    depth = flat()
    depth[:, CAMERA.width // 2 :] = HIGH - 0.4  # of the half with greater x, the top is seen

    review_obstacles(context, "look", picture(context, depth))

    solid = solid_of(context.world, name)
    assert solid is not None
    low, high = solid.bounds()
    assert low == pytest.approx((0.0, -0.05, 0.0), abs=0.021)
    assert high == pytest.approx((0.05, 0.05, 0.1), abs=0.001)


def test_what_is_left_where_something_else_is_known_is_that(context: RunContext) -> None:
    believed(context)
    kit = Obstacle("kit", Solid.box(0.3, 0.3, 0.03), AT)

    review_obstacles(context, "look", picture(context, flat(HIGH - AT.position[2] - 0.03), kit))

    assert not context.world.instances(v.OBSTACLE)


def test_what_lies_beside_a_picture_stays(context: RunContext) -> None:
    name = believe_obstacle(context.world, "test", AT @ Pose((1.0, 0.0, 0.0)), (0.1, 0.1, 0.1), "met")

    review_obstacles(context, "look", picture(context, flat()))

    assert context.world.has(name)


def test_it_is_looked_at_from_the_side_of_the_robot_first_from_above_and_in_the_middle_of_the_picture() -> None:
    thing = Obstacle("thing", Solid.box(0.1, 0.1, 0.1), Pose((2.0, 1.0, 0.5)))

    views = list(views_of(thing, Pose((1.0, 1.0, 0.0))))

    seen = np.array([view.inverse().apply(np.array([[2.0, 1.0, 0.55]]))[0] for view in views])
    assert seen[:, :2] == pytest.approx(0.0, abs=1e-9)
    assert (seen[:, 2] > 0.35).all()
    assert views[0].position[0] < 2.0
    assert all(view.position[2] > 0.7 for view in views)

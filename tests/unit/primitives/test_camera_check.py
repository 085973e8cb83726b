"""Two pictures of one thing tell by how much a camera is off, where it was turned in between."""

from __future__ import annotations

import math

import pytest

from skiros_primitives.camera_check import error_between, is_turned
from skiros_py.geometry import Pose
from skiros_py.skills.pictures import Sighting

OFF = Pose.of(0.004, -0.003, 0.0, pitch=math.radians(1.0))
PART = Pose((0.6, 0.1, 0.2))


def sighting(yaw: float, off: Pose = OFF, robot: Pose | None = None) -> Sighting:
    """Returns where a part seems to be to a camera that looks straight down, and is elsewhere than believed."""
    camera = Pose.of(0.6, 0.1, 0.66, roll=math.pi, yaw=yaw)
    return Sighting(Pose() if robot is None else robot, camera, camera @ (camera @ off).inverse() @ PART)


@pytest.mark.parametrize("turn", [math.pi / 2.0, math.pi, -math.pi / 2.0])
def test_the_error_is_what_the_camera_sees_things_off_by(turn: float) -> None:
    first, second = sighting(0.3), sighting(0.3 + turn)

    error = error_between(first, second)

    assert error == pytest.approx(math.dist(first.pose.position[:2], PART.position[:2]), abs=0.0003)
    assert error is not None
    assert error > 0.004


def test_a_camera_that_is_where_it_should_be_has_no_error() -> None:
    assert error_between(sighting(0.0, Pose()), sighting(math.pi, Pose())) == pytest.approx(0.0, abs=1e-9)


def test_one_side_tells_nothing() -> None:
    assert error_between(sighting(0.0), sighting(math.radians(30.0))) is None


def test_nothing_is_told_when_the_robot_has_moved_in_between() -> None:
    assert error_between(sighting(0.0), sighting(math.pi, robot=Pose((0.1, 0.0, 0.0)))) is None


def test_another_thing_is_not_taken_for_the_same() -> None:
    other = sighting(math.pi)

    assert error_between(sighting(0.0), Sighting(other.robot, other.camera, Pose((0.1, 0.0, 0.0)) @ other.pose)) is None


def test_a_side_is_other_enough_from_a_quarter_turn_on() -> None:
    first = sighting(0.0)

    assert is_turned(first, Pose.of(0.5, 0.0, 0.6, roll=math.pi, yaw=math.pi / 2.0))
    assert not is_turned(first, Pose.of(0.5, 0.0, 0.6, roll=math.pi, yaw=math.pi / 4.0))

"""Two pictures of one thing tell by how much a camera is off, where it was turned in between."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from skiros_primitives.camera_check import _is_confirmed, error_between, is_turned, note_sighting
from skiros_py.geometry import Pose
from skiros_py.skills.pictures import Sighting
from skiros_py.station.session import Options, Session

OFF = Pose.of(0.004, -0.003, 0.0, pitch=math.radians(1.0))
FAR = Pose((0.015, 0.0, 0.0))
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


def test_of_two_cameras_that_differ_the_one_is_blamed_that_nothing_confirms() -> None:
    with Session("kitting", Options(fake=True)) as session:
        session.cycle.step()
        context = session.runtime.context
        context.pictures.compared["camera_1"] = 0.0
        first, second = (
            replace(sighting(0.0, off), carrier="robot_1", time=time) for off, time in ((Pose(), 1.0), (FAR, 2.0))
        )

        same = note_sighting(context, "camera_1", "starter_1", first, "test")
        differ = note_sighting(context, "other", "starter_1", second, "test")

        assert same == {}
        assert differ["camera_1"] == pytest.approx(0.015, abs=0.001)
        assert [one for one in ("camera_1", "other") if not _is_confirmed(context, one)] == ["other"]


def test_what_two_cameras_see_alike_confirms_both() -> None:
    with Session("kitting", Options(fake=True)) as session:
        session.cycle.step()
        context = session.runtime.context
        for number, camera in enumerate(("camera_1", "other")):
            seen = replace(sighting(0.0, Pose()), carrier="robot_1", time=float(number))
            assert note_sighting(context, camera, "starter_1", seen, "test") == {}

        assert all(_is_confirmed(context, camera) for camera in ("camera_1", "other"))


def test_a_side_is_other_enough_from_a_quarter_turn_on() -> None:
    first = sighting(0.0)

    assert is_turned(first, Pose.of(0.5, 0.0, 0.6, roll=math.pi, yaw=math.pi / 2.0))
    assert not is_turned(first, Pose.of(0.5, 0.0, 0.6, roll=math.pi, yaw=math.pi / 4.0))

"""A robot's planner gets each of its pictures once, and only the last ones."""

from __future__ import annotations

import numpy as np

from skiros_py.geometry import Pose, Solid
from skiros_py.ports.motion import Obstacle
from skiros_py.ports.values import CameraIntrinsics, DepthImage, Snapshot
from skiros_py.skills.pictures import Pictures


def picture(number: int) -> DepthImage:
    intrinsics = CameraIntrinsics(2, 1, 1.0, 1.0, 0.5, 0.0, 0.1, 2.0)
    depth, colour = np.ones((1, 2), np.float32), np.zeros((1, 2, 3), np.uint8)
    return DepthImage(Snapshot(number, 0.005 * number), depth, colour, intrinsics)


def test_a_robot_gets_each_of_its_pictures_once() -> None:
    pictures, image = Pictures(), picture(1)

    pictures.add(image, "camera_1", "robot_1")

    assert pictures.take("robot_2") == []
    assert pictures.take("robot_1") == [(image, "camera_1")]
    assert pictures.take("robot_1") == []


def test_a_robot_is_told_what_others_have_seen() -> None:
    pictures, box = Pictures(), Obstacle("something", Solid.box(0.1, 0.1, 0.1), Pose())

    pictures.unknown["robot_1"] = (box,)

    assert pictures.unknown_to("robot_2") == (box,)
    assert pictures.unknown_to("robot_1") == ()


def test_only_the_last_pictures_wait() -> None:
    pictures, images = Pictures(), [picture(number) for number in range(20)]

    for image in images:
        pictures.add(image, "camera_1", "robot_1")

    waiting = pictures.take("robot_1")
    assert 1 < len(waiting) < 20
    assert [image for image, _ in waiting] == images[-len(waiting) :]

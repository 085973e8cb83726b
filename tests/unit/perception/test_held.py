"""How a part sits in a gripper, on rendered images with 1.5 mm noise from a camera on the hand."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from skiros_py.geometry import Pose, Solid
from skiros_py.perception.held import sits
from skiros_py.ports.motion import Obstacle
from skiros_py.ports.perception import HeldRequest

if TYPE_CHECKING:
    from conftest import Studio

CAMERA = Pose.of(0.07, 0.0, -0.0734, yaw=math.pi / 2.0)
"""The camera in the frame of the tip: beside the palm, looking along the fingers."""
GRASP_HEIGHTS = {"Starter": 0.032, "Alternator": 0.045, "Compressor": 0.045, "RelayBox": 0.032}


def looked_at(studio: Studio, name: str, move: Pose | None, *, turned: bool = False, seed: int = 0) -> HeldRequest:
    """A part in the gripper, moved from where it was grasped, 0.12 m above a table with neighbours; None: nothing."""
    rng, height = np.random.default_rng(seed), GRASP_HEIGHTS[name]
    guess = Pose.of(0.0, 0.0, height, roll=math.pi) @ Pose.of(0.0, 0.0, 0.0, yaw=math.pi * turned)
    below = height + 0.12
    table = (studio.table(0.4)[0], Pose.of(0.0, 0.0, below, roll=math.pi) @ Pose.of(0.0, 0.0, -0.4))
    bodies = [table]
    for x, y in ((0.13, 0.02), (-0.02, 0.14)):
        bodies.append((studio.parts["Alternator"], Pose.of(x, y, below, roll=math.pi)))
    if move is not None:
        bodies.append((studio.parts[name], move @ guess))
    return HeldRequest(studio.shoot(bodies, CAMERA, rng), CAMERA, studio.parts[name], guess)


@pytest.mark.parametrize("name", list(GRASP_HEIGHTS))
def test_a_part_that_has_slid_along_the_pads_is_found_within_three_millimetres(studio: Studio, name: str) -> None:
    for seed, (slid, pitch) in enumerate(((0.0, 0.0), (0.012, 0.0), (0.004, 4.0), (-0.004, -3.0))):
        move = Pose.of(slid, 0.0, 0.0, pitch=math.radians(pitch))
        request = looked_at(studio, name, move, turned=bool(seed % 2), seed=seed)

        found = sits(request)

        assert found.pose is not None, found.reason
        assert found.pose.distance(move @ request.guess) <= 0.003


@pytest.mark.parametrize("name", list(GRASP_HEIGHTS))
def test_an_empty_gripper_is_told_from_one_that_holds_the_part(studio: Studio, name: str) -> None:
    found = sits(looked_at(studio, name, None))

    assert (found.pose, found.visible) == (None, True)
    assert found.reason


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("name", ["Compressor", "RelayBox"])
def test_what_a_leaning_hand_stands_over_is_not_taken_for_the_part(studio: Studio, name: str, side: float) -> None:
    rng, height, lift = np.random.default_rng(3), GRASP_HEIGHTS[name], 0.06
    lean = Pose.of(0.0, 0.0, 0.0, pitch=side * math.radians(30.0))
    upright = lean.inverse() @ Pose.of(0.0, 0.0, height, roll=math.pi)  # the part, in the frame of a tip that leans
    below = lean.inverse() @ Pose.of(0.0, 0.0, height + lift, roll=math.pi)
    bodies = [(studio.table(0.4)[0], below @ Pose.of(0.0, 0.0, -0.4)), (studio.parts[name], upright)]
    x, y, z = (-lean.matrix()[2, :3]).tolist()

    request = HeldRequest(studio.shoot(bodies, CAMERA, rng), CAMERA, studio.parts[name], upright, up=(x, y, z))
    found = sits(request)

    assert found.pose is not None, found.reason
    assert found.pose.distance(upright) <= 0.003


def test_a_wall_beside_the_hand_is_not_taken_for_the_part(studio: Studio) -> None:
    rng, height, error = np.random.default_rng(3), GRASP_HEIGHTS["RelayBox"], 0.015
    guess = Pose.of(0.0, 0.0, height, roll=math.pi)
    wall = Obstacle("wall", Solid.box(0.4, 0.02, 0.3), Pose.of(0.0, -0.055, height + 0.06, roll=math.pi), error)
    beside = replace(wall.pose, position=(0.0, -0.055 - error / 2.0, height + 0.06))
    bodies = [(wall.solid, beside), (studio.parts["RelayBox"], guess)]
    request = HeldRequest(studio.shoot(bodies, CAMERA, rng), CAMERA, studio.parts["RelayBox"], guess)

    unknown, known = sits(request), sits(replace(request, around=(wall,)))

    assert unknown.pose is None
    assert known.pose is not None, known.reason
    assert known.pose.distance(guess) <= 0.003


def test_no_pose_proves_nothing_for_a_part_that_the_hand_hides(studio: Studio) -> None:
    pin = Solid.box(0.02, 0.02, 0.04)

    found = sits(replace(looked_at(studio, "RelayBox", None), solid=pin))

    assert (found.pose, found.visible) == (None, False)

"""A camera is found on its carrier as exactly as corners are seen, or it is said why not."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from skiros_primitives.board_views import board_views
from skiros_py.geometry import Pose
from skiros_py.perception.calibration import SeenCorners, solve
from skiros_py.ports.calibration import CalibrationResult, MarkerBoard
from skiros_py.ports.values import CameraIntrinsics

BOARD = MarkerBoard(7, 5, 0.03, 0.0225)
CORNERS = BOARD.square * np.array([(x, y, 0.0) for y in range(1, 5) for x in range(1, 7)])
INTRINSICS = CameraIntrinsics(320, 240, 226.0, 226.0, 159.5, 119.5, 0.05, 2.0)
CAMERA = Pose.of(0.05, -0.03, -0.06, roll=0.1, pitch=-0.05, yaw=1.5)
BOARD_POSE = Pose.of(0.5, 0.1, 0.3, roll=math.pi, yaw=0.4)
BELIEVED = CAMERA @ Pose.of(0.015, -0.02, 0.01, roll=0.05, pitch=0.08, yaw=-0.06)
BOARD_BELIEVED = BOARD_POSE @ Pose.of(0.02, 0.01, -0.02, roll=0.05, yaw=0.1)


def seen(views: Sequence[Pose], *, noise: float = 0.2, seed: int = 1) -> list[SeenCorners]:
    """Returns what the camera sees of the board from poses of its own."""
    rng, k, pictures = np.random.default_rng(seed), INTRINSICS, []
    for view in views:
        x, y, z = (view.inverse() @ BOARD_POSE).apply(CORNERS).T
        pixels = np.stack([k.fx * x / z + k.cx, k.fy * y / z + k.cy], axis=-1)
        carrier = view @ CAMERA.inverse()
        pictures.append(SeenCorners(CORNERS, pixels + rng.normal(0.0, noise, pixels.shape), k, carrier))
    return pictures


def around(count: int) -> list[Pose]:
    return list(islice(board_views(BOARD, BOARD_POSE, INTRINSICS), count))


def errors(result: CalibrationResult) -> tuple[float, float]:
    assert result.pose is not None, result.reason
    off = CAMERA.inverse() @ result.pose
    return math.hypot(*off.position), 2.0 * math.acos(min(1.0, abs(off.orientation[3])))


@pytest.mark.parametrize("seed", range(3))
def test_fifteen_views_tell_where_a_camera_is(seed: int) -> None:
    result = solve(seen(around(15), seed=seed), BELIEVED, BOARD_BELIEVED)

    far, turned = errors(result)
    assert far < 0.0007
    assert turned < math.radians(0.1)
    assert result.residual == pytest.approx(0.2 * math.sqrt(2.0), rel=0.15)
    assert far < 4.0 * result.position_error
    assert turned < 4.0 * result.angle_error


def test_a_camera_that_does_not_move_is_found_by_a_board_at_a_measured_place() -> None:
    pictures = [replace(one, carrier=Pose()) for one in seen(around(1) * 6)]

    result = solve(pictures, around(1)[0] @ Pose.of(0.02, 0.01, 0.02, yaw=0.05), BOARD_POSE, board_is_measured=True)

    assert result.pose is not None
    assert result.pose.distance(around(1)[0]) < 0.002


def test_too_few_pictures_are_refused() -> None:
    pictures = seen(around(15))
    few = [replace(one, corners=one.corners[:3], pixels=one.pixels[:3]) for one in pictures[4:]]

    result = solve([*pictures[:4], *few], BELIEVED, BOARD_BELIEVED)

    assert result.pose is None
    assert result.reason == "only 4 pictures show enough of the board, of 5 that are needed"


def test_views_that_are_too_much_alike_are_refused() -> None:
    first = around(1)[0]
    views = [first @ Pose.of(0.004 * (number % 3), 0.004 * (number % 5), 0.0) for number in range(15)]

    result = solve(seen(views), BELIEVED, BOARD_BELIEVED)

    assert result.pose is None
    assert "too much alike" in result.reason


def test_a_board_that_was_pushed_meanwhile_is_noticed() -> None:
    pictures = seen(around(15))
    pushed = [replace(one, carrier=Pose((0.02, 0.0, 0.0)) @ one.carrier) for one in pictures[8:]]

    result = solve([*pictures[:8], *pushed], BELIEVED, BOARD_BELIEVED)

    assert result.pose is None
    assert "from where they should be" in result.reason

"""A board is printed on a body as OpenCV reads it, and pictures of it tell where the camera is."""

from __future__ import annotations

import math
from itertools import islice

import numpy as np
import pytest

from skiros_primitives.board_views import board_views
from skiros_py.charuco import corners_in, dark_cells
from skiros_py.geometry import Pose, Primitive, Solid
from skiros_py.perception.markers import calibrate
from skiros_py.ports.calibration import BoardPicture, CalibrationRequest, MarkerBoard, face_of
from skiros_py.ports.simulation import Print, Rendering, View
from skiros_py.ports.values import DepthImage, Snapshot
from skiros_py.simulation.renderer import BodyAppearance, Renderer, intrinsics_of

BOARD = MarkerBoard(7, 5, 0.03, 0.0225)
WHERE = Pose.of(0.5, 0.2, 0.01, yaw=0.3)
"""The pose of the panel, of which the upper side is printed on."""
PANEL = Solid((Primitive("box", (0.23, 0.17, 0.01), Pose((0.0, 0.0, 0.005))),))
FACE = face_of(BOARD, PANEL)
VIEW = View(320, 240, 0.9773843811168246, 0.05, 2.0)
CAMERA = Pose.of(0.05, -0.03, -0.06, roll=0.1, pitch=-0.05, yaw=1.5)


@pytest.fixture(scope="module")
def panel() -> BodyAppearance:
    dark, cell = dark_cells(BOARD)
    return BodyAppearance(PANEL, (0.5, 0.5, 0.5, 1.0), WHERE, Print(dark, cell, FACE))


@pytest.fixture(scope="module")
def renderer() -> Renderer:
    return Renderer()


def picture(renderer: Renderer, panel: BodyAppearance, pose: Pose) -> Rendering:
    view = View(VIEW.width, VIEW.height, VIEW.vertical_fov, VIEW.near, VIEW.far, pose=pose)
    return renderer.render([panel], [], view, lambda rendering: rendering)


def test_corners_are_seen_where_they_are(renderer: Renderer, panel: BodyAppearance) -> None:
    k, errors = intrinsics_of(VIEW), []
    for pose in islice(board_views(BOARD, WHERE @ FACE, k), 15):
        places, pixels = corners_in(picture(renderer, panel, pose).colour, BOARD)

        x, y, z = (pose.inverse() @ WHERE @ FACE).apply(places).T
        expected = np.stack([k.fx * x / z + k.cx, k.fy * y / z + k.cy], axis=-1)
        errors.append(expected - pixels)
    off = np.concatenate(errors)
    assert len(off) >= 200
    assert np.abs(off).max() < 1.5
    assert float(np.sqrt(np.mean(off**2))) < 0.5  # edges are not smoothed
    assert np.abs(off.mean(axis=0)).max() < 0.15


def test_a_camera_is_found_by_pictures_of_the_board(renderer: Renderer, panel: BodyAppearance) -> None:
    k, pictures = intrinsics_of(VIEW), []
    for pose in islice(board_views(BOARD, WHERE @ FACE, k), 15):
        seen = picture(renderer, panel, pose)
        image = DepthImage(Snapshot(0, 0.0, {}), seen.depth.astype(np.float32), seen.colour, k)
        pictures.append(BoardPicture(image, pose @ CAMERA.inverse()))
    believed = CAMERA @ Pose.of(0.005, 0.0, 0.0, pitch=math.radians(1.0))

    result = calibrate(CalibrationRequest(tuple(pictures), BOARD, believed, WHERE @ FACE))

    assert result.pose is not None, result.reason
    off = CAMERA.inverse() @ result.pose
    assert math.hypot(*off.position) < 0.001
    assert 2.0 * math.acos(min(1.0, abs(off.orientation[3]))) < math.radians(0.2)

"""Robots: how exactly a camera is found on a hand, from pictures of a printed board."""

from __future__ import annotations

import math
import sys
from itertools import islice

import numpy as np
from table import Figure, finish

from skiros_primitives.board_views import board_views
from skiros_py.geometry import Array, Pose
from skiros_py.perception.calibration import SeenCorners, solve
from skiros_py.ports.calibration import CalibrationResult, MarkerBoard
from skiros_py.ports.values import CameraIntrinsics

_SEEDS = 20
_VIEWS = 15
_NOISE = 0.2  # of a corner, in each coordinate [px]
_MOST, _MOST_TURN = 0.0007, math.radians(0.1)  # [m, rad]
_BOARD = MarkerBoard(7, 5, 0.03, 0.0225)
_WRIST = CameraIntrinsics(320, 240, 225.7, 225.7, 159.5, 119.5, 0.05, 2.0)  # the camera of the mobile panda


def corners_of(board: MarkerBoard) -> Array:
    """Returns the inner corners of a board [m], shape (n, 3)."""
    places = [(x, y, 0.0) for y in range(1, board.rows) for x in range(1, board.columns)]
    return board.square * np.array(places)


def seen_from(views: list[Pose], camera: Pose, board: Pose, rng: np.random.Generator) -> list[SeenCorners]:
    """Returns what a camera sees of the board from given poses, with noise.

    Args:
        views: Poses of the camera.
        camera: The camera in the frame of what carries it.
        board: The board.
        rng: Source of the noise.
    """
    corners, k = corners_of(_BOARD), _WRIST
    seen: list[SeenCorners] = []
    for view in views:
        x, y, z = (view.inverse() @ board).apply(corners).T
        pixels = np.stack([k.fx * x / z + k.cx, k.fy * y / z + k.cy], axis=-1)
        inside = np.all((pixels >= 0.0) & (pixels <= (k.width - 1, k.height - 1)), axis=1)
        noisy = pixels + rng.normal(0.0, _NOISE, pixels.shape)
        seen.append(SeenCorners(corners[inside], noisy[inside], k, view @ camera.inverse()))
    return seen


def off(result: CalibrationResult, camera: Pose) -> tuple[float, float]:
    """Returns the errors of a calibration; infinite where there is none [m, rad]."""
    if result.pose is None:
        return math.inf, math.inf
    error = camera.inverse() @ result.pose
    return math.hypot(*error.position), 2.0 * math.acos(min(1.0, abs(error.orientation[3])))


def calibrated(seed: int, count: int = _VIEWS) -> tuple[tuple[float, float], tuple[float, float]]:
    """Returns the errors of a calibration, and those of what was believed before."""
    rng = np.random.default_rng([seed, 18])
    camera = Pose.of(0.05, -0.03, -0.06, roll=0.1, pitch=-0.05, yaw=1.5)
    board = Pose.of(0.5, 0.1, 0.3, roll=math.pi, yaw=0.4)

    def guess(pose: Pose) -> Pose:  # by hand
        x, y, z, roll, pitch, yaw = rng.uniform(-1.0, 1.0, 6).tolist()
        return pose @ Pose.of(0.02 * x, 0.02 * y, 0.02 * z, roll=0.1 * roll, pitch=0.1 * pitch, yaw=0.1 * yaw)

    believed, there = guess(camera), guess(board)
    hands = [view @ believed.inverse() for view in islice(board_views(_BOARD, there, _WRIST), count)]
    seen = seen_from([hand @ camera for hand in hands], camera, board, rng)
    result = solve(seen, believed, there)
    before = CalibrationResult(believed, there, 0, 0.0, 0.0, 0.0)
    return off(result, camera), off(before, camera)


def main() -> int:
    """Calibrates a camera in a hand for each seed; prints the table."""
    after, before = (np.array(errors) for errors in zip(*map(calibrated, range(_SEEDS)), strict=True))
    far, turned = after.max(axis=0)
    what = f"hand-eye from {_VIEWS} views, {_NOISE} px noise, worst of {_SEEDS} seeds"
    middle = np.median(after, axis=0)
    figures = [
        Figure(
            f"{what}: position",
            f"{1e3 * far:.3f} mm (median {1e3 * middle[0]:.3f})",
            f"<= {1e3 * _MOST:.1f} mm",
            bool(far <= _MOST),
            f"by hand {1e3 * before[:, 0].max():.1f} mm",
        ),
        Figure(
            f"{what}: angle",
            f"{math.degrees(turned):.3f} deg (median {math.degrees(middle[1]):.3f})",
            f"<= {math.degrees(_MOST_TURN):.1f} deg",
            bool(turned <= _MOST_TURN),
            f"by hand {math.degrees(before[:, 1].max()):.1f} deg",
        ),
    ]
    return finish("robots", figures)


if __name__ == "__main__":
    sys.exit(main())

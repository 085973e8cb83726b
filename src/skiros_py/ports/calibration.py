"""Port to calibration libraries: where is this camera on what carries it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from skiros_py.geometry import Pose, Solid
from skiros_py.ports.values import DepthImage, Pending


@dataclass(frozen=True, slots=True)
class MarkerBoard:
    """A printed chessboard with a marker in each white square (ChArUco, dictionary 4x4_50).

    Its frame lies in the printed face at the outer corner of its first square, x along its columns, y along its rows.

    Attributes:
        columns, rows: Number of squares.
        square: Side length of a square [m].
        marker: Side length of a marker [m].
    """

    columns: int
    rows: int
    square: float
    marker: float


def face_of(board: MarkerBoard, solid: Solid) -> Pose:
    """Returns the pose of a board that is printed in the middle of the upper side of a body, in the body's frame."""
    low, high = solid.bounds()
    x, y = (float(value) for value in (low[:2] + high[:2]) / 2.0)
    width, length = board.columns * board.square, board.rows * board.square
    return Pose.of(x - width / 2.0, y + length / 2.0, float(high[2]), roll=math.pi)


@dataclass(frozen=True, slots=True)
class BoardPicture:
    """A picture of a board.

    Attributes:
        image: The picture.
        carrier: Pose of what carries the camera when it was taken, in a frame in which the board stands still.
    """

    image: DepthImage
    carrier: Pose


@dataclass(frozen=True, slots=True)
class CalibrationRequest:
    """Pictures from which the place of a camera shall be found.

    Attributes:
        pictures: The pictures.
        board: The board.
        camera: Believed pose of the camera in the frame of its carrier.
        board_pose: Believed pose of the board in the frame of the carriers' poses.
        board_is_measured: True where that pose is exact: it must be where the camera does not move.
    """

    pictures: tuple[BoardPicture, ...]
    board: MarkerBoard
    camera: Pose
    board_pose: Pose
    board_is_measured: bool = False


@dataclass(frozen=True, slots=True)
class CalibrationResult:
    """Where a camera is.

    Attributes:
        pose: Its pose in the frame of its carrier; None when it cannot be told.
        board: Pose of the board as found.
        views: Number of pictures that show enough of the board.
        residual: Root mean square distance of seen corners from where they should be [px].
        position_error: Standard deviation of the position [m].
        angle_error: Standard deviation of the orientation [rad].
        reason: Why there is no pose; empty when there is one.
    """

    pose: Pose | None
    board: Pose
    views: int
    residual: float
    position_error: float
    angle_error: float
    reason: str = ""


class CameraCalibrator(Protocol):
    """Finds where a camera is on its carrier."""

    def calibrate(self, request: CalibrationRequest) -> Pending[CalibrationResult]:
        """Finds one camera."""

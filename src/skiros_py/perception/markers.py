"""Calibration from pictures of a board, whose corners OpenCV finds."""

from __future__ import annotations

from skiros_py.charuco import corners_in
from skiros_py.perception.calibration import SeenCorners, solve
from skiros_py.ports.calibration import BoardPicture, CalibrationRequest, CalibrationResult, MarkerBoard


def seen_in(picture: BoardPicture, board: MarkerBoard) -> SeenCorners:
    """Finds the corners of a board in a picture; there may be none."""
    return SeenCorners(*corners_in(picture.image.colour, board), picture.image.intrinsics, picture.carrier)


def calibrate(request: CalibrationRequest) -> CalibrationResult:
    """Finds the pose of a camera in the frame of its carrier."""
    seen = [seen_in(picture, request.board) for picture in request.pictures]
    return solve(seen, request.camera, request.board_pose, board_is_measured=request.board_is_measured)

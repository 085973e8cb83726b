"""Printed marker boards of OpenCV's: what is printed on them, and where it is in a picture."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from skiros_py.geometry import Array
from skiros_py.ports.calibration import MarkerBoard

_MODULES = 6
"""A marker is so many cells wide, with its border."""


def dark_cells(board: MarkerBoard) -> tuple[tuple[tuple[bool, ...], ...], float]:
    """Returns where a board is dark, as rows of cells along its x axis, and the side length of a cell [m]."""
    cell = board.marker / _MODULES
    size = (round(board.columns * board.square / cell), round(board.rows * board.square / cell))
    picture = np.asarray(_charuco(board).generateImage(size))
    return tuple(tuple((row < 128).tolist()) for row in picture), cell


def corners_in(picture: NDArray[np.uint8], board: MarkerBoard) -> tuple[Array, Array]:
    """Returns the corners of a board that are seen in a picture: their places on the board [m], and pixels."""
    own = _charuco(board)
    grey = np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY))
    found: Any = cv2.aruco.CharucoDetector(own).detectBoard(grey)  # None where nothing is seen, whatever its types say
    pixels, numbers, *_ = found
    if numbers is None or pixels is None:
        return np.zeros((0, 3)), np.zeros((0, 2))
    places: Array = np.asarray(own.getChessboardCorners(), float)
    return places[np.ravel(numbers)], np.asarray(pixels, float).reshape(-1, 2)


def _charuco(board: MarkerBoard) -> Any:
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    return cv2.aruco.CharucoBoard((board.columns, board.rows), board.square, board.marker, dictionary)

"""Claims about rounding the corners of joint paths."""

from __future__ import annotations

import numpy as np

from skiros_py.motion.timing import round_corners

CORNER = [np.zeros(2), np.array([1.0, 0.0]), np.array([1.0, 1.0])]


def test_the_ends_stay_and_the_corner_is_cut() -> None:
    path = round_corners(CORNER, lambda _: True)

    assert path is not None
    assert np.allclose(path[[0, -1]], [CORNER[0], CORNER[-1]])
    assert np.linalg.norm(path - CORNER[1], axis=1).min() > 0.05


def test_a_smaller_rounding_is_used_where_a_wide_one_collides() -> None:
    def clear(posture: np.ndarray) -> bool:
        return not (posture[0] < 0.96 and posture[1] > 0.04)

    path = round_corners(CORNER, clear)

    assert path is not None
    assert all(clear(posture) for posture in path)


def test_no_smoothed_path_is_returned_if_every_rounding_collides() -> None:
    assert round_corners(CORNER, lambda posture: bool(min(1 - posture[0], posture[1]) < 0.001)) is None


def test_a_path_without_corners_is_left_as_it_is() -> None:
    path = round_corners(CORNER[:2], lambda _: False)

    assert path is not None
    assert np.allclose(path[:, 1], 0.0)
    assert np.allclose(np.diff(path[:, 0]), path[1, 0])

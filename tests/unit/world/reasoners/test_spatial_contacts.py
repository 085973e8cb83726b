"""Boxes against a slow, independent judge: bounded least squares, and points tried out."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog, lsq_linear
from scipy.spatial.transform import Rotation

from skiros_py.geometry import Array
from skiros_py.world.reasoners.box_geometry import (
    depth,
    distance,
    gap_seen_from_above,
    is_closer,
    offset_along,
    reach_along,
)
from skiros_py.world.reasoners.boxes import MAP, Boxes

lengths = st.one_of(st.just(0.0), st.floats(0.01, 1.0))
places = st.floats(-2.0, 2.0)
angles = st.one_of(st.sampled_from([0.0, np.pi / 2, np.pi]), st.floats(-np.pi, np.pi))


@st.composite
def boxes(draw: st.DrawFn, number: int = 4) -> Boxes:
    return boxes_of(
        [[draw(places) for _ in range(3)] for _ in range(number)],
        [[draw(lengths) for _ in range(3)] for _ in range(number)],
        [[draw(angles) for _ in range(3)] for _ in range(number)],
    )


def boxes_of(centres: object, halves: object, rpy: object) -> Boxes:
    middles = np.array(centres, dtype=float)
    count = len(middles)
    axes = Rotation.from_euler("xyz", np.array(rpy, dtype=float)).as_matrix()
    yes = np.ones(count, dtype=bool)
    return Boxes(middles, np.array(halves, dtype=float), axes, np.full(count, MAP), yes, ~yes)


def sides(boxes: Boxes, number: int) -> Array:
    return np.asarray(boxes.axes[number] * boxes.halves[number])


def true_distance(a: Boxes, b: Boxes, number: int, dimensions: int = 3) -> float:
    """The two nearest points, found by bounded least squares over where in the boxes they are."""
    matrix = np.hstack([sides(a, number), -sides(b, number)])[:dimensions]
    found = lsq_linear(
        matrix, (b.centres - a.centres)[number][:dimensions], bounds=(-1.0, 1.0), method="bvls", tol=1e-14
    )
    return float(np.linalg.norm(found.fun))


def share_a_point(a: Boxes, b: Boxes, number: int) -> bool:
    """Whether some point is well within both."""
    matrix = np.hstack([sides(a, number), -sides(b, number)])
    found = linprog(np.zeros(6), A_eq=matrix, b_eq=(b.centres - a.centres)[number], bounds=(-0.999, 0.999))
    return bool(found.success)


@settings(max_examples=60, deadline=None)
@given(boxes(), boxes())
def test_distances_are_those_of_the_nearest_points(a: Boxes, b: Boxes) -> None:
    expected = [true_distance(a, b, number) for number in range(len(a))]

    assert distance(a, b) == pytest.approx(expected, abs=1e-6)


@settings(max_examples=60, deadline=None)
@given(boxes(), boxes())
def test_a_gap_is_at_most_the_distance_and_a_depth_means_overlapping_boxes(a: Boxes, b: Boxes) -> None:
    for number, deep in enumerate(depth(a, b)):
        assert -deep <= true_distance(a, b, number) + 1e-6
        if deep > 1e-2:
            assert true_distance(a, b, number) <= 1e-6
        if (sides(a, number).any(axis=0) & sides(b, number).any(axis=0)).all() and share_a_point(a, b, number):
            assert deep > 0.0


@settings(max_examples=60, deadline=None)
@given(boxes(), boxes())
def test_a_body_moved_by_less_than_the_penetration_depth_still_touches(a: Boxes, b: Boxes) -> None:
    """Moved along the direction that is best, which the depth is the length of."""
    for number, deep in enumerate(depth(a, b)):
        if deep > 1e-3:
            rng = np.random.default_rng(0)
            for direction in rng.normal(size=(20, 3)):
                moved = a.centres[[number]] + 0.99 * deep * direction / np.linalg.norm(direction)
                shifted = Boxes(moved, *(getattr(a.take(np.array([number])), f) for f in _REST))
                assert distance(shifted, b.take(np.array([number])))[0] == pytest.approx(0.0, abs=1e-9)


_REST = ("halves", "axes", "roots", "sized", "hollow")


@settings(max_examples=60, deadline=None)
@given(boxes(), boxes(), st.floats(0.0, 2.0))
def test_is_closer_agrees_with_the_distance(a: Boxes, b: Boxes, limit: float) -> None:
    apart = distance(a, b)
    clear = np.abs(apart - limit) > 1e-9

    assert (is_closer(a, b, limit) == (apart <= limit))[clear].all()


@settings(max_examples=60, deadline=None)
@given(boxes(), boxes())
def test_seen_from_above_boxes_overlap_exactly_when_their_outlines_do(a: Boxes, b: Boxes) -> None:
    for number, gap in enumerate(gap_seen_from_above(a, b)):
        apart = true_distance(a, b, number, dimensions=2)

        assert gap <= apart + 1e-6
        assert (gap > 1e-6) == (apart > 1e-6) or abs(gap) < 1e-4


@settings(max_examples=60, deadline=None)
@given(boxes(), boxes(), st.sampled_from([0, 1, 2]))
def test_a_gap_along_an_axis_is_between_the_nearest_corners(a: Boxes, b: Boxes, axis: int) -> None:
    corners = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, 8)
    for number, gap in enumerate(np.abs(offset_along(a, b, axis)) - reach_along(a, b, axis) - b.halves[:, axis]):
        along = b.axes[number][:, axis] @ (
            a.centres[number][:, None] + sides(a, number) @ corners - b.centres[number][:, None]
        )
        half = b.halves[number][axis]
        side = np.sign(along.mean()) or 1.0

        assert gap == pytest.approx((side * along).min() - half, abs=1e-9)


def test_the_distance_of_boxes_without_size_is_that_of_their_centres() -> None:
    a = boxes_of([[0, 0, 0], [1, 2, 2]], [[0, 0, 0]] * 2, [[0, 0, 0]] * 2)
    b = boxes_of([[0, 0, 0], [0, 0, 0]], [[0, 0, 0]] * 2, [[0, 0, 0]] * 2)

    assert distance(a, b) == pytest.approx([0.0, 3.0])


def test_the_distance_of_crossed_bars_is_that_of_their_closest_edges() -> None:
    a = boxes_of([[0, 0, 0]], [[1, 0.1, 0.1]], [[np.pi / 4, 0, 0]])
    b = boxes_of([[0, 0, 1]], [[0.1, 1, 0.1]], [[0, np.pi / 4, 0]])

    assert distance(a, b) == pytest.approx([1.0 - 2 * 0.1 * np.sqrt(2)])

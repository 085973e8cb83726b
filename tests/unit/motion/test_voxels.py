"""What a camera sees and nothing known explains is kept as voxels until it is seen through, or forgotten."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from skiros_py.geometry import Array, Pose, Primitive, Solid
from skiros_py.motion.voxels import SIZE, VoxelMap, Voxels, boxes, explained, things
from skiros_py.ports.motion import DepthView, Obstacle
from skiros_py.ports.values import CameraIntrinsics

CAMERA = CameraIntrinsics(160, 120, 113.0, 113.0, 79.5, 59.5, 0.05, 2.0)
TABLE = Obstacle("table", Solid.box(3.0, 3.0, 0.5), Pose())
TOP, HIGH = 0.5, 1.0
Block = tuple[float, float, float, float]
"""x, y, height and side of a square block that stands on the table [m]."""


def view(*blocks: Block, known: Sequence[Obstacle] = (TABLE,), time: float = 0.0, seed: int = 0) -> DepthView:
    """Returns a picture of blocks on a table, from straight above its middle."""
    v, u = np.mgrid[0 : CAMERA.height, 0 : CAMERA.width]
    right, down = (u - CAMERA.cx) / CAMERA.fx, (v - CAMERA.cy) / CAMERA.fy
    depth = np.full(right.shape, HIGH - TOP)
    for x, y, height, side in blocks:
        away = HIGH - TOP - height
        on = (np.abs(right * away - x) < side / 2.0) & (np.abs(-down * away - y) < side / 2.0)
        depth[on] = np.minimum(depth[on], away)
    noise = np.random.default_rng(seed).normal(0.0, 0.0015, depth.shape)
    camera = Pose.of(0.0, 0.0, HIGH, roll=math.pi)
    return DepthView("arm", (depth + noise).astype(np.float32), CAMERA, camera, time, tuple(known))


def seen(*views: DepthView) -> VoxelMap:
    found = VoxelMap()
    for one in views:
        found.see(one)
    return found


def test_what_nothing_known_explains_is_occupied_where_it_is() -> None:
    centres = seen(view((0.1, -0.05, 0.2, 0.06))).occupied.centres

    assert len(centres) > 0
    assert np.abs(centres[:, :2] - (0.1, -0.05)).max() <= 0.03 + SIZE
    assert centres[:, 2].max() == pytest.approx(TOP + 0.2, abs=SIZE)


def test_what_is_hidden_below_counts_as_occupied() -> None:
    centres = seen(view((0.1, -0.05, 0.2, 0.06))).occupied.centres

    assert centres[:, 2].min() <= TOP


def test_what_is_known_is_not_occupied() -> None:
    part = Obstacle("part", Solid.box(0.06, 0.06, 0.2), Pose((0.1, -0.05, TOP)))
    picture = view((0.1, -0.05, 0.2, 0.06), known=(TABLE, part))

    assert len(seen(picture).occupied.centres) == 0
    assert len(seen(replace(picture, known=(TABLE,), moving=(part,))).occupied.centres) == 0


@pytest.mark.parametrize("seed", range(5))
def test_noise_and_an_uncertain_place_make_nothing_occupied(seed: int) -> None:
    off = Obstacle("part", Solid.box(0.06, 0.06, 0.2), Pose((0.12, -0.07, TOP)), error=0.021)

    assert len(seen(view((0.1, -0.05, 0.2, 0.06), known=(TABLE, off), seed=seed)).occupied.centres) == 0


@pytest.mark.parametrize("seed", range(5))
def test_a_low_thing_on_a_table_whose_place_is_uncertain_is_seen(seed: int) -> None:
    table = replace(TABLE, error=0.021)
    height = 0.02

    assert len(seen(view((0.1, -0.05, height, 0.08), known=(table,), seed=seed)).occupied.centres) > 0
    assert len(seen(view(known=(table,), seed=seed)).occupied.centres) == 0


@pytest.mark.parametrize(
    "turn", [Pose(), Pose.of(0.0, 0.0, 0.0, pitch=math.pi / 2.0), Pose.of(0.0, 0.0, 0.0, roll=0.5)]
)
@pytest.mark.parametrize("solid", [Solid.box(0.1, 0.06, 0.04), Solid((Primitive("cylinder", (0.03, 0.12)),))])
def test_what_is_known_explains_what_is_beside_it_but_little_above_it(solid: Solid, turn: Pose) -> None:
    thing = Obstacle("thing", solid, Pose((1.0, 2.0, 0.5)) @ turn, error=0.02)
    points = thing.pose.apply(_surface(solid.primitives[0]))
    top = points[points[:, 2].argmax()]

    above = top + np.outer((0.01, 0.02), (0.0, 0.0, 1.0))
    beside = points[points[:, 0].argmax()] + (0.04, 0.0, 0.0)

    assert explained(above, [thing]).tolist() == [True, False]
    assert explained(beside[None], [thing]).tolist() == [True]


def _surface(block: Primitive) -> Array:
    """Returns many points on a block, in the frame of its solid."""
    turns = np.linspace(0.0, 2.0 * math.pi, 361)
    if block.kind == "box":
        corners = itertools.product(*((-length / 2.0, length / 2.0) for length in block.size))
        return block.pose.apply(np.array(list(corners)))
    radius, length = block.size
    rims = [
        np.column_stack([radius * np.cos(turns), radius * np.sin(turns), np.full(361, z)])
        for z in (-length / 2.0, length / 2.0)
    ]
    return block.pose.apply(np.vstack(rims))


def test_what_a_later_picture_sees_through_is_free() -> None:
    post = (0.1, -0.05, 0.2, 0.06)
    once, often = seen(view(post)), seen(*(view(post, time=number) for number in range(4)))

    once.see(view(time=1.0))
    often.see(view(time=5.0))

    assert len(once.occupied.centres) == 0
    assert len(often.occupied.centres) > 0
    often.see(view(time=6.0))
    assert len(often.occupied.centres) == 0


def test_what_is_hidden_in_a_later_picture_stays_occupied() -> None:
    found = seen(view((0.1, -0.05, 0.2, 0.06)))
    before = found.occupied.centres
    cover = Obstacle("cover", Solid.box(0.2, 0.2, 0.1), Pose((0.1, -0.05, TOP + 0.3)))

    found.see(view((0.1, -0.05, 0.4, 0.2), known=(TABLE, cover), time=1.0))

    assert len(before) > 0
    assert np.array_equal(found.occupied.centres, before)


def test_what_becomes_known_is_no_longer_unknown() -> None:
    post = (0.1, -0.05, 0.2, 0.06)
    found = seen(view(post))

    found.see(view(post, known=(TABLE, Obstacle("part", Solid.box(0.06, 0.06, 0.2), Pose((0.1, -0.05, TOP))))))

    assert len(found.occupied.centres) == 0


def test_a_robot_that_comes_near_does_not_make_it_forgotten() -> None:
    post = (0.1, -0.05, 0.2, 0.06)
    found = seen(view(post))
    before = found.occupied.centres
    hand = Obstacle("hand", Solid.box(0.1, 0.1, 0.3), Pose((0.1, -0.05, TOP)))

    found.see(replace(view(post, time=1.0), moving=(hand,)))

    assert np.array_equal(found.occupied.centres, before)


def test_what_was_not_seen_for_long_is_forgotten() -> None:
    found = seen(view((0.1, -0.05, 0.2, 0.06)))
    elsewhere = replace(view(time=299.0), camera_pose=Pose.of(9.0, 0.0, HIGH, roll=math.pi), known=())

    found.see(elsewhere)
    near = [centre for centre in found.occupied.centres.tolist() if centre[0] < 1.0]
    found.see(replace(elsewhere, time=301.0))

    assert near
    assert not [centre for centre in found.occupied.centres.tolist() if centre[0] < 1.0]


def test_the_number_of_voxels_is_bounded_and_the_oldest_are_forgotten() -> None:
    found = seen(
        *(replace(view(time=k), camera_pose=Pose.of(2.0 * k, 0.0, HIGH, roll=math.pi), known=()) for k in range(8))
    )

    cells = found.occupied.centres
    assert len(cells) <= 21 * 2000
    assert cells[:, 0].max() > 13.0
    assert cells[:, 0].min() > 1.0


def test_boxes_of_voxels_fill_the_same_space() -> None:
    rng = np.random.default_rng(0)
    cells = np.unique(rng.integers(-4, 4, (150, 3)), axis=0)
    middles = np.asarray((cells + 0.5) * SIZE, np.float64)

    solid = boxes(Voxels(middles))

    volume = sum(math.prod(block.size) for block in solid.primitives)
    assert len(solid.primitives) < len(cells)
    assert volume == pytest.approx(len(cells) * SIZE**3)
    for centre in middles.tolist():
        inside = [
            all(abs(a - b) < size / 2.0 for a, b, size in zip(centre, block.pose.position, block.size, strict=True))
            for block in solid.primitives
        ]
        assert sum(inside) == 1


def test_voxels_that_are_apart_are_two_things() -> None:
    found = seen(view((0.14, 0.08, 0.1, 0.06), (-0.14, -0.08, 0.2, 0.06)))

    blocks = sorted(things(found.occupied), key=lambda one: one[0].position)

    assert [pose.position[:2] for pose, _ in blocks] == [
        pytest.approx((-0.14, -0.08), abs=SIZE),
        pytest.approx((0.14, 0.08), abs=SIZE),
    ]
    tops = [pose.apply(solid.bounds()[1])[2] for pose, solid in blocks]
    assert tops == [pytest.approx(TOP + 0.2, abs=1.5 * SIZE), pytest.approx(TOP + 0.1, abs=1.5 * SIZE)]

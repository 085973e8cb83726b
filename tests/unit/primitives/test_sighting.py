"""A thing is seen where it stands, whatever was believed; what the rays do not say stays as it was believed."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest

from skiros_primitives.sighting import Match, Rays, Sighting, Silhouette
from skiros_py.geometry import Array, Pose, Primitive, Solid, wrap_angle

REACH, NOISE = 5.0, 0.01
PALLET = Solid.box(0.6, 0.8, 0.5)
TABLE = Solid(
    (
        Primitive("box", (0.8, 1.2, 0.04), Pose((0.0, 0.0, 0.72))),
        *(Primitive("box", (0.06, 0.06, 0.7), Pose((x, y, 0.35))) for x in (-0.35, 0.35) for y in (-0.55, 0.55)),
    )
)
DRUM = Solid((Primitive("cylinder", (0.3, 0.8), Pose((0.0, 0.0, 0.4))),))
WALL = Solid.box(0.2, 20.0, 1.0)
APPROACH = tuple(Pose.of(x, 0.1 * math.sin(5.0 * x), 0.0, yaw=0.1) for x in np.linspace(-2.2, -0.9, 20))
"""Where the base is at each scan, in the frame of the thing."""


def scans(things: Sequence[tuple[Solid, Pose]], bases: Sequence[Pose], seed: int) -> list[Rays]:
    """Casts the rays of a scanner at the front of a base, as the simulated one does."""
    rng = np.random.default_rng(seed)
    up, turn = np.meshgrid(np.linspace(-0.3, 0.8, 8), np.linspace(-1.57, 1.57, 61), indexing="ij")
    ways = np.column_stack(
        [(np.cos(up) * np.cos(turn)).ravel(), (np.cos(up) * np.sin(turn)).ravel(), np.sin(up).ravel()]
    )
    found = []
    for base in bases:
        scanner = base @ Pose((0.34, 0.0, 0.28))
        start = np.asarray(scanner.position)
        along = scanner.apply(ways) - start
        blocks = [(pose @ block.pose, block) for solid, pose in things for block in solid.primitives]
        way = np.min([distances(pose, block, start, along) for pose, block in blocks], axis=0)
        met = way < REACH
        way = np.where(met, way + rng.normal(0.0, NOISE, len(way)), REACH)
        found.append(Rays(np.broadcast_to(start, along.shape), start + way[:, None] * along, met))
    return found


def distances(pose: Pose, block: Primitive, start: Array, along: Array) -> Array:
    """Returns how far rays go to a block [m]; infinite where they miss it."""
    back = pose.inverse()
    here = back.apply(start)
    ways = back.apply(start + along) - here
    if block.kind == "cylinder":
        (x, y, _), (dx, dy, _) = here, ways.T
        a, b = dx**2 + dy**2, x * dx + y * dy
        root = b**2 - a * (x**2 + y**2 - block.size[0] ** 2)
        way = np.where(root > 0.0, (-b - np.sqrt(np.maximum(root, 0.0))) / a, np.inf)
        inside = np.abs(here[2] + np.where(np.isfinite(way), way, 0.0) * ways[:, 2]) < block.size[1] / 2.0
        return np.where(inside & (way > 0.0), way, np.inf)
    half = np.asarray(block.size) / 2.0
    sides = np.stack([(sign * half - here) / np.where(np.abs(ways) < 1e-9, 1e-9, ways) for sign in (-1.0, 1.0)])
    enters, leaves = sides.min(axis=0).max(axis=1), sides.max(axis=0).min(axis=1)
    return np.where((enters < leaves) & (enters > 0.0), enters, np.inf)


def seen(solid: Solid, really: Pose, believed: Pose, seed: int, *others: tuple[Solid, Pose]) -> Match:
    """Returns what a base sees of a thing while it comes near."""
    silhouette = Silhouette(solid)
    cast = scans([(solid, really), *others], [really @ base for base in APPROACH], seed)
    return silhouette.match(Rays.joined([silhouette.telling(rays, believed) for rays in cast]), believed, believed)


def off(one: Pose, other: Pose) -> tuple[float, float, float]:
    """Returns the difference of two poses, in the frame of the first [mm, mm, deg]."""
    between = one.inverse() @ other
    return 1e3 * between.position[0], 1e3 * between.position[1], math.degrees(wrap_angle(between.yaw))


@pytest.mark.parametrize(("solid", "far"), [(PALLET, 0.12), (TABLE, 0.08)], ids=["pallet", "legs"])
def test_a_thing_is_seen_within_millimetres_wherever_it_was_believed_to_be(solid: Solid, far: float) -> None:
    for seed in range(6):
        rng = np.random.default_rng(seed)
        x, y, yaw, dx, dy, turn = rng.uniform(-1.0, 1.0, 6)
        really = Pose.of(5.0 * x, 5.0 * y, 0.0, yaw=math.pi * yaw)
        believed = really @ Pose.of(far * dx, far * dy, 0.0, yaw=far / 1.4 * turn)

        match = seen(solid, really, believed, seed)

        assert match.fits
        x_off, y_off, turned = off(really, match.pose)
        assert math.hypot(x_off, y_off) < 4.0
        assert abs(turned) < 0.4


def test_along_a_wall_what_was_believed_stays() -> None:
    believed = Pose.of(0.08, 0.10, 0.0, yaw=0.02)

    match = seen(WALL, Pose(), believed, 1)

    x_off, y_off, turned = off(Pose(), match.pose)
    assert abs(x_off) < 3.0
    assert abs(turned) < 0.3
    assert y_off == pytest.approx(100.0, abs=10.0)
    assert match.sigma[1] > 10.0 * match.sigma[0]


def test_what_is_round_keeps_the_heading_that_was_believed() -> None:
    match = seen(DRUM, Pose(), Pose.of(0.06, -0.08, 0.0, yaw=0.5), 1)

    x_off, y_off, turned = off(Pose(), match.pose)
    assert math.hypot(x_off, y_off) < 4.0
    assert turned == pytest.approx(math.degrees(0.5), abs=0.1)


def test_what_stands_before_a_thing_does_not_move_it() -> None:
    crate = Solid.box(0.2, 0.25, 0.3), Pose((-0.5, 0.15, 0.0))

    match = seen(PALLET, Pose(), Pose.of(0.02, 0.02, 0.0), 1, crate)

    x_off, y_off, _ = off(Pose(), match.pose)
    assert math.hypot(x_off, y_off) < 4.0


def test_rays_go_through_the_place_of_a_thing_that_is_not_there() -> None:
    assert seen(PALLET, Pose(), Pose(), 1).through == 0
    silhouette = Silhouette(PALLET)
    cast = scans([(PALLET, Pose((0.0, 3.0, 0.0)))], APPROACH, 1)
    gone = silhouette.match(Rays.joined([silhouette.telling(rays, Pose()) for rays in cast]), Pose(), Pose())

    assert not gone.fits
    assert gone.through > 100
    assert gone.pose == Pose()


def test_scans_of_a_base_that_hardly_moves_do_not_push_out_what_was_seen_on_the_way() -> None:
    sighting = Sighting(PALLET, Pose.of(0.05, -0.05, 0.0))
    for base, rays in zip(APPROACH, scans([(PALLET, Pose())], APPROACH, 1), strict=True):
        sighting.add(rays, base)
    on_the_way = sighting.seen
    docked = [Pose((-0.78, 0.0005 * number, 0.0)) for number in range(30)]
    for base, rays in zip(docked, scans([(PALLET, Pose())], docked, 2), strict=True):
        sighting.add(rays, base)

    assert on_the_way is not None
    assert sighting.seen is not None
    for pose in (on_the_way, sighting.seen):
        x_off, y_off, turned = off(Pose(), pose)
        assert math.hypot(x_off, y_off) < 3.0
        assert abs(turned) < 0.3

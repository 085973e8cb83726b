"""Where exactly a kit stands, on rendered images with 1.5 mm noise."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest

from skiros_py.geometry import Pose, Solid
from skiros_py.perception.registration import register
from skiros_py.ports.perception import RegistrationRequest

if TYPE_CHECKING:
    from conftest import Placed, Studio


def misplaced(pose: Pose, rng: np.random.Generator) -> Pose:
    bearing, distance = rng.uniform(-math.pi, math.pi), rng.uniform(0.0, 0.03)
    x, y, z = pose.position
    turn = math.radians(rng.uniform(-10.0, 10.0))
    away = (distance * math.cos(bearing), distance * math.sin(bearing))
    return Pose.of(x + away[0], y + away[1], z + rng.uniform(-0.01, 0.01), yaw=pose.yaw + turn)


def filled(studio: Studio, kit: Pose, rng: np.random.Generator, count: int) -> list[Placed]:
    names = rng.choice(list(studio.parts), 4)
    places = [kit @ Pose.of(x, y, studio.kit_floor, yaw=rng.uniform(-0.1, 0.1)) for x, y in studio.compartments]
    return [(studio.parts[name], at) for name, at in zip(names, places, strict=True)][:count]


@pytest.mark.parametrize(("aside", "above"), [(0.03, 0.44), (0.11, 0.34)], ids=["seen whole", "cut by the border"])
def test_a_kit_is_located_to_a_millimetre_whatever_it_contains(studio: Studio, aside: float, above: float) -> None:
    for seed in range(10):
        rng, height = np.random.default_rng(seed), (0.35, 0.50)[seed % 2]
        kit = Pose.of(0.3, 0.1, height, yaw=rng.uniform(-3.0, 3.0))
        bodies = [studio.table(height, 0.3, 0.1), (studio.kit, kit), *filled(studio, kit, rng, seed % 5)]
        camera = studio.over(0.3 + aside, 0.1 - aside, height + above, rng.uniform(-3.0, 3.0))
        image = studio.shoot(bodies, camera, rng)

        result = register(RegistrationRequest(image, camera, studio.kit, misplaced(kit, rng), seed))

        assert result.pose is not None, (seed, result.reason)
        error = kit.inverse() @ result.pose
        assert math.hypot(*error.position[:2]) <= 0.0025
        assert abs(error.position[2]) <= 0.001
        assert abs(error.yaw) <= math.radians(0.3)


@pytest.mark.parametrize("tilt", [25.0, 45.0])
def test_a_kit_is_located_from_the_side(studio: Studio, tilt: float) -> None:
    for seed in range(8):
        rng = np.random.default_rng(seed)
        kit = Pose.of(0.3, 0.1, 0.5, yaw=rng.uniform(-3.0, 3.0))
        bodies = [studio.table(0.5, 0.3, 0.1), (studio.kit, kit), *filled(studio, kit, rng, seed % 5)]
        aside = Pose.of(0.3, 0.1, 0.5, yaw=rng.uniform(-3.0, 3.0)) @ Pose.of(0.0, 0.0, 0.0, pitch=math.radians(tilt))
        camera = aside @ studio.over(0.0, 0.0, 0.36, 0.5 * math.pi * (seed % 4))

        image = studio.shoot(bodies, camera, rng)
        result = register(RegistrationRequest(image, camera, studio.kit, misplaced(kit, rng), seed))

        assert result.pose is not None, (seed, result.reason)
        error = kit.inverse() @ result.pose
        assert math.hypot(*error.position) <= 0.003
        assert abs(error.yaw) <= math.radians(1.0)


def scaled(solid: Solid, by: float, wall: float = 0.006) -> Solid:
    """A kit of another size, and with walls of another thickness."""
    blocks = []
    for b in solid.primitives:
        x, y = (wall if size == 0.006 else by * size for size in b.size[:2])
        at = (by * b.pose.position[0], by * b.pose.position[1], b.pose.position[2])
        blocks.append(type(b)(b.kind, (x, y, b.size[2]), Pose(at)))
    return Solid(tuple(blocks))


def test_a_kit_that_is_twelve_centimetres_off_is_found(studio: Studio) -> None:
    for seed in range(8):
        rng = np.random.default_rng(seed)
        kit = Pose.of(0.3, 0.1, 0.5, yaw=rng.uniform(-3.0, 3.0))
        bearing = rng.uniform(-math.pi, math.pi)
        guess = Pose((0.12 * math.cos(bearing), 0.12 * math.sin(bearing), 0.0)) @ kit
        bodies = [studio.table(0.5, 0.3, 0.1), (studio.kit, kit), *filled(studio, kit, rng, seed % 3)]
        camera = studio.over(*guess.position[:2], 0.5 + 0.46, rng.uniform(-3.0, 3.0))

        result = register(RegistrationRequest(studio.shoot(bodies, camera, rng), camera, studio.kit, guess, seed))

        assert result.pose is not None, (seed, result.reason)
        error = kit.inverse() @ result.pose
        assert math.hypot(*error.position[:2]) <= 0.004
        assert abs(error.yaw) <= math.radians(0.5)


def test_a_kit_with_walls_of_three_millimetres_is_judged_by_them(studio: Studio) -> None:
    thin, small = scaled(studio.kit, 1.0, 0.003), scaled(studio.kit, 0.85, 0.003)
    for seed in range(4):
        rng, kit = np.random.default_rng(seed), Pose.of(0.0, 0.0, 0.5, yaw=0.4 * seed)
        camera, guess = studio.over(0.02, 0.0, 0.94), misplaced(kit, rng)
        image = studio.shoot([studio.table(0.5), (thin, kit)], camera, rng)

        there = register(RegistrationRequest(image, camera, thin, guess))
        other = register(RegistrationRequest(image, camera, small, guess))

        assert there.pose is not None, there.reason
        assert there.pose.distance(kit) <= 0.003
        assert there.cost <= 0.005
        assert other.pose is None


def test_no_pose_is_found_without_a_kit(studio: Studio) -> None:
    camera, rng = studio.over(0.0, 0.0, 0.94), np.random.default_rng(20)
    parts = [studio.part(n, x, y, 0.5, a) for n, x, y, a in studio.scatter(rng, 4)]
    for bodies in ([studio.table(0.5)], [studio.table(0.5), *parts]):
        image = studio.shoot(bodies, camera, rng)

        result = register(RegistrationRequest(image, camera, studio.kit, Pose.of(0.0, 0.0, 0.5)))

        assert result.pose is None
        assert result.reason


def test_a_kit_of_another_size_is_refused(studio: Studio) -> None:
    camera, kit = studio.over(0.0, 0.0, 0.94), Pose.of(0.0, 0.0, 0.5)
    small = scaled(studio.kit, 0.85)
    image = studio.shoot([studio.table(0.5), (small, kit)], camera, np.random.default_rng(21))

    result = register(RegistrationRequest(image, camera, studio.kit, kit))

    assert result.pose is None
    assert result.reason


def test_a_kit_outside_the_image_is_refused_with_a_reason(studio: Studio) -> None:
    camera, kit = studio.over(0.0, 0.0, 0.94), Pose.of(0.6, 0.0, 0.5)
    image = studio.shoot([studio.table(0.5)], camera, np.random.default_rng(22))

    result = register(RegistrationRequest(image, camera, studio.kit, kit))

    assert result.pose is None
    assert "points" in result.reason


def test_the_same_image_gives_the_same_pose(studio: Studio) -> None:
    camera, kit = studio.over(0.02, 0.0, 0.94), Pose.of(0.0, 0.0, 0.5, yaw=0.2)
    image = studio.shoot([studio.table(0.5), (studio.kit, kit)], camera, np.random.default_rng(23))
    request = RegistrationRequest(image, camera, studio.kit, Pose.of(0.02, 0.01, 0.505, yaw=0.25))

    assert register(request) == register(request)

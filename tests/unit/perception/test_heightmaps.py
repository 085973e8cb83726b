"""Templates worked out from primitives."""

from __future__ import annotations

import math

import numpy as np
import pytest

from skiros_py.geometry import Pose, Primitive, Solid
from skiros_py.perception.heightmaps import Floats, height_map


def heights(solid: Solid, *places: tuple[float, float], pose: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Floats:
    x, y = np.array(places, dtype=np.float32).T
    return height_map(solid).placed(x, y, np.array([pose], dtype=np.float32))[0]


def test_the_height_map_of_a_box_is_level_inside_and_empty_outside() -> None:
    assert heights(Solid.box(0.06, 0.04, 0.05), (0.0, 0.0), (0.028, 0.018), (0.032, 0.0), (0.0, -0.5)) == pytest.approx(
        [0.05, 0.05, 0.0, 0.0]
    )


def test_the_height_map_of_a_lying_cylinder_is_round() -> None:
    lying = Solid((Primitive("cylinder", (0.03, 0.10), Pose.of(0.0, 0.0, 0.03, pitch=math.pi / 2)),))

    expected = [0.03 + math.sqrt(0.03**2 - y**2) for y in (0.0, 0.01, 0.02)]
    assert heights(lying, (0.0, 0.0), (0.03, 0.01), (-0.04, -0.02)) == pytest.approx(expected, abs=6e-4)


def test_the_height_map_of_a_leaning_cylinder_has_an_elliptic_top() -> None:
    leaning = Solid((Primitive("cylinder", (0.02, 0.10), Pose.of(0.0, 0.0, 0.06, roll=0.3)),))

    assert heights(leaning, (0.0, 0.0)) == pytest.approx(0.06 + 0.05 / math.cos(0.3), rel=0.06)


def test_the_highest_primitive_determines_the_height() -> None:
    steps = Solid(
        (*Solid.box(0.1, 0.05, 0.05).primitives, Primitive("box", (0.04, 0.05, 0.02), Pose.of(0.03, 0.0, 0.06)))
    )

    assert heights(steps, (-0.03, 0.0), (0.03, 0.0)) == pytest.approx([0.05, 0.07])


def test_a_placed_solid_is_turned_and_moved() -> None:
    beam = Solid.box(0.10, 0.02, 0.03)

    seen = heights(beam, (0.2, 0.34), (0.24, 0.3), pose=(0.2, 0.3, math.pi / 2))

    assert seen == pytest.approx([0.03, 0.0])


def test_a_height_map_template_is_computed_once() -> None:
    assert height_map(Solid.box(0.06, 0.04, 0.05)) is height_map(Solid.box(0.06, 0.04, 0.05))

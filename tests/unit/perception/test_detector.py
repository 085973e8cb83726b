"""What one look says of the parts on a surface, on rendered images with 1.5 mm noise."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest

from skiros_py.geometry import Pose, Primitive, Solid
from skiros_py.perception.detector import detect
from skiros_py.ports.perception import Detection, DetectionResult, PartModel, Region

if TYPE_CHECKING:
    from conftest import Studio

HALF = (0.13, 0.20)
TABLES = (0.35, 0.45, 0.60)


def region(height: float) -> Region:
    return Region(Pose.of(0.0, 0.0, height), HALF)


def nearest(result: DetectionResult, x: float, y: float, within: float = 0.05) -> Detection | None:
    near = [d for d in result.detections if math.hypot(d.pose.position[0] - x, d.pose.position[1] - y) < within]
    return near[0] if near else None


def test_a_look_from_straight_above_gives_type_position_and_heading(studio: Studio) -> None:
    places, headings = [], []
    for seed in range(24):
        rng, height = np.random.default_rng(seed), TABLES[seed % 3]
        parts = studio.scatter(rng, 1 + seed % 4)
        name, x, y, yaw = parts[0]
        camera = studio.over(x, y, height + rng.uniform(0.40, 0.46), rng.uniform(-3.0, 3.0))
        bodies = [studio.table(height), *(studio.part(n, px, py, height, a) for n, px, py, a in parts)]

        found = nearest(detect(studio.look(bodies, camera, region(height), rng, seed=seed)), x, y)

        assert found is not None
        assert (seed, found.type) == (seed, name)
        assert found.pose.position[2] == pytest.approx(height, abs=0.001)
        places.append(math.hypot(found.pose.position[0] - x, found.pose.position[1] - y))
        if studio.symmetry[name]:
            period = 2.0 * math.pi / studio.symmetry[name]
            headings.append(abs((found.pose.yaw - yaw + period / 2.0) % period - period / 2.0))
    assert np.median(places) <= 0.002
    assert np.percentile(places, 95) <= 0.004
    assert np.median(headings) <= math.radians(1.0)
    assert max(headings) <= math.radians(5.0)


def test_two_types_of_nearly_the_same_outline_are_told_apart_by_their_heights(studio: Studio) -> None:
    post = Solid((Primitive("cylinder", (0.0285, 0.066), Pose((0.0, 0.0, 0.033))),))  # almost the alternator
    models = (*(PartModel(name, solid) for name, solid in studio.parts.items()), PartModel("Post", post))
    for seed in range(6):
        rng, height = np.random.default_rng(seed), 0.50
        solid, name = ((studio.parts["Alternator"], "Alternator"), (post, "Post"))[seed % 2]
        x, y = rng.uniform(-0.1, 0.1, 2)
        bodies = [studio.table(height), (solid, Pose.of(x, y, height))]
        request = studio.look(bodies, studio.over(0.0, 0.0, height + 0.46), region(height), rng, seed=seed)

        found = nearest(detect(replace(request, models=models)), x, y)

        assert found is not None
        assert (seed, found.type) == (seed, name)


def test_a_first_look_from_the_side_never_gives_a_wrong_type(studio: Studio) -> None:
    right = wrong = 0
    for seed in range(100, 120):
        rng, height = np.random.default_rng(seed), TABLES[seed % 3]
        parts = studio.scatter(rng, 3)
        camera = studio.over(*rng.uniform(-0.08, 0.08, 2), height + rng.uniform(0.34, 0.46), rng.uniform(-0.2, 0.2))
        bodies = [studio.table(height), *(studio.part(n, x, y, height, a) for n, x, y, a in parts)]

        result = detect(studio.look(bodies, camera, region(height), rng, seed=seed))

        for name, x, y, _ in parts:
            found = nearest(result, x, y)
            right += found is not None and found.type == name
            wrong += found is not None and found.type not in (name, None)
    assert wrong == 0
    assert right >= 50  # of 60, a few of which the border of the image cuts


def test_a_part_that_fills_its_compartment_is_seen_and_an_empty_one_is_empty(studio: Studio) -> None:
    x, y, wall = 0.0325, 0.023, 0.004  # half of a compartment with 3 mm of play around a relay box
    walls = [(sx * (x + wall / 2.0), sy * (y + wall / 2.0)) for sx, sy in ((1, 0), (-1, 0), (0, 1), (0, -1))]
    blocks = [Primitive("box", (wall if at[0] else 2.0 * x, wall if at[1] else 2.0 * y, 0.02), Pose((*at, 0.01)))
              for at in walls]  # fmt: skip
    rng, camera, compartment = np.random.default_rng(4), studio.over(0.05, -0.03, 0.96), Pose.of(0.0, 0.0, 0.5, yaw=0.3)
    place = [studio.table(0.5), (Solid(tuple(blocks)), compartment)]
    where = Region(compartment, (x, y), exact=True)

    full = detect(studio.look([*place, (studio.parts["RelayBox"], compartment)], camera, where, rng))
    empty = detect(studio.look(place, camera, where, rng))

    assert [thing.type for thing in full.detections] == ["RelayBox"]
    assert full.detections[0].pose.distance(compartment) <= 0.003
    assert empty.detections == ()
    assert empty.visible >= 0.9


def test_the_surface_height_is_found_from_a_guess_that_is_centimetres_off(studio: Studio) -> None:
    rng = np.random.default_rng(1)
    bodies = [studio.table(0.50), studio.part("Compressor", 0.02, 0.05, 0.50, 0.4)]

    result = detect(studio.look(bodies, studio.over(0.0, 0.0, 0.94), region(0.44), rng))

    assert result.surface == pytest.approx(0.50, abs=0.001)
    assert [d.type for d in result.detections] == ["Compressor"]


def test_parts_beyond_the_region_are_not_reported(studio: Studio) -> None:
    rng = np.random.default_rng(2)
    bodies = [
        studio.table(0.5),
        studio.part("Alternator", 0.0, 0.0, 0.5, 0.0),
        studio.part("Starter", 0.2, 0.0, 0.5, 1.5),
    ]

    result = detect(studio.look(bodies, studio.over(0.0, 0.0, 0.94), region(0.5), rng))

    assert [d.type for d in result.detections] == ["Alternator"]


def test_an_empty_table_gives_no_detections_and_full_visibility(studio: Studio) -> None:
    result = detect(
        studio.look([studio.table(0.5)], studio.over(0.0, 0.0, 0.94), region(0.5), np.random.default_rng(3))
    )

    assert result.detections == ()
    assert result.visible > 0.99


def test_without_a_surface_there_are_no_height_and_no_detections(studio: Studio) -> None:
    result = detect(
        studio.look([studio.table(0.2)], studio.over(0.0, 0.0, 0.94), region(0.5), np.random.default_rng(4))
    )

    assert result.surface is None
    assert result.detections == ()


@pytest.mark.parametrize("aside", [0.0, 0.12])
def test_a_toppled_part_is_unknown_or_has_its_own_type(studio: Studio, aside: float) -> None:
    wrong = unknown = 0
    for seed in range(200, 224):
        rng, name = np.random.default_rng(seed), list(studio.parts)[seed % 4]
        x, y, yaw = *rng.uniform(-0.08, 0.08, 2), rng.uniform(-3.0, 3.0)
        camera = studio.over(x + aside, y - aside, 0.5 + rng.uniform(0.40, 0.46), rng.uniform(-3.0, 3.0))
        bodies = [studio.table(0.5), (studio.toppled(name, rng), Pose.of(x, y, 0.5, yaw=yaw))]

        result = detect(studio.look(bodies, camera, region(0.5), rng, seed=seed))

        wrong += any(d.type not in (name, None) for d in result.detections)
        unknown += any(d.type is None for d in result.detections)
    assert wrong == 0
    assert unknown >= 12


def test_an_object_of_unknown_shape_is_reported_with_its_bounding_box(studio: Studio) -> None:
    brick = Solid.box(0.09, 0.07, 0.035)
    bodies = [studio.table(0.5), (brick, Pose.of(0.03, 0.04, 0.5, yaw=0.5))]

    result = detect(studio.look(bodies, studio.over(0.03, 0.04, 0.94), region(0.5), np.random.default_rng(5)))

    (thing,) = result.detections
    assert thing.type is None
    assert thing.size == pytest.approx((0.09, 0.07, 0.035), abs=0.006)
    assert thing.pose.position[:2] == pytest.approx((0.03, 0.04), abs=0.003)


def test_an_occluder_lowers_visibility_and_hidden_parts_are_not_reported(studio: Studio) -> None:
    camera, rng = studio.over(0.0, 0.0, 0.94), np.random.default_rng(6)
    part = studio.part("RelayBox", 0.03, 0.05, 0.5, 0.3)
    lid = (Solid.box(0.14, 0.14, 0.02), Pose.of(0.016, 0.027, 0.70))

    clear = detect(studio.look([studio.table(0.5), part], camera, region(0.5), rng))
    hidden = detect(studio.look([studio.table(0.5), part, lid], camera, region(0.5), rng))

    assert [d.type for d in clear.detections] == ["RelayBox"]
    assert clear.visible > 0.99
    assert hidden.detections == ()
    assert hidden.visible < 0.7


def test_parts_cut_off_by_the_image_border_are_not_visible(studio: Studio) -> None:
    looks = (
        studio.look([studio.table(0.5)], studio.over(x, 0.0, 0.94), region(0.5), np.random.default_rng(7))
        for x in (0.0, 0.25)
    )
    centred, aside = (detect(look) for look in looks)

    assert centred.visible > 0.99
    assert 0.3 < aside.visible < 0.9


def test_the_part_in_a_compartment_is_found_between_its_walls(studio: Studio) -> None:
    kit = Pose.of(0.3, 0.1, 0.5, yaw=0.7)
    for seed, name in enumerate(studio.parts):
        rng = np.random.default_rng(300 + seed)
        place = studio.compartments[seed]
        inside = kit @ Pose.of(*place, studio.kit_floor) @ Pose.of(*rng.uniform(-0.007, 0.007, 2), 0.0, yaw=0.04)
        believed = kit @ Pose.of(0.0015, -0.0015, 0.0, yaw=0.004) @ Pose.of(*place, studio.kit_floor)
        camera = studio.over(believed.position[0] + 0.05, believed.position[1], 0.94, rng.uniform(-3.0, 3.0))
        bodies = [studio.table(0.5, 0.3, 0.1), (studio.kit, kit), (studio.parts[name], inside)]

        result = detect(studio.look(bodies, camera, Region(believed, (0.068, 0.068)), rng))

        assert [d.type for d in result.detections] == [name]
        assert math.dist(result.detections[0].pose.position[:2], inside.position[:2]) < 0.003
        assert result.surface == pytest.approx(0.5 + studio.kit_floor, abs=0.002)


def test_an_empty_compartment_beside_full_ones_gives_no_detection(studio: Studio) -> None:
    kit, names = Pose.of(0.3, 0.1, 0.35, yaw=-0.4), list(studio.parts)
    floor = [kit @ Pose.of(*place, studio.kit_floor) for place in studio.compartments]
    full = [(studio.parts[name], at) for name, at in zip(names, floor, strict=True)][1:]
    camera = studio.over(0.3, 0.1, 0.78)

    bodies = [studio.table(0.35, 0.3, 0.1), (studio.kit, kit), *full]
    result = detect(studio.look(bodies, camera, Region(floor[0], (0.068, 0.068)), np.random.default_rng(8)))

    assert result.detections == ()
    assert result.visible > 0.95


def test_the_same_look_gives_the_same_answer(studio: Studio) -> None:
    rng = np.random.default_rng(9)
    bodies = [studio.table(0.5), *(studio.part(n, x, y, 0.5, a) for n, x, y, a in studio.scatter(rng, 4))]
    request = studio.look(bodies, studio.over(0.02, 0.0, 0.94), region(0.5), rng, seed=5)

    assert detect(request) == detect(request)

"""What the camera sees is the scene, at the right place and size, and no more than a camera can know."""

import math

import numpy as np
import pytest

from skiros_py.devices.arm import ArmState
from skiros_py.devices.mobile_base import BaseState, BaseTwist
from skiros_py.errors import DeviceError
from skiros_py.geometry import Pose
from skiros_py.simulation.truth import Truth


def _points_in_map(cell, ik, image, base):
    camera = ik.pose(image.snapshot.state("arm", ArmState).positions, "camera_optical")
    return (base @ camera).apply(image.points())


def test_the_depth_of_a_flat_top_is_its_height_within_noise_that_is_new_in_each_shot(make_cell, kitting, ik):
    cell = make_cell(kitting.cell_spec(), cameras=True)

    image, again = (cell.capture("camera").result() for _ in range(2))
    points = _points_in_map(cell, ik, image, Truth(cell).base_pose("base"))
    heights = points[np.hypot(points[:, 0] - 0.78, points[:, 1]) < 0.15, 2]

    assert len(heights) > 5000
    assert heights.mean() == pytest.approx(kitting.TOP, abs=2e-4)
    assert heights.std() == pytest.approx(0.001, rel=0.1)
    assert (image.depth - again.depth).std() == pytest.approx(0.001 * math.sqrt(2.0), rel=0.05)


def test_parts_are_seen_where_they_are_and_as_large_as_they_are(make_cell, kitting, ik):
    places = [(0.60, 0.12), (0.70, -0.12), (0.82, 0.08)]
    boxes = [
        kitting.PARTS["RelayBox"].body(Pose((*at, kitting.TOP)), "table", f"box_{n}") for n, at in enumerate(places)
    ]
    cell = make_cell(kitting.cell_spec(*boxes), cameras=True)

    image = cell.capture("camera").result()
    points = _points_in_map(cell, ik, image, Truth(cell).base_pose("base"))
    tops = points[points[:, 2] > kitting.TOP + 0.05, :2]
    seen = [tops[np.hypot(*(tops - at).T) < 0.06] for at in places]

    for at, top in zip(places, seen, strict=True):
        low, high = top.min(axis=0), top.max(axis=0)
        assert (low + high) / 2 == pytest.approx(at, abs=1.5e-3)
        assert high - low == pytest.approx((0.059, 0.040), abs=4e-3)


def test_an_image_carries_the_joints_and_the_estimated_base_of_its_own_cycle(make_cell, kitting):
    cell = make_cell(kitting.cell_spec(start=Pose((-1.0, 0.0, 0.0))), cameras=True)
    for _ in range(200):
        cell.exchange({"base": BaseTwist(0.4, 0.2)})

    then = cell.read()
    call = cell.capture("camera")
    for _ in range(100):
        cell.exchange({"base": BaseTwist(0.4, 0.2)})
    image = call.result()

    assert call.latency == pytest.approx(0.1)
    assert image.snapshot.cycle == then.cycle
    assert image.snapshot.state("arm", ArmState).positions == then.state("arm", ArmState).positions
    assert image.snapshot.state("base", BaseState).pose == then.state("base", BaseState).pose
    assert image.snapshot.state("base", BaseState).pose != Truth(cell).base_pose("base")


def test_an_image_shows_the_cycle_in_which_it_was_asked_for(make_cell, kitting, ik):
    """The scene goes on at once; a part taken away right after the shot is still in it, a later shot lacks it."""
    box = kitting.PARTS["RelayBox"].body(Pose((0.70, 0.0, kitting.TOP)), "table")
    cell = make_cell(kitting.cell_spec(box), cameras=True)

    first = cell.capture("camera")
    cell.remove_body("part")
    cell.exchange({})
    second = cell.capture("camera")
    cell.add_body(kitting.PARTS["Compressor"].body(Pose((0.70, 0.0, kitting.TOP)), "table", "other"))
    third = cell.capture("camera")
    base = Truth(cell).base_pose("base")
    highest = [_points_in_map(cell, ik, call.result(), base)[:, 2].max() for call in (first, second, third)]

    assert highest == pytest.approx([kitting.TOP + 0.054, kitting.TOP, kitting.TOP + 0.074], abs=0.006)


def test_what_is_out_of_range_has_no_depth(make_cell, kitting):
    cell = make_cell(kitting.cell_spec(), cameras=True)
    up = (-1.5708, -0.6, 0.0, -2.4, 0.0, 3.7, 0.7854)  # looks towards the horizon
    cell.scene.robots[0].devices["arm"]._reference = np.array(up)
    for _ in range(300):
        cell.exchange({})

    depth = cell.capture("camera").result().depth

    assert depth.dtype == np.float32
    assert depth.shape == (240, 320)
    horizon = 40  # rows above which nothing but air is within 2 m
    assert (depth[:horizon] == 0.0).all()
    assert (depth == 0.0).mean() > 0.3
    assert depth.max() < 1.999


def test_an_overview_picture_shows_robot_and_furniture_in_colour(make_cell, kitting):
    cell = make_cell(kitting.cell_spec())

    picture = cell.picture((2.2, -2.0, 1.9), (0.2, 0.0, 0.3), width=320, height=240).result()

    assert picture.shape == (240, 320, 3)
    assert picture.dtype == np.uint8
    wood = (picture[..., 0].astype(int) - picture[..., 2]) > 40
    blue = (picture[..., 2].astype(int) - picture[..., 0]) > 40
    assert wood.sum() > 2000
    assert blue.sum() > 500


def test_an_unknown_camera_is_refused_with_those_that_exist(make_cell, kitting):
    with pytest.raises(DeviceError, match="no camera 'eye'; there is camera"):
        make_cell(kitting.cell_spec(), cameras=True).capture("eye")

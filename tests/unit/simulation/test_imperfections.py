"""Simulated cells have the errors of real ones: of measured poses, of mounted cameras, of depth images."""

import math

import numpy as np
import pytest

from skiros_py.geometry import Pose
from skiros_py.ports.cell import CellSpec
from skiros_py.simulation.imperfections import measured_depth, measured_off, mounting_error
from skiros_py.simulation.spawn import start_poses


@pytest.fixture
def spec(kitting):
    """A kit on a table, with two parts in it and beside it."""
    parts = [kitting.PARTS["RelayBox"].body(Pose((0.7, 0.3, kitting.TOP)), "table", "beside")]
    parts += [kitting.PARTS["Starter"].body(None, "kit_0", "inside")]
    return kitting.cell_spec(*kitting.kit(Pose((0.7, 0.0, kitting.TOP)), place="table"), *parts)


def _off(spec, seed, scale=1.0):
    stated = start_poses(spec, seed)
    return stated, measured_off(spec, stated, seed, scale)


def test_fixed_bodies_are_up_to_10_mm_and_2_degrees_from_where_they_are_stated(spec):
    errors = []
    for seed in range(100):
        stated, real = _off(spec, seed)
        error = stated["table"].inverse() @ real["table"]
        errors.append((error.position[0], error.position[1], error.yaw, error.position[2]))
    x, y, turn, z = np.abs(errors).T

    assert (x.max(), y.max(), turn.max()) <= (0.010, 0.010, math.radians(2.0))
    assert (x.mean(), y.mean(), turn.mean()) == pytest.approx((0.005, 0.005, math.radians(1.0)), rel=0.25)
    assert z.max() == 0.0


def test_what_stands_on_a_body_comes_along_and_compartments_are_where_their_kit_is(spec):
    stated, real = _off(spec, 3)

    def within(place, body):
        return (real[place].inverse() @ real[body]).distance(stated[place].inverse() @ stated[body])

    assert within("table", "beside") == pytest.approx(0.0, abs=1e-9)
    assert within("kit", "kit_3") == pytest.approx(0.0, abs=1e-9)
    assert within("kit_0", "inside") == pytest.approx(0.0, abs=1e-9)
    assert within("table", "kit") > 1e-4  # it has been measured, too


def test_the_errors_are_those_of_the_seed_and_none_where_they_are_left_out(spec):
    assert _off(spec, 1)[1] == _off(spec, 1)[1]
    assert _off(spec, 1)[1]["table"] != _off(spec, 2)[1]["table"]
    stated, exact = _off(spec, 1, scale=0.0)
    assert all(stated[name].distance(pose) < 1e-9 for name, pose in exact.items())
    assert mounting_error("camera", 1, 0.0) == Pose()


def test_a_place_that_is_listed_after_what_stands_on_it_takes_it_along(spec):
    turned = CellSpec(tuple(reversed(spec.bodies)), spec.robots)

    assert _off(turned, 3)[1]["kit_3"].distance(_off(spec, 3)[1]["kit_3"]) < 1e-9


def test_a_camera_is_mounted_about_a_millimetre_and_a_fifth_of_a_degree_off():
    errors = [mounting_error("camera", seed, 1.0) for seed in range(300)]

    assert np.std([error.position for error in errors]) == pytest.approx(0.001, rel=0.1)
    assert np.std([error.yaw for error in errors]) == pytest.approx(math.radians(0.2), rel=0.15)


def test_noise_of_depth_grows_with_the_square_of_the_distance_and_depth_comes_in_millimetres():
    rng = np.random.default_rng(0)
    near, far = (measured_depth(np.full((200, 200), depth), 0.002, rng, 1.0) for depth in (0.5, 1.5))

    assert near.std() == pytest.approx(0.002, rel=0.05)
    assert far.std() == pytest.approx(0.018, rel=0.05)
    assert np.abs(near * 1000.0 - (near * 1000.0).round()).max() < 1e-6


def test_pixels_at_edges_have_no_depth_every_other_time_and_all_others_have():
    scene = np.full((100, 100), 1.0)
    scene[:, 50:] = 0.8

    depth = measured_depth(scene, 0.0, np.random.default_rng(0), 1.0)
    lost = np.isinf(depth)

    assert lost[:, 49:51].mean() == pytest.approx(0.5, abs=0.1)
    assert not lost[:, :49].any()
    assert not lost[:, 51:].any()
    assert np.array_equal(measured_depth(scene, 0.0, np.random.default_rng(0), 0.0), scene)


def test_a_cell_is_built_with_them_and_what_its_camera_says_is_off(make_cell, kitting):
    part = kitting.PARTS["RelayBox"].body(Pose((0.72, 0.0, kitting.TOP)), "table")
    spec = kitting.cell_spec(part)
    exact = make_cell(spec, cameras=True, engine="mujoco")
    real = make_cell(spec, cameras=True, engine="mujoco", imperfections=1.0)

    assert exact.scene.pose("table") == spec.body("table").pose
    assert 1e-4 < real.scene.pose("table").distance(exact.scene.pose("table")) < 0.0142
    image, better = real.capture("camera").result().depth, exact.capture("camera").result().depth
    assert ((image == 0.0) & (better > 0.0)).sum() > 50  # at the edges of the part
    assert len(np.unique(image)) < 2000 < len(np.unique(better))

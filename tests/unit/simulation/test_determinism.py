"""A simulated run is a function of its specification, its seed and its commands."""

import numpy as np

from skiros_py.devices.arm import ArmTarget
from skiros_py.devices.mobile_base import BaseTwist
from skiros_py.geometry import Pose


def _scene(kitting):
    far = kitting.table("far_table", Pose.of(-1.5, 1.2, 0.0, yaw=0.4))
    parts = [part.body(None, "far_table", name) for name, part in kitting.PARTS.items()]
    return kitting.cell_spec(far, *parts, *kitting.kit(Pose((-0.27, 0.0, 0.35)), carrier="base"))


def _two_seconds(cell, home):
    """Moves arm and base and takes a picture in between; returns the final state and the image's depth."""
    target = list(home)
    for cycle in range(400):
        target[0] += 0.3 * cell.period
        arm = ArmTarget(tuple(target), (0.3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
        cell.exchange({"arm": arm, "base": BaseTwist(0.3, 0.5)})
        if cycle == 200:
            shot = cell.capture("camera")
    return cell.state_bytes(), shot.result().depth


def test_the_same_seed_gives_the_same_state_and_the_same_image_to_the_last_bit(make_cell, kitting):
    first, first_depth = _two_seconds(make_cell(_scene(kitting), 7, cameras=True), kitting.HOME)
    second, second_depth = _two_seconds(make_cell(_scene(kitting), 7, cameras=True), kitting.HOME)

    assert first == second
    assert np.array_equal(first_depth, second_depth)


def test_taking_pictures_does_not_change_the_simulation(make_cell, kitting):
    looking, blind = make_cell(_scene(kitting), 7, cameras=True), make_cell(_scene(kitting), 7)
    calls = []
    for cycle in range(60):
        looking.exchange({})
        blind.exchange({})
        if cycle % 20 == 0:
            calls.append(looking.capture("camera"))
            calls.append(looking.picture((2.0, 2.0, 2.0), (0.0, 0.0, 0.3), width=64, height=48))
    images = [call.result() for call in calls]

    assert len(images) == 6
    assert looking.state_bytes() == blind.state_bytes()


def test_another_seed_draws_other_poses(make_cell, kitting):
    assert make_cell(_scene(kitting), 7).state_bytes() != make_cell(_scene(kitting), 8).state_bytes()

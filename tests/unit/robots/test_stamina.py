"""A robot described elsewhere: three cameras on its body, one on its arm, which skills take for looks with the hand."""

from __future__ import annotations

from pathlib import Path

from skiros_py.devices.arm import ArmSpec
from skiros_py.devices.camera import CameraSpec
from skiros_py.devices.gripper import GripperSpec
from skiros_py.skills.cell_reader import read_cell
from skiros_py.station.worlds import open_world
from skiros_py.world import vocabulary as v

FILE = Path(__file__).parents[2] / "data" / "stamina.ttl"


def test_a_robot_with_cameras_on_its_body_and_its_arm_is_read_from_its_individuals() -> None:
    world = open_world(str(FILE))

    robot = read_cell(world, world.instances(v.ROBOT), simulated=False).robots[0]

    body = {"top_front_camera", "top_left_camera", "top_right_camera"}
    assert {camera.id for camera in robot.of(CameraSpec)} == body | {"arm_camera"}
    assert {*world.objects("ur10", v.HAS_A)} == {"arm_camera", "rq3"}
    assert [arm.id for arm in robot.of(ArmSpec)] == ["ur10"]
    assert [gripper.arm for gripper in robot.of(GripperSpec)] == ["ur10"]
    assert robot.carrier is None
    assert ("ur10", "", "/ur10") in robot.drivers
    assert robot.place is not None

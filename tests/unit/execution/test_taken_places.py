"""What a module takes as a whole: the devices of a robot, or a place at which one at a time works."""

from __future__ import annotations

from skiros_py.execution.claims import devices_of
from skiros_py.skills.parameters import Kind, Param
from skiros_py.testing.tiny import world_of

PARAMS = (
    Param("Arm", "sk:Arm", "The arm.", Kind.HARDWARE),
    Param("Robot", "sk:Robot", "The robot.", Kind.PLANNING),
    Param("Place", "sk:Container", "Where.", Kind.PLANNING),
)


def test_claiming_a_robot_claims_all_its_devices() -> None:
    assert devices_of(world_of(""), PARAMS, ("Robot",), {"Robot": "robot_1"}).keys() == {"arm_1", "base_1", "gripper_1"}


def test_claiming_a_place_claims_the_place_itself() -> None:
    world = world_of("scene:kit_1 a sk:Container ; sk:on scene:floor .")

    assert devices_of(world, PARAMS, ("Place",), {"Arm": "arm_1", "Place": "kit_1"}).keys() == {"arm_1", "kit_1"}

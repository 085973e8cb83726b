from __future__ import annotations

import pytest

from skiros_py.devices.arm import ArmSpec
from skiros_py.devices.gripper import GripperSpec
from skiros_py.errors import DescriptionError
from skiros_py.geometry import Pose
from skiros_py.skills.cell_reader import read_cell
from skiros_py.testing import tiny_world, world_of


def test_a_robot_is_read_with_its_base_arm_and_gripper() -> None:
    (robot,) = read_cell(tiny_world(), ["robot_1"]).robots

    assert (robot.id, robot.model, robot.carrier.id) == ("robot_1", "tiny", "base_1")
    assert robot.carrier.start == Pose()
    assert [(arm.id, arm.joints, arm.home) for arm in robot.of(ArmSpec)] == [
        ("arm_1", ("shoulder", "elbow"), (0.0, 0.0))
    ]
    assert [(gripper.id, gripper.arm, gripper.max_gap) for gripper in robot.of(GripperSpec)] == [
        ("gripper_1", "arm_1", 0.1)
    ]


def test_only_the_requested_robots_are_loaded() -> None:
    cell = read_cell(tiny_world(robots=2), ["robot_2"])

    assert [robot.id for robot in cell.robots] == ["robot_2"]


def test_everything_with_a_shape_except_robots_is_a_body() -> None:
    shape = """'[{"kind": "box", "size": [1, 1, 1]}]'^^<http://www.w3.org/1999/02/22-rdf-syntax-ns#JSON>"""
    world = tiny_world(f'scene:box_a sk:solid {shape} ; sk:pose "1 2 0 0 0 0"^^sk:poseLiteral .')

    (body,) = read_cell(world, ["robot_1"]).bodies

    assert (body.id, body.type, body.mass, body.pose) == ("box_a", "tiny:Box", 0.0, Pose((1.0, 2.0, 0.0)))


def test_a_base_that_starts_inside_something_is_refused_with_its_name() -> None:
    json = "^^<http://www.w3.org/1999/02/22-rdf-syntax-ns#JSON>"
    shape = '\'[{"kind": "box", "size": [1, 1, 1], "at": [0, 0, 0.5]}]\'' + json
    world = tiny_world(f'scene:box_a sk:solid {shape} ; sk:pose "0.7 0.2 0 0 0 0"^^sk:poseLiteral .')

    assert read_cell(world, ["robot_1"], simulated=False).robots
    with pytest.raises(DescriptionError, match="base_1 starts inside box_a: give it an sk:pose on free floor"):
        read_cell(world, ["robot_1"])


@pytest.mark.parametrize(
    ("element", "property_", "message"),
    [
        ("base_1", "sk:pose", "base_1 has no sk:pose: the scene must say where it starts"),
        ("base_1", "sk:maxLinear", "base_1 has no number for sk:maxLinear"),
        ("robot_1", "sk:model", "robot_1 has no text for sk:model"),
        ("arm_1", "sk:home", "arm_1 has no numbers for sk:home"),
    ],
)
def test_a_missing_property_of_a_robot_is_named_with_its_element(element: str, property_: str, message: str) -> None:
    world = tiny_world()
    with world.transaction("test", "forget it") as tx:
        tx.set(element, property_, None)

    with pytest.raises(DescriptionError, match=message):
        read_cell(world, ["robot_1"])


def test_a_gripper_on_no_arm_is_refused() -> None:
    world = tiny_world()
    with world.transaction("test", "unscrewed") as tx:
        tx.unrelate("arm_1", "sk:hasA", "gripper_1")
        tx.relate("robot_1", "sk:hasA", "gripper_1")

    with pytest.raises(DescriptionError, match="gripper_1 is on no arm"):
        read_cell(world, ["robot_1"])


def test_two_arms_with_one_joint_are_refused() -> None:
    second = 'scene:arm_2 a sk:Arm ; sk:joints "wrist elbow" ; sk:tip "tip" ; sk:home "0 0"^^sk:vectorLiteral .'
    world = tiny_world(f"{second} scene:robot_1 sk:hasA scene:arm_2 .")

    with pytest.raises(DescriptionError, match="arm_1 and arm_2 both have joint 'elbow' of robot_1: give each its own"):
        read_cell(world, ["robot_1"])
    with world.transaction("test", "another joint") as tx:
        tx.set("arm_2", "sk:joints", "wrist hand")
    assert len(read_cell(world, ["robot_1"]).robots[0].of(ArmSpec)) == 2


def test_a_home_of_the_wrong_length_is_refused() -> None:
    world = tiny_world()
    with world.transaction("test", "one angle too many") as tx:
        tx.set("arm_1", "sk:home", (0.0, 0.0, 0.0))

    with pytest.raises(DescriptionError, match="sk:home has 3 angles for 2 joints"):
        read_cell(world, ["robot_1"])


@pytest.mark.parametrize("accelerations", [(1.0, 2.0, 3.0), (1.0, 0.0)])
def test_accelerations_that_are_not_one_for_each_joint_are_refused(accelerations: tuple[float, ...]) -> None:
    world = tiny_world()
    with world.transaction("test", "wrong accelerations") as tx:
        tx.set("arm_1", "sk:maxJointAccelerations", accelerations)

    with pytest.raises(DescriptionError, match="sk:maxJointAccelerations takes a positive number for each of 2 joints"):
        read_cell(world, ["robot_1"])


def test_accelerations_of_an_arm_are_read_where_there_are_any() -> None:
    world = tiny_world()
    assert read_cell(world, ["robot_1"]).robots[0].of(ArmSpec)[0].accelerations == ()

    with world.transaction("test", "accelerations") as tx:
        tx.set("arm_1", "sk:maxJointAccelerations", (1.0, 2.0))

    assert read_cell(world, ["robot_1"]).robots[0].of(ArmSpec)[0].accelerations == (1.0, 2.0)


SHAPE = """'[{"kind": "box", "size": [0.1, 0.1, 0.1]}]'^^<http://www.w3.org/1999/02/22-rdf-syntax-ns#JSON>"""
SHELF = f'scene:box_a sk:solid {SHAPE} ; sk:pose "1 2 0 0 0 0"^^sk:poseLiteral ; sk:hasA scene:stock .'


def stock(*said: str) -> str:
    return f"scene:stock a sk:Stock ; {' ; '.join(said)} ."


def test_a_stock_of_things_without_a_shape_adds_no_bodies() -> None:
    world = tiny_world(SHELF, stock('sk:stockOf "tiny:Ball"', "sk:stockCount 3"))

    assert [body.id for body in read_cell(world, ["robot_1"]).bodies] == ["box_a"]


PALLET = (
    'scene:pallet a kitting:Pallet ; sk:on scene:floor ; sk:pose "2 0 0 0 0 0"^^sk:poseLiteral ; sk:hasA scene:stock .'
)


@pytest.mark.parametrize(("count", "bodies"), [(3, 4), (10**12, 1)])
def test_stock_becomes_bodies_only_in_a_simulation(count: int, bodies: int) -> None:
    world = world_of(PALLET + stock('sk:stockOf "kitting:Starter"', f"sk:stockCount {count}"))

    assert len(read_cell(world, ["robot_1"], simulated=count < 10).bodies) == bodies


def test_a_stock_larger_than_any_place_adds_no_bodies() -> None:
    world = world_of(PALLET + stock('sk:stockOf "kitting:Starter"', f"sk:stockCount {10**12}"))

    with pytest.raises(DescriptionError, match="stock: no room on 'pallet' for 1000000000000 of kitting:Starter"):
        read_cell(world, ["robot_1"])


@pytest.mark.parametrize(
    ("fact", "message"),
    [
        (SHELF + stock('sk:stockOf "tiny:Ball"'), "stock has no sk:stockCount: say how many tiny:Ball there are"),
        (SHELF + stock("sk:stockCount 3"), "stock: sk:stockOf is None, not a class of sk:Manipulatable"),
        (SHELF + stock('sk:stockOf "tiny:Box"', "sk:stockCount 3"), "tiny:Box, not a class of sk:Manipulatable"),
        (stock('sk:stockOf "tiny:Ball"', "sk:stockCount 3"), "stock is a stock of no place"),
    ],
)
def test_a_missing_property_of_a_stock_is_reported(fact: str, message: str) -> None:
    with pytest.raises(DescriptionError, match=message):
        read_cell(tiny_world(fact), ["robot_1"])


def test_unreadable_elements_and_their_contents_are_left_out_if_a_collector_of_faults_is_given() -> None:
    world = world_of(PALLET + stock('sk:stockOf "kitting:Starter"', "sk:stockCount 3"))
    with world.transaction("ann", "in the midst of building") as tx:
        tx.set("pallet", "sk:pose", None)
    with pytest.raises(DescriptionError, match="pallet has neither a pose nor a place"):
        read_cell(world, ["robot_1"])

    left_out: dict[str, str] = {}
    cell = read_cell(world, ["robot_1"], left_out=left_out)

    assert cell.bodies == ()
    assert left_out["pallet"].startswith("pallet has neither a pose nor a place")
    assert left_out["stock"] == "it lies in pallet, which is not there"


PART_ON_PALLET = """
scene:pallet a kitting:Pallet ; sk:on scene:floor ; sk:pose "2 0 0 0 0 0"^^sk:poseLiteral .
scene:part a kitting:Starter ; sk:on scene:pallet ; sk:pose "1 0 0 0 0 0"^^sk:poseLiteral ; sk:poseFrame scene:pallet .
"""


def test_a_pose_in_the_frame_of_an_element_without_a_pose_names_that_element() -> None:
    world = world_of(PART_ON_PALLET)
    with world.transaction("ann", "in the midst of building") as tx:
        tx.set("pallet", "sk:pose", None)
    left_out: dict[str, str] = {}

    read_cell(world, ["robot_1"], left_out=left_out)

    assert left_out["part"] == (
        "pallet has no sk:pose, and the pose of part is given in its frame: say where pallet is"
    )


def test_a_pose_too_far_away_names_the_frame_that_is_there() -> None:
    world = world_of(PART_ON_PALLET)
    with world.transaction("ann", "millimetres") as tx:
        tx.set("pallet", "sk:pose", Pose((5000.0, 0.0, 0.0)))
    left_out: dict[str, str] = {}

    read_cell(world, ["robot_1"], left_out=left_out)

    assert left_out["pallet"] == "pallet: its pose is more than 1000 m away; lengths are in metres"
    assert left_out["part"].startswith("pallet: its pose is more than 1000 m away, and so is part")


def test_a_kind_that_raises_while_it_reads_a_device_is_named_with_the_device(monkeypatch: pytest.MonkeyPatch) -> None:
    def read(individual: object) -> GripperSpec:
        raise KeyError("boom")

    monkeypatch.setattr(GripperSpec, "read", read)

    with pytest.raises(
        DescriptionError, match=r"gripper_1 \(kind 'gripper' of skiros-py .*\) cannot be read: KeyError"
    ):
        read_cell(tiny_world(), ["robot_1"])

"""The fake cell does at once what it is told, and admits what it cannot do."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import pytest

from skiros_py.devices.arm import ArmState, ArmTarget
from skiros_py.devices.gripper import GripperState, GripperTarget
from skiros_py.devices.mobile_base import BaseState, BaseTwist
from skiros_py.errors import DeviceError
from skiros_py.geometry import Pose
from skiros_py.ports.cell import CellSpec, RobotSpec
from skiros_py.ports.device import DeviceSpec, MobileSpec
from skiros_py.simulation.fake.cell import FakeCell


def test_arms_and_grippers_reach_their_targets_within_the_cycle(kitting):
    cell = FakeCell(kitting.cell_spec())

    target = ArmTarget((0.1,) * 7, (0.0,) * 7)
    snapshot = cell.exchange({"arm": target, "gripper": GripperTarget(0.03, 20.0)})

    assert snapshot.cycle == 1
    assert snapshot.time == cell.period
    assert snapshot.state("arm", ArmState).positions == target.positions
    assert snapshot.state("gripper", GripperState).gap == 0.03
    assert cell.exchange({}).state("gripper", GripperState).gap == 0.03


def test_a_base_drives_exactly_as_told_and_knows_where_it_is(kitting):
    cell = FakeCell(kitting.cell_spec(start=Pose.of(1.0, 2.0, 0.0, yaw=math.pi / 2)))

    for _ in range(200):
        cell.exchange({"base": BaseTwist(0.5, 0.0)})
    for _ in range(200):
        cell.exchange({"base": BaseTwist(0.0, -math.pi / 2)})
    base = cell.exchange({}).state("base", BaseState)

    assert base.pose.position == pytest.approx((1.0, 2.5, 0.0))
    assert base.pose.yaw == pytest.approx(0.0, abs=1e-9)
    assert base.still


def test_a_robot_that_was_put_elsewhere_stands_there_and_drives_on_from_there(kitting):
    cell = FakeCell(kitting.cell_spec())

    cell.stand("base", Pose.of(3.0, 1.0, 0.0, yaw=math.pi / 2))
    stood = cell.exchange({}).state("base", BaseState)
    cell.exchange({"base": BaseTwist(0.5, 0.0)})

    assert stood.pose == Pose.of(3.0, 1.0, 0.0, yaw=math.pi / 2)
    assert stood.still
    assert cell.read().state("base", BaseState).pose.position == pytest.approx((3.0, 1.0 + 0.5 * cell.period, 0.0))


def test_a_fake_cell_has_no_camera_images(kitting):
    with pytest.raises(DeviceError, match="the fake cell has no camera"):
        FakeCell(kitting.cell_spec()).capture("camera")


def test_a_command_for_an_unknown_device_is_refused(kitting):
    with pytest.raises(DeviceError, match="no device 'leg'; there is arm"):
        FakeCell(kitting.cell_spec()).exchange({"leg": ArmTarget((), ())})


@dataclass(frozen=True)
class Lamp:
    on: bool


@dataclass(frozen=True)
class LampSpec(DeviceSpec[Lamp, None]):
    """A kind of somebody else, with a mistake in one method."""

    kind: ClassVar[str] = "lamp"
    device_class: ClassVar[str] = "test:Lamp"
    state_type: ClassVar[type] = Lamp
    mistake: str = ""

    @classmethod
    def read(cls, individual):
        return cls(individual.id)

    def fake(self, robot):
        self.fails_in("fake")
        return None if self.mistake == "no fake" else LampModel(self)

    def fails_in(self, method):
        if self.mistake == method:
            raise KeyError("boom")


class LampModel:
    braking_time = 0.0

    def __init__(self, spec: LampSpec) -> None:
        self.spec = spec
        self.says: Any = Lamp(True)

    def command(self, target):
        self.spec.fails_in("command")

    def state(self):
        self.spec.fails_in("state")
        return self.says


def lamp_cell(mistake: str = "") -> FakeCell:
    return FakeCell(CellSpec((), (RobotSpec("robot", "", (LampSpec("lamp_1", mistake),)),)))


def test_an_exception_in_a_fake_is_refused_and_named():
    with pytest.raises(DeviceError, match=r"fake of lamp_1 \(kind 'lamp'\) raised KeyError: 'boom'"):
        lamp_cell("fake")


def test_an_exception_in_the_first_state_is_refused_and_named():
    with pytest.raises(DeviceError, match=r"lamp_1 .* was switched off: its state raised KeyError: 'boom'"):
        lamp_cell("state")


@pytest.mark.parametrize("said", ["seven", None])
def test_a_state_of_another_type_switches_the_device_off_and_names_it(said, caplog):
    cell = lamp_cell()
    cell._models.models["lamp_1"].says = said

    assert cell.exchange({}).devices["lamp_1"] == Lamp(True)
    assert f"lamp_1 (kind 'lamp') was switched off: its state is a Lamp, not {said!r}" in caplog.text


class Cart(MobileSpec[Lamp, None]):
    """Moves its robot, but has no state that could say where."""

    kind: ClassVar[str] = "cart"
    device_class: ClassVar[str] = "test:Cart"

    @classmethod
    def read(cls, individual):
        return cls(individual.id, Pose(), ())

    def pose(self, state):
        return Pose()

    def fake(self, robot):
        return None


@pytest.mark.parametrize("device", [LampSpec("device_1", "no fake"), Cart("device_1", Pose(), ())])
def test_a_device_whose_fake_has_no_state_is_refused_at_load(device):
    with pytest.raises(
        DeviceError, match=rf"device_1 \(kind '{device.kind}'\) has a state, but fake makes no model of it"
    ):
        FakeCell(CellSpec((), (RobotSpec("robot", "", (device,)),)))


def test_a_fault_of_a_kind_names_the_distribution(site):
    site.install("sk-lamp", {"devices": {"lamp": f"{__name__}:LampSpec"}}, {})

    with pytest.raises(DeviceError, match=r"lamp_1 \(kind 'lamp' of sk-lamp 0.3\) was switched off"):
        lamp_cell("state")

"""The kinds of device that come along keep the contract that everybody's must keep."""

from __future__ import annotations

import math
from typing import Any

import pytest

from skiros_py.devices.arm import ArmSpec, ArmTarget
from skiros_py.devices.camera import CameraSpec
from skiros_py.devices.force_torque import ForceTorqueSpec
from skiros_py.devices.gripper import GripperSpec, GripperTarget
from skiros_py.devices.localiser import LocaliserSpec
from skiros_py.devices.mobile_base import BaseSpec, BaseTwist
from skiros_py.devices.scanner import ScannerSpec
from skiros_py.errors import DeviceError
from skiros_py.ports.device import Contribution, DeviceSpec, FakeRobot
from skiros_py.ports.device_kinds import load_device_kinds
from skiros_py.testing.conformance import DeviceKindContract, small_cell

SPECS = small_cell().devices


class TestArm(DeviceKindContract):
    def device(self) -> DeviceSpec[Any, Any]:
        return SPECS["arm"]

    def target(self) -> ArmTarget:
        return ArmTarget((0.1,) * 7, (0.5,) * 7)


class TestGripper(DeviceKindContract):
    def device(self) -> DeviceSpec[Any, Any]:
        return SPECS["gripper"]

    def target(self) -> GripperTarget:
        return GripperTarget(0.02, 10.0)


class TestBase(DeviceKindContract):
    def device(self) -> DeviceSpec[Any, Any]:
        return SPECS["base"]

    def target(self) -> BaseTwist:
        return BaseTwist(0.1, 0.2)


class TestLocaliser(DeviceKindContract):
    def device(self) -> DeviceSpec[Any, Any]:
        return SPECS["localiser"]


class TestCamera(DeviceKindContract):
    def device(self) -> DeviceSpec[Any, Any]:
        return SPECS["camera"]


class TestScanner(DeviceKindContract):
    def device(self) -> DeviceSpec[Any, Any]:
        return SPECS["scanner"]


class TestForceTorque(DeviceKindContract):
    def device(self) -> DeviceSpec[Any, Any]:
        return SPECS["force_torque"]


def test_each_built_in_device_kind_is_covered() -> None:
    kinds, _ = load_device_kinds()
    own = {kind for kind in kinds.by_name.values() if kind.__module__.startswith("skiros_py.")}

    assert own == {ArmSpec, BaseSpec, CameraSpec, ForceTorqueSpec, GripperSpec, LocaliserSpec, ScannerSpec}
    assert {type(device) for device in SPECS.values()} == own


TWINS = """
from skiros_py.devices.camera import CameraSpec

class {name}(CameraSpec):
    kind = "{kind}"
    device_class = "{class_}"
"""


def install_kind(site: Any, name: str, kind: str, class_: str) -> None:
    code = TWINS.format(name=name, kind=kind, class_=class_)
    site.install(
        f"sk-{name.lower()}", {"devices": {name.lower(): f"sk_{name.lower()}:{name}"}}, {f"sk_{name.lower()}.py": code}
    )


@pytest.mark.parametrize(("kind", "class_"), [("scale", "b:Scale"), ("weigher", "a:Scale")], ids=["name", "class"])
def test_two_device_kinds_with_one_name_or_class_are_both_left_out_and_named(site: Any, kind: str, class_: str) -> None:
    install_kind(site, "First", "scale", "a:Scale")
    install_kind(site, "Second", kind, class_)

    kinds, faults = load_device_kinds()

    assert not {"scale", "weigher"} & set(kinds.by_name)
    assert {fault.distribution for fault in faults} == {"sk-first 0.3", "sk-second 0.3"}
    assert all("first of sk-first 0.3" in str(one) and "second of sk-second 0.3" in str(one) for one in faults)


def test_a_built_in_device_kind_is_kept_whatever_is_installed(site: Any) -> None:
    install_kind(site, "Third", "arm", "a:Arm")

    kinds, (fault,) = load_device_kinds()

    assert kinds.by_name["arm"] is ArmSpec
    assert "third of sk-third 0.3" in str(fault)


def test_shared_set_points_and_twists_are_their_weighted_mean() -> None:
    still, moving = ArmTarget((0.0,) * 7, (0.0,) * 7), ArmTarget((0.4,) * 7, (0.8,) * 7)
    arm = SPECS["arm"].mixed([Contribution("a", still, 3.0), Contribution("b", moving, 1.0)])
    base = SPECS["base"].mixed([Contribution("a", BaseTwist(0.2, 0.0)), Contribution("b", BaseTwist(0.0, 0.4))])

    assert arm.positions == pytest.approx((0.1,) * 7)
    assert arm.velocities == pytest.approx((0.2,) * 7)
    assert (base.linear, base.angular) == pytest.approx((0.1, 0.2))


def test_commands_that_cannot_be_merged_are_refused_with_the_commanding_runs() -> None:
    one, other = (Contribution(name, GripperTarget(0.0, 1.0)) for name in ("pick", "wave"))

    with pytest.raises(DeviceError, match="gripper: pick and wave command it in one cycle"):
        SPECS["gripper"].mixed([one, other])


def test_a_paused_run_scales_a_twist_but_not_set_points() -> None:
    target = ArmTarget((0.1,) * 7, (0.5,) * 7)

    assert SPECS["base"].scaled(BaseTwist(0.4, 1.0), 0.5) == BaseTwist(0.2, 0.5)
    assert SPECS["arm"].scaled(target, 0.5) == target
    assert math.isclose(SPECS["base"].signal("linear").read(SPECS["base"].fake(FakeRobot()).state()), 0.0)

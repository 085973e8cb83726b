"""The UR10e cell: its description is that of the published arm, and its devices keep their contracts."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from functools import cache
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pinocchio as pin
import pytest

from skiros_py.devices.arm import ArmSpec, ArmTarget
from skiros_py.devices.force_torque import ForceTorqueState
from skiros_py.devices.gripper import GripperSpec, GripperState, GripperTarget
from skiros_py.geometry import Array
from skiros_py.motion.pinocchio.arm_model import ArmModel, arm_model
from skiros_py.motion.pinocchio.kinematics import IkSolver
from skiros_py.ports.cell import CellSpec, RobotSpec
from skiros_py.ports.device import DeviceSpec
from skiros_py.ports.driver import CellDriver
from skiros_py.ports.kinematics import write_robot_urdf
from skiros_py.simulation.cell import SimulatedCell
from skiros_py.simulation.fake.cell import FakeCell
from skiros_py.skills.cell_reader import read_cell
from skiros_py.station.session import Options, Session
from skiros_py.testing.conformance import CellDriverContract, DeviceKindContract

HALF = np.pi / 2.0
DH = [(0.0, 0.1807, HALF), (-0.6127, 0.0, 0.0), (-0.57155, 0.0, 0.0)]
DH += [(0.0, 0.17415, HALF), (0.0, 0.11985, -HALF), (0.0, 0.11655, 0.0)]
"""a, d and alpha of each joint, as published."""
MASSES = {"shoulder": 7.369, "upper_arm": 13.051, "forearm": 3.989, "wrist_1": 2.1, "wrist_2": 1.98, "wrist_3": 0.615}
SPEEDS = [120.0, 120.0, 180.0, 180.0, 180.0, 180.0]


@cache
def robot() -> RobotSpec:
    with Session("kitting_cell", Options(fake=True)) as session:
        return read_cell(session.world, ["robot_1"]).robots[0]


@cache
def arm() -> ArmModel:
    return arm_model(robot(), robot().of(ArmSpec)[0])


def published(q: Array) -> Array:
    """Returns where the flange is on the arm's own base, by the published parameters."""
    pose = np.eye(4)
    for angle, (a, d, alpha) in zip(q, DH, strict=True):
        turn, tilt = (np.cos(angle), np.sin(angle)), (np.cos(alpha), np.sin(alpha))
        pose = pose @ np.array(
            [
                [turn[0], -turn[1] * tilt[0], turn[1] * tilt[1], a * turn[0]],
                [turn[1], turn[0] * tilt[0], -turn[0] * tilt[1], a * turn[1]],
                [0.0, tilt[1], tilt[0], d],
                [0.0, 0.0, 0.0, 1.0],
            ]
        )
    return pose


def test_its_flange_is_where_the_published_parameters_put_it(tmp_path: Path) -> None:
    model = pin.buildModelFromUrdf(str(write_robot_urdf("ur10e_cell", tmp_path)))
    data, base = model.createData(), np.diag([-1.0, -1.0, 1.0, 1.0])  # it is mounted with its x axis to the back
    base[2, 3] = 0.6

    for q in np.random.default_rng(3).uniform(-np.pi, np.pi, (50, 6)):
        pin.framesForwardKinematics(model, data, np.concatenate([q, np.zeros(model.nq - 6)]))
        flange = data.oMf[model.getFrameId("flange")].homogeneous
        assert flange == pytest.approx(base @ published(q), abs=1e-9)


def test_masses_speeds_and_limits_are_those_of_the_data_sheet(tmp_path: Path) -> None:
    urdf = ET.parse(write_robot_urdf("ur10e_cell", tmp_path)).getroot()
    masses = {link.get("name"): float(link.find("inertial/mass").get("value")) for link in urdf.iter("link")}  # type: ignore[union-attr, arg-type]

    assert {name: masses[name] for name in MASSES} == MASSES
    assert np.rad2deg(arm().velocity) == pytest.approx(SPEEDS)
    assert np.rad2deg(arm().upper) == pytest.approx([360.0] * 6)


def test_solutions_are_by_whole_turns_as_near_to_where_the_arm_is_as_its_limits_allow() -> None:
    home = np.array(arm().spec.home)
    target = arm().tip_pose(home + 0.2).homogeneous

    found = IkSolver(arm()).branches(target, home, (arm().lower, arm().upper), np.random.default_rng(0))

    assert len(found) > 1
    assert max(np.abs(q - home).max() for q in found) <= np.pi + 1e-9


@pytest.mark.parametrize("device", ["arm_1", "gripper_1", "camera_1", "force_torque_1"])
class TestKinds(DeviceKindContract):
    given: ClassVar[Any] = None
    targets: ClassVar[dict[type, Any]] = {
        ArmSpec: ArmTarget((0.1,) * 6, (0.5,) * 6),
        GripperSpec: GripperTarget(0.02, 10.0),
    }

    @pytest.fixture(autouse=True)
    def take(self, device: str) -> None:
        type(self).given = robot().device(device)

    def device(self) -> DeviceSpec[Any, Any]:
        return self.given  # type: ignore[no-any-return]

    def target(self) -> Any:
        return self.targets.get(type(self.given))


def cell() -> CellSpec:
    return CellSpec((), (robot(),))


class TestFakeCell(CellDriverContract):
    inertia = False
    pictures = False

    def make(self, spec: CellSpec) -> CellDriver:
        return FakeCell(spec)

    def spec(self) -> CellSpec:
        return cell()


@pytest.mark.physics
class TestSimulatedCell(CellDriverContract):
    def make(self, spec: CellSpec) -> CellDriver:
        return SimulatedCell(spec, seed=1)

    def spec(self) -> CellSpec:
        return cell()


ENGINES = [pytest.param("pybullet", marks=pytest.mark.physics), pytest.param("mujoco", marks=pytest.mark.physics)]


@pytest.mark.parametrize("engine", ENGINES)
def test_the_force_torque_sensor_leaves_out_the_weight_of_the_empty_hand(engine: str) -> None:
    driver = SimulatedCell(cell(), seed=1, engine=engine)
    try:
        readings = [driver.exchange({}).state("force_torque_1", ForceTorqueState) for _ in range(200)][100:]
    finally:
        driver.close()

    assert np.mean([one.force for one in readings], axis=0) == pytest.approx([0.0] * 3, abs=0.3)
    assert np.mean([one.torque for one in readings], axis=0) == pytest.approx([0.0] * 3, abs=0.05)


@pytest.mark.parametrize("engine", ENGINES)
def test_three_fingers_meet_in_the_middle_and_open_as_far_as_told(engine: str) -> None:
    driver = SimulatedCell(cell(), seed=1, engine=engine)
    try:
        gaps = []
        for gap in (0.0, 0.1):
            for _ in range(250):
                now = driver.exchange({"gripper_1": GripperTarget(gap, 30.0)})
            gaps.append(now.state("gripper_1", GripperState))
        (body,) = driver.scene.robots
        fingers = body.model.joints(robot().of(GripperSpec)[0].joints).read().positions
    finally:
        driver.close()

    assert [state.gap for state in gaps] == pytest.approx([0.0, 0.1], abs=0.002)
    assert all(state.still for state in gaps)
    assert fingers == pytest.approx([0.05] * 3, abs=0.002)

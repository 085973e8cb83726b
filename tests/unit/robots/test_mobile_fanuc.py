"""The mobile Fanuc: its description is that of the published arm, its base carries it, its hand is that of the cell."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from functools import cache
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from skiros_py.devices.arm import ArmSpec
from skiros_py.devices.force_torque import ForceTorqueSpec
from skiros_py.devices.gripper import GripperSpec
from skiros_py.devices.mobile_base import BaseSpec
from skiros_py.motion.pinocchio.arm_model import ArmModel, arm_model
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.kinematics import write_robot_urdf
from skiros_py.station.session import Options, Session

HALF = np.pi / 2.0
SPEEDS = [195.0, 175.0, 180.0, 360.0, 360.0, 550.0]


@cache
def robot() -> RobotSpec:
    with Session("kitting_fanuc", Options(fake=True)) as session:
        return session.spec.robots[0]


@cache
def arm() -> ArmModel:
    return arm_model(robot(), robot().of(ArmSpec)[0])


@pytest.fixture
def urdf(tmp_path: Path) -> Path:
    return write_robot_urdf("mobile_fanuc", tmp_path)


def test_the_wrist_reaches_1811_mm_from_the_axis_of_joint_1(urdf: Path) -> None:
    model = pin.buildModelFromUrdf(str(urdf))
    data, q = model.createData(), pin.neutral(model)
    elbow = float(np.arctan2(0.25, 0.835))  # the forearm's axis is 250 mm beside that of the elbow
    for joint, angle in (("m20ia_joint_2", HALF), ("m20ia_joint_3", HALF - elbow)):
        q[model.joints[model.getJointId(joint)].idx_q] = angle
    pin.framesForwardKinematics(model, data, q)
    axis, wrist = (data.oMf[model.getFrameId(f"m20ia_{name}")].translation for name in ("joint_1", "joint_5"))

    assert np.hypot(*(wrist - axis)[:2]) == pytest.approx(1.811, abs=0.001)


def test_speeds_limits_and_weights_are_those_of_the_data_sheet(urdf: Path) -> None:
    links = ET.parse(urdf).getroot().iter("link")
    masses = [float(link.find("inertial/mass").get("value")) for link in links if "m20ia" in link.get("name", "")]  # type: ignore[union-attr, arg-type]

    assert sum(masses) == pytest.approx(250.0)
    assert np.rad2deg(arm().velocity) == pytest.approx(SPEEDS, abs=0.1)
    assert np.rad2deg(arm().upper - arm().lower) == pytest.approx([340.0, 260.0, 458.0, 400.0, 280.0, 540.0], abs=0.1)


def test_the_load_of_the_force_torque_sensor_is_what_hangs_on_its_joint(urdf: Path) -> None:
    model, sensor = pin.buildModelFromUrdf(str(urdf)), robot().of(ForceTorqueSpec)[0]
    joint = model.getJointId(sensor.joint)
    masses, moments = [model.inertias[joint].mass], [model.inertias[joint].mass * model.inertias[joint].lever]
    for finger in (model.getJointId(name) for name in robot().of(GripperSpec)[0].joints):
        inertia = model.inertias[finger]
        masses.append(inertia.mass)
        moments.append(inertia.mass * model.jointPlacements[finger].act(inertia.lever))
    flange = model.frames[model.getFrameId(sensor.frame)].placement

    assert sensor.mass == pytest.approx(sum(masses), abs=0.002)
    assert sensor.centre == pytest.approx(flange.actInv(sum(moments) / sum(masses)), abs=0.001)


def test_its_drives_are_strong_enough_for_what_it_weighs(urdf: Path) -> None:
    mass = sum(inertia.mass for inertia in pin.buildModelFromUrdf(str(urdf)).inertias)
    base = robot().of(BaseSpec)[0]

    assert mass > 700.0
    assert base.drive_force >= 2.0 * mass * base.max_linear_acceleration


def test_its_gripper_is_that_of_the_cell(tmp_path: Path, urdf: Path) -> None:
    def hand(path: Path) -> set[bytes]:
        names = {"palm", "tcp", "camera_optical", "finger_thumb", "finger_left", "finger_right"}
        return {ET.tostring(one) for one in ET.parse(path).getroot().iter("link") if one.get("name") in names}

    (tmp_path / "cell").mkdir()
    assert len(hand(urdf)) == 6
    assert hand(urdf) == hand(write_robot_urdf("ur10e_cell", tmp_path / "cell"))

"""The mobile iiwa's model: complete, as heavy as the real one, and its inverse kinematics."""

import xml.etree.ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest

from skiros_py.devices.arm import ArmSpec
from skiros_py.devices.force_torque import ForceTorqueSpec
from skiros_py.devices.gripper import GripperSpec
from skiros_py.devices.mobile_base import BaseSpec
from skiros_py.motion.pinocchio.arm_model import ArmModel
from skiros_py.ports.kinematics import write_robot_urdf
from skiros_py.station.session import Options, Session


@pytest.fixture(scope="module")
def robot():
    with Session("kitting_iiwa", Options(fake=True)) as session:
        return session.spec.robots[0]


@pytest.fixture(scope="module")
def urdf(tmp_path_factory):
    return write_robot_urdf("mobile_iiwa", tmp_path_factory.mktemp("urdf"))


@pytest.fixture(scope="module")
def model(urdf):
    return pin.buildModelFromUrdf(str(urdf))


@pytest.fixture(scope="module")
def arm(robot, urdf):
    return ArmModel(urdf, robot.of(ArmSpec)[0], robot.of(GripperSpec))


def test_the_links_form_one_tree_rooted_in_the_map_and_all_have_mass(urdf):
    model = ET.parse(urdf).getroot()
    links = {link.get("name"): link for link in model.iter("link")}
    children = [joint.find("child").get("link") for joint in model.iter("joint")]

    assert links.keys() - set(children) == {"map"}
    assert len(children) == len(set(children))
    assert min(float(link.find("inertial/mass").get("value")) for link in links.values()) > 0.0


def test_the_arm_weighs_30_kg_and_is_as_fast_and_strong_as_its_data_sheet_says(urdf):
    model = ET.parse(urdf).getroot()
    masses = [float(one.find("inertial/mass").get("value")) for one in model.iter("link") if "iiwa" in one.get("name")]
    limits = [joint.find("limit").attrib for joint in model.iter("joint") if "iiwa_joint" in joint.get("name")]

    assert sum(masses) == pytest.approx(30.0, abs=1.0)
    assert np.rad2deg([float(one["velocity"]) for one in limits]).round() == pytest.approx(
        [85, 85, 100, 75, 130, 135, 135]
    )
    assert [float(one["effort"]) for one in limits] == [320, 320, 176, 176, 110, 40, 40]
    assert np.rad2deg([float(one["upper"]) for one in limits]) == pytest.approx(
        [170, 120, 170, 120, 170, 120, 175], abs=0.1
    )


def test_the_load_of_the_force_torque_sensor_is_what_hangs_on_its_joint(robot, model):
    sensor = robot.of(ForceTorqueSpec)[0]
    joint = model.getJointId(sensor.joint)
    masses, moments = [model.inertias[joint].mass], [model.inertias[joint].mass * model.inertias[joint].lever]
    for finger in (model.getJointId(name) for name in robot.of(GripperSpec)[0].joints):
        inertia = model.inertias[finger]
        masses.append(inertia.mass)
        moments.append(inertia.mass * model.jointPlacements[finger].act(inertia.lever))
    flange = model.frames[model.getFrameId(sensor.frame)].placement

    assert sensor.mass == pytest.approx(sum(masses), abs=0.002)
    assert sensor.centre == pytest.approx(flange.actInv(sum(moments) / sum(masses)), abs=0.001)


def test_its_base_is_omnidirectional_and_its_gripper_opens_110_mm(robot, model):
    fingers = [model.joints[model.getJointId(name)].idx_q for name in robot.of(GripperSpec)[0].joints]

    assert robot.of(BaseSpec)[0].drives_sideways
    assert sum(model.upperPositionLimit[fingers]) == pytest.approx(robot.of(GripperSpec)[0].max_gap) == 0.11

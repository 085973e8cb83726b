"""Kinematics of models of any shape."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from support import warm_python

from skiros_py.errors import UnknownName
from skiros_py.geometry import Pose
from skiros_py.motion.pinocchio.kinematics import PinocchioKinematics
from skiros_py.ports.kinematics import JointMotion, JointRange

INERTIAL = """<inertial><mass value="1"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>"""
EYE = f'<robot name="eye"><link name="housing">{INERTIAL}</link></robot>'
TABLE = f"""<robot name="table"><link name="foot"/><link name="plate">{INERTIAL}</link>
    <joint name="lift" type="prismatic"><parent link="foot"/><child link="plate"/><origin xyz="0 0 0.5"/>
    <axis xyz="0 0 1"/><limit lower="0" upper="0.2" effort="9" velocity="1"/></joint></robot>"""


def model_of(folder: Path, urdf: str) -> PinocchioKinematics:
    file = folder / "model.urdf"
    file.write_text(urdf, encoding="utf-8")
    return PinocchioKinematics(file)


def test_a_model_of_one_link_has_one_frame_and_no_joints(tmp_path: Path) -> None:
    eye = model_of(tmp_path, EYE)

    assert (dict(eye.joints), dict(eye.parents), eye.poses({})) == ({}, {}, {})
    assert eye.pose("housing", {}) == Pose()


def test_the_joints_of_a_model_are_its_own_whatever_its_root_is_called(tmp_path: Path) -> None:
    table = model_of(tmp_path, TABLE)

    assert dict(table.joints) == {"lift": JointRange(0.0, 0.2, 1.0, 9.0)}
    assert table.pose("plate", {"lift": 0.1}).position == pytest.approx((0.0, 0.0, 0.6))


def test_a_pose_is_computed_without_importing_scipy(tmp_path: Path) -> None:
    """The event loop of a server computes them, and must not wait for a second of imports."""
    (tmp_path / "model.urdf").write_text(TABLE, encoding="utf-8")
    code = (
        "import sys; from skiros_py.motion.pinocchio.kinematics import PinocchioKinematics;"
        f"table = PinocchioKinematics({str(tmp_path / 'model.urdf')!r});"
        "table.pose('plate', {'lift': 0.1}); table.poses({}); assert 'scipy' not in sys.modules"
    )

    ended = warm_python.run([sys.executable, "-c", code])

    assert (ended.returncode, ended.stderr) == (0, "")


def test_efforts_carry_weight_and_speed_up_mass(tmp_path: Path) -> None:
    table = model_of(tmp_path, TABLE)

    def effort(acceleration: float) -> float:
        at_rest = np.zeros(1)
        return float(table.efforts(JointMotion(("lift",), at_rest, at_rest, np.array([acceleration])))[0])

    assert table.mass == pytest.approx(1.0)
    assert effort(0.0) == pytest.approx(9.81)
    assert effort(2.0) == pytest.approx(11.81)


def test_efforts_of_an_unknown_joint_are_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(UnknownName, match="'tilt'"):
        model_of(tmp_path, TABLE).efforts(JointMotion(("tilt",), np.zeros(1), np.zeros(1), np.zeros(1)))

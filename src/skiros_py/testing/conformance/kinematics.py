"""What the kinematics of every robot must do."""

# ruff: noqa: D102 - the names of tests say what they claim

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
import pytest

from skiros_py.devices.arm import ArmSpec
from skiros_py.errors import UnknownName
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.kinematics import Kinematics
from skiros_py.testing.conformance.cells import small_cell

_STEP = 1e-6


class KinematicsContract(ABC):
    """Claims about :class:`~skiros_py.ports.kinematics.Kinematics`, for a robot with an arm."""

    @abstractmethod
    def make(self, robot: RobotSpec) -> Kinematics:
        """Returns the kinematics of a robot."""

    def robot(self) -> RobotSpec:
        """Returns the robot; override it for one of another kind."""
        return small_cell(cameras=False).robots[0]

    @pytest.fixture
    def kinematics(self) -> Kinematics:
        """The kinematics of the robot."""
        return self.make(self.robot())

    def test_each_link_has_one_pose_whichever_way_it_is_asked_for(self, kinematics: Kinematics) -> None:
        poses = kinematics.poses(self._home)

        assert poses.keys() == kinematics.parents.keys()
        assert all(kinematics.pose(link, self._home) == pose for link, pose in poses.items())

    def test_the_tip_moves_with_the_joints_and_comes_back(self, kinematics: Kinematics) -> None:
        home = kinematics.pose(self._arm.tip, self._home)
        moved = kinematics.pose(self._arm.tip, {joint: angle + 0.2 for joint, angle in self._home.items()})

        assert home.distance(moved) > 0.001
        assert kinematics.pose(self._arm.tip, self._home) == home

    def test_parents_come_before_their_children(self, kinematics: Kinematics) -> None:
        seen = set(kinematics.parents.values()) - kinematics.parents.keys()
        for link, parent in kinematics.parents.items():
            assert parent in seen
            seen.add(link)

    def test_the_home_posture_is_within_the_ranges_of_the_joints(self, kinematics: Kinematics) -> None:
        for joint, angle in self._home.items():
            limits = kinematics.joints[joint]
            assert limits.lower is None or limits.lower <= angle
            assert limits.upper is None or angle <= limits.upper

    def test_the_jacobian_is_the_rate_at_which_the_tip_moves(self, kinematics: Kinematics) -> None:
        jacobian = kinematics.jacobian(self._arm.tip, self._home, self._arm.joints)
        here = kinematics.pose(self._arm.tip, self._home).inverse()

        assert jacobian.shape == (6, len(self._arm.joints))
        for column, joint in zip(jacobian.T, self._arm.joints, strict=True):
            step = here @ kinematics.pose(self._arm.tip, self._home | {joint: self._home[joint] + _STEP})
            turn = 2.0 * np.array(step.orientation[:3]) * np.sign(step.orientation[3])
            assert np.array([*step.position, *turn]) / _STEP == pytest.approx(column, abs=1e-4)

    def test_a_link_or_joint_that_is_not_there_is_refused(self, kinematics: Kinematics) -> None:
        with pytest.raises(UnknownName, match="nobodys_link"):
            kinematics.pose("nobodys_link", self._home)
        with pytest.raises(UnknownName, match="nobodys_joint"):
            kinematics.jacobian(self._arm.tip, self._home, ("nobodys_joint",))

    @property
    def _arm(self) -> ArmSpec:
        return self.robot().of(ArmSpec)[0]

    @property
    def _home(self) -> dict[str, float]:
        return dict(zip(self._arm.joints, self._arm.home, strict=True))

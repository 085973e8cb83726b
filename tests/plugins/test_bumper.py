"""A base feels in what its drives exert that it pushes something."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from skiros_primitives.driving import Bumper
from skiros_py.devices.arm import ArmState
from skiros_py.devices.mobile_base import BaseState
from skiros_py.errors import DeviceError
from skiros_py.geometry import Array, Pose
from skiros_py.ports.kinematics import BASE_JOINTS, JointMotion

MASS, INERTIA, SWUNG, PERIOD = 100.0, 9.0, 5.0, 0.005


class Robot:
    """What Bumper asks for: the masses of a robot, the control period and the state of a base."""

    id = "base"

    def __init__(self) -> None:
        self.board: Any = SimpleNamespace(period=PERIOD, snapshot=SimpleNamespace(devices={}, state=self.arm_state))
        self.ports = SimpleNamespace(find=lambda _protocol, _device: self)
        self.cell = SimpleNamespace(group_of=lambda _device: self)
        self.carrier = self
        self.spec = SimpleNamespace(drives_sideways=False)
        self.joint_speed = 0.0
        self.state = BaseState(Pose(), 0.0, 0.0, still=True, force=0.0, torque=0.0)

    @property
    def state(self) -> BaseState:
        return self.board.snapshot.devices[self.id]

    @state.setter
    def state(self, state: BaseState) -> None:
        self.board.snapshot.devices[self.id] = state

    def of(self, _kind: type) -> list[Any]:
        return [SimpleNamespace(id="arm", joints=("joint",))]

    def arm_state(self, _device: str, _kind: type) -> ArmState:
        return ArmState((0.0,), (self.joint_speed,), still=False)

    def efforts(self, motion: JointMotion) -> Array:
        assert motion.joints == (*BASE_JOINTS, "joint")
        ahead, aside, around, joint = motion.accelerations
        return np.array([MASS * ahead, MASS * aside, INERTIA * around + SWUNG * joint, SWUNG * joint])

    def felt(self, ahead: float, around: float, *, force: float = 0.0, torque: float = 0.0, joint: float = 0.0) -> bool:
        """Speeds up at some rates for half a second, while something resists with a force and a moment.

        Its arm speeds up as well.
        """
        context: Any = self
        bumper, felt = Bumper(context, context), False
        for step in np.arange(1, 101) * PERIOD:
            exerted = MASS * ahead + force, INERTIA * around + SWUNG * joint + torque
            self.joint_speed = float(step * joint)
            self.state = BaseState(Pose(), float(step * ahead), float(step * around), False, *exerted)
            felt = bumper.felt() or felt
        return felt


def test_speeding_up_is_no_contact() -> None:
    assert not Robot().felt(0.5, 1.5)


@pytest.mark.parametrize(("force", "torque"), [(60.0, 0.0), (-60.0, 0.0), (0.0, 60.0), (0.0, -60.0)])
def test_what_resists_driving_or_turning_is_felt(force: float, torque: float) -> None:
    assert Robot().felt(0.5, 1.5, force=force, torque=torque)
    assert Robot().felt(0.0, 0.0, force=force, torque=torque)


def test_an_arm_that_swings_meanwhile_is_no_contact() -> None:
    assert not Robot().felt(0.5, 1.5, joint=15.0)
    assert Robot().felt(0.5, 1.5, joint=15.0, torque=60.0)


def test_a_base_that_measures_no_force_feels_nothing() -> None:
    robot = Robot()
    context: Any = robot
    robot.state = BaseState(Pose(), 0.0, 0.0, still=True)

    assert not Bumper(context, context).felt()


@pytest.mark.parametrize("left", [None, math.nan])
def test_a_base_whose_force_sensor_is_unplugged_is_stopped(left: float | None) -> None:
    robot = Robot()
    context: Any = robot
    bumper = Bumper(context, context)
    assert not bumper.felt()

    robot.state = replace(robot.state, force=left)

    with pytest.raises(DeviceError, match="base does not measure what its drives exert"):
        bumper.felt()

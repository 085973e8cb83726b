"""One robot in the physics client: its model and its devices."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.values import Commands
from skiros_py.simulation.pybullet.arm import Arm
from skiros_py.simulation.pybullet.base import Base
from skiros_py.simulation.pybullet.client import Client
from skiros_py.simulation.pybullet.gripper import Gripper
from skiros_py.simulation.pybullet.joints import Joints
from skiros_py.simulation.pybullet.localiser import Localiser

__all__ = ["Robot", "load_model"]


class Robot:
    """A loaded robot.

    Args:
        client: The physics client.
        spec: What it is.
        urdf: Its model.
        rng: Source of its localiser's errors.
        period: Control period [s].
    """

    def __init__(self, client: Client, spec: RobotSpec, urdf: Path, rng: np.random.Generator, period: float) -> None:
        self.spec = spec
        self._client = client
        self.joints = Joints(client, load_model(client, urdf))
        self._free_joints()
        self.base = Base(client, self.joints, spec.base, Localiser(rng), period)
        self.arms = [Arm(client, self.joints, arm, period) for arm in spec.arms]
        self.grippers = [Gripper(client, self.joints, gripper) for gripper in spec.grippers]

    @property
    def body(self) -> int:
        """PyBullet's id of the robot."""
        return self.joints.body

    def command(self, commands: Commands) -> None:
        """Tells every device what to do in the next step."""
        self.base.command(commands.bases.get(self.base.spec.id))
        for arm in self.arms:
            arm.command(commands.arms.get(arm.spec.id))
        for gripper in self.grippers:
            gripper.command(commands.grippers.get(gripper.spec.id))

    def posture(self) -> tuple[float, ...]:
        """Returns the positions of all movable joints, base included, in the order of the model."""
        states = self._client.getJointStates(self.body, self.joints.movable)
        return tuple(state[0] for state in states)

    def motion(self) -> tuple[float, ...]:
        """Returns positions and speeds of all movable joints."""
        states = self._client.getJointStates(self.body, self.joints.movable)
        return tuple(value for state in states for value in state[:2])

    def _free_joints(self) -> None:
        """Takes away the damping and the holding motors that PyBullet gives every joint of a new robot."""
        client = self._client
        for index in range(-1, client.getNumJoints(self.body)):
            client.changeDynamics(self.body, index, linearDamping=0, angularDamping=0, jointDamping=0)
        count = len(self.joints.movable)
        client.setJointMotorControlArray(
            self.body,
            self.joints.movable,
            client.VELOCITY_CONTROL,
            targetVelocities=[0.0] * count,
            forces=[0.0] * count,
        )


def load_model(client: Client, urdf: Path) -> int:
    """Loads a robot model at the map's origin, from where its base joints move it; returns PyBullet's id."""
    index: int = client.loadURDF(str(urdf), useFixedBase=True, flags=client.URDF_USE_INERTIA_FROM_FILE)
    return index

"""A simulated parallel gripper: two fingers geared together, a gap sensor and a force sensor."""

from __future__ import annotations

import math

from skiros_py.errors import DeviceError
from skiros_py.ports.cell import GripperSpec
from skiros_py.ports.values import GripperState, GripperTarget
from skiros_py.simulation.pybullet.client import Client
from skiros_py.simulation.pybullet.joints import Joints
from skiros_py.simulation.pybullet.limits import Standstill

__all__ = ["Gripper"]

_GAIN = 0.2
_SPEED = 0.1  # greatest finger speed [m/s]; faster fingers dive into what they close on
_DEFAULT_FORCE = 30.0  # [N] per finger, while nobody has said anything else
_FRICTION = 1.0
_STILL = 0.001  # [m/s]


class Gripper:
    """One parallel gripper of a robot in the physics client; what it holds, it holds by friction.

    Args:
        client: The physics client.
        joints: All joints of its robot.
        spec: What it is; it starts open.
    """

    def __init__(self, client: Client, joints: Joints, spec: GripperSpec) -> None:
        self.spec = spec
        self.fingers = joints.indices(spec.joints)
        self._client = client
        self._body = joints.body
        self._target = GripperTarget(spec.max_gap, min(_DEFAULT_FORCE, spec.max_force))
        self._standstill = Standstill(_STILL)
        for finger in self.fingers:
            client.resetJointState(self._body, finger, spec.max_gap / 2.0)
            # The anchor remembers where finger and part met. Without it a held part creeps: 0.2 mm per second, and 9 mm
            # for every full turn of the robot.
            client.changeDynamics(self._body, finger, lateralFriction=_FRICTION, frictionAnchor=1)
        self._gear()

    def command(self, target: GripperTarget | None) -> None:
        """Moves to a new target; None keeps the last one, so that nothing is let go by omission."""
        if target is not None:
            self._target = self._checked(target)
        for finger in self.fingers:
            self._client.setJointMotorControl2(
                self._body,
                finger,
                self._client.POSITION_CONTROL,
                targetPosition=self._target.gap / 2.0,
                positionGain=_GAIN,
                force=self._target.force,
                maxVelocity=_SPEED,
            )

    def state(self) -> GripperState:
        """Reads the sensors; to be called once per cycle."""
        states = self._client.getJointStates(self._body, self.fingers)
        pressing = -sum(state[3] for state in states) / len(states)
        still = self._standstill.update(max(abs(state[1]) for state in states))
        return GripperState(sum(state[0] for state in states), max(0.0, pressing), still)

    def _checked(self, target: GripperTarget) -> GripperTarget:
        if not (math.isfinite(target.gap) and math.isfinite(target.force) and target.force >= 0.0):
            raise DeviceError(f"{self.spec.id}: a target needs a finite gap and force: {target}")
        gap = min(max(target.gap, 0.0), self.spec.max_gap)
        return GripperTarget(gap, min(target.force, self.spec.max_force))

    def _gear(self) -> None:
        """Couples the fingers as the real drive does; without it they slide sideways together with the part."""
        client, (left, right) = self._client, self.fingers
        origin = (0.0, 0.0, 0.0)
        gear = client.createConstraint(
            self._body, left, self._body, right, client.JOINT_GEAR, (1.0, 0.0, 0.0), origin, origin
        )
        client.changeConstraint(gear, gearRatio=-1, erp=0.1, maxForce=200)

"""A simulated differential-drive base: speed commands within limits, wheels for the eye, an estimated pose."""

from __future__ import annotations

import math

from skiros_py.errors import DeviceError
from skiros_py.geometry import Pose
from skiros_py.ports.cell import BaseSpec
from skiros_py.ports.models import WHEEL_RADIUS, WHEEL_TRACK
from skiros_py.ports.values import BaseState, BaseTwist
from skiros_py.simulation.pybullet.client import Client
from skiros_py.simulation.pybullet.joints import Joints
from skiros_py.simulation.pybullet.limits import Standstill, approach
from skiros_py.simulation.pybullet.localiser import Localiser

__all__ = ["Base"]

_STILL = 0.002  # [m/s], turning counted as [rad/s]
_DRIVE_FORCE = 2000.0  # [N] and [N m]; enough for every acceleration limit a base of this weight may have
_HOLDING_GAIN = 0.2
_WHEEL_TORQUE = 5.0  # [N m]; wheels carry nothing
_STAND = BaseTwist(0.0, 0.0)


class Base:
    """The base of a robot in the physics client, moved along its heading only.

    Args:
        client: The physics client.
        joints: All joints of its robot.
        spec: What it is and where it starts.
        localiser: Makes the estimated pose from the true one.
        period: Control period [s].
    """

    def __init__(self, client: Client, joints: Joints, spec: BaseSpec, localiser: Localiser, period: float) -> None:
        self.spec = spec
        self._client = client
        self._body = joints.body
        self._plane = joints.indices(("base_x", "base_y", "base_yaw"))
        self._wheels = joints.indices(("wheel_left", "wheel_right"))
        self._localiser = localiser
        self._period = period
        self._linear = 0.0
        self._angular = 0.0
        self._held: tuple[float, float, float] | None = None
        self._standstill = Standstill(_STILL)
        start = (spec.start.position[0], spec.start.position[1], spec.start.yaw)
        for index, value in zip(self._plane, start, strict=True):
            client.resetJointState(self._body, index, value)

    @property
    def braking_time(self) -> float:
        """Time from full speed to standing [s]."""
        spec = self.spec
        return max(spec.max_linear / spec.max_linear_acceleration, spec.max_angular / spec.max_angular_acceleration)

    def command(self, twist: BaseTwist | None) -> None:
        """Drives for one cycle; None brakes."""
        self._limit(twist or _STAND)
        if self._linear == 0.0 and self._angular == 0.0:
            self._stand()
        else:
            self._roll()

    def state(self) -> BaseState:
        """Reads odometry and localiser; to be called once per cycle."""
        (x, vx, *_), (y, vy, *_), (yaw, angular, *_) = self._client.getJointStates(self._body, self._plane)
        linear = vx * math.cos(yaw) + vy * math.sin(yaw)
        speed = math.hypot(vx, vy) + abs(angular)
        still = self._standstill.update(speed)
        pose = _planar(*self._localiser.estimate(x, y, yaw, speed * self._period, still))
        return BaseState(pose, linear, angular, still)

    def true_pose(self) -> Pose:
        """Returns where the base really is in the map; for the truth and for what is bolted to it."""
        return _planar(*self._positions())

    def _limit(self, twist: BaseTwist) -> None:
        if not (math.isfinite(twist.linear) and math.isfinite(twist.angular)):
            raise DeviceError(f"{self.spec.id}: speeds must be finite: {twist}")
        spec = self.spec
        linear = min(max(twist.linear, -spec.max_linear), spec.max_linear)
        angular = min(max(twist.angular, -spec.max_angular), spec.max_angular)
        self._linear = approach(self._linear, linear, spec.max_linear_acceleration * self._period)
        self._angular = approach(self._angular, angular, spec.max_angular_acceleration * self._period)

    def _roll(self) -> None:
        self._held = None
        yaw: float = self._client.getJointState(self._body, self._plane[2])[0]
        heading = yaw + self._angular * self._period / 2.0
        forward = self._linear
        self._drive(
            self._plane, (forward * math.cos(heading), forward * math.sin(heading), self._angular), _DRIVE_FORCE
        )
        turning = self._angular * WHEEL_TRACK / 2.0
        left, right = (forward - turning) / WHEEL_RADIUS, (forward + turning) / WHEEL_RADIUS
        self._drive(self._wheels, (left, right), _WHEEL_TORQUE)

    def _stand(self) -> None:
        """Holds the place where it came to rest: with speeds of zero alone it would creep under the arm's motions."""
        if self._held is None:
            self._held = self._positions()
        self._drive(self._wheels, (0.0, 0.0), _WHEEL_TORQUE)
        self._client.setJointMotorControlArray(
            self._body,
            self._plane,
            self._client.POSITION_CONTROL,
            targetPositions=self._held,
            positionGains=[_HOLDING_GAIN] * 3,
            forces=[_DRIVE_FORCE] * 3,
        )

    def _drive(self, joints: list[int], speeds: tuple[float, ...], force: float) -> None:
        self._client.setJointMotorControlArray(
            self._body, joints, self._client.VELOCITY_CONTROL, targetVelocities=speeds, forces=[force] * len(joints)
        )

    def _positions(self) -> tuple[float, float, float]:
        (x, *_), (y, *_), (yaw, *_) = self._client.getJointStates(self._body, self._plane)
        return x, y, yaw


def _planar(x: float, y: float, yaw: float) -> Pose:
    return Pose((x, y, 0.0), (0.0, 0.0, math.sin(yaw / 2.0), math.cos(yaw / 2.0)))

"""A simulated differential-drive base: speed commands within limits, wheels for the eye, an estimated pose."""

from __future__ import annotations

import math

import numpy as np

from skiros_py.errors import DeviceError
from skiros_py.geometry import Pose
from skiros_py.ports.cell import BaseSpec
from skiros_py.ports.models import BASE_JOINTS, BASE_LINK
from skiros_py.ports.simulation import SimulatedRobot
from skiros_py.ports.values import BaseState, BaseTwist
from skiros_py.simulation.limits import Standstill, approach
from skiros_py.simulation.localiser import Localiser

__all__ = ["SimulatedBase"]

_STILL = 0.002  # [m/s], turning counted as [rad/s]
_DRIVE_FORCE = 2000.0  # [N] and [N m]; enough for every acceleration limit a base of this weight may have
_HOLDING_GAIN = 0.2
_WHEEL_TORQUE = 5.0  # [N m]; wheels carry nothing
_WHEELS = ("wheel_left", "wheel_right")
_STAND = BaseTwist(0.0, 0.0)


class SimulatedBase:
    """The controller of a differential-drive base, which moves along its heading only.

    Args:
        spec: The base, and where it starts.
        robot: The robot that it belongs to.
        rng: Source of the localiser's errors.
    """

    def __init__(self, spec: BaseSpec, robot: SimulatedRobot, rng: np.random.Generator) -> None:
        self.spec = spec
        self._plane = robot.joints(BASE_JOINTS)
        self._wheels = robot.joints(_WHEELS)
        self._radius, self._track = _wheel_geometry(robot)
        self._localiser = Localiser(rng)
        self._period = robot.engine.period
        self._linear = 0.0
        self._angular = 0.0
        self._held: tuple[float, ...] | None = None
        self._standstill = Standstill(_STILL)
        self._plane.reset((spec.start.position[0], spec.start.position[1], spec.start.yaw))

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
        (x, y, yaw), (vx, vy, angular), _ = self._plane.read()
        linear = vx * math.cos(yaw) + vy * math.sin(yaw)
        speed = math.hypot(vx, vy) + abs(angular)
        still = self._standstill.update(speed)
        pose = _planar(*self._localiser.estimate(x, y, yaw, speed * self._period, still))
        return BaseState(pose, linear, angular, still)

    def true_pose(self) -> Pose:
        """Returns the real pose of the base in the map, without the localiser's error; for the truth only."""
        x, y, yaw = self._plane.read().positions
        return _planar(x, y, yaw)

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
        yaw = self._plane.read().positions[2]
        heading = yaw + self._angular * self._period / 2.0
        forward = self._linear
        self._plane.drive_velocities(
            (forward * math.cos(heading), forward * math.sin(heading), self._angular), effort=_DRIVE_FORCE
        )
        turning = self._angular * self._track / 2.0
        left, right = (forward - turning) / self._radius, (forward + turning) / self._radius
        self._wheels.drive_velocities((left, right), effort=_WHEEL_TORQUE)

    def _stand(self) -> None:
        """Holds the place where it came to rest: at zero velocity alone it would creep under the arm's motions."""
        if self._held is None:
            self._held = self._plane.read().positions
        self._wheels.drive_velocities((0.0, 0.0), effort=_WHEEL_TORQUE)
        self._plane.hold_positions(self._held, gain=_HOLDING_GAIN, effort=[_DRIVE_FORCE] * 3)


def _wheel_geometry(robot: SimulatedRobot) -> tuple[float, float]:
    """Returns radius and track of the driving wheels [m]; their axle is one radius above the floor."""
    base = robot.link(BASE_LINK).pose().inverse()
    left, right = (base @ robot.link(link).pose() for link in robot.joints(_WHEELS).links)
    return round(left.position[2], 6), round(left.distance(right), 6)


def _planar(x: float, y: float, yaw: float) -> Pose:
    return Pose((x, y, 0.0), (0.0, 0.0, math.sin(yaw / 2.0), math.cos(yaw / 2.0)))

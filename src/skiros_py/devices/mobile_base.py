"""Differential-drive bases."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from skiros_py.devices.common import BASE_STILL, FakeModel, Standstill, approach
from skiros_py.errors import DeviceError
from skiros_py.geometry import Pose, wrap_angle
from skiros_py.ports.board import DeviceHandle
from skiros_py.ports.device import (
    Contribution,
    DeviceSignal,
    DeviceSpec,
    FakeRobot,
    Follower,
    Individual,
    MobileSpec,
    read_mobile,
    require_numbers,
)
from skiros_py.ports.kinematics import BASE_JOINTS, BASE_LINK
from skiros_py.ports.paths import BaseLeg, BasePath, Path
from skiros_py.ports.simulation import SimulatedRobot

_ALIGNED = math.radians(0.3)
_SHORT = 0.002  # [m] a shorter way counts as none
_ASIDE = 0.06  # [m] greatest distance from the line of a leg; paths keep a larger distance from obstacles
_DRIVE_FORCE = 2000.0  # [N] and [N m]; enough for every acceleration limit a base of this weight may have
_HOLDING_GAIN = 0.2
_WHEEL_TORQUE = 5.0  # [N m]; wheels carry nothing
_WHEELS = ("wheel_left", "wheel_right")


@dataclass(frozen=True, slots=True)
class BaseState:
    """What the wheels of a mobile base say.

    Attributes:
        pose: Pose of the base frame (on the floor) in the map by odometry: from where it started, along the speeds
            that were measured. A localiser knows it better.
        linear: Forward speed [m/s].
        angular: Turning speed, counter-clockwise [rad/s].
        still: True when the base stands.
    """

    pose: Pose
    linear: float
    angular: float
    still: bool


@dataclass(frozen=True, slots=True)
class BaseTwist:
    """Speeds of a differential-drive base for one cycle: forward [m/s] and counter-clockwise [rad/s]."""

    linear: float
    angular: float


@dataclass(frozen=True, slots=True)
class BaseSpec(MobileSpec[BaseState, BaseTwist]):
    """A differential-drive base; without a target it brakes within its limits and stands.

    Attributes:
        id: Its element id.
        start: Pose in the map where it stands at the start.
        footprint: Corners of its outline on the floor in the base frame [m], counter-clockwise.
        max_linear, max_angular: Speed limits [m/s, rad/s].
        max_linear_acceleration, max_angular_acceleration: Acceleration and braking limits [m/s², rad/s²].
    """

    kind: ClassVar[str] = "base"
    device_class: ClassVar[str] = "sk:Base"
    state_type: ClassVar[type] = BaseState
    target_type: ClassVar[type] = BaseTwist
    signals: ClassVar[tuple[DeviceSignal[Any], ...]] = (
        DeviceSignal("x", lambda state: state.pose.position[0], "m", "position by odometry", "map"),
        DeviceSignal("y", lambda state: state.pose.position[1], "m", "position by odometry", "map"),
        DeviceSignal("yaw", lambda state: state.pose.yaw, "rad", "heading by odometry", "map"),
        DeviceSignal("linear", lambda state: state.linear, "m/s", "forward speed", "own"),
        DeviceSignal("angular", lambda state: state.angular, "rad/s", "turning speed", "own"),
        DeviceSignal("still", lambda state: state.still, help="whether it stands"),
    )
    jog: ClassVar[tuple[str, ...]] = ("jog_base",)
    teach: ClassVar[tuple[str, ...]] = ("teach_driving_pose",)

    max_linear: float
    max_angular: float
    max_linear_acceleration: float
    max_angular_acceleration: float

    @classmethod
    def read(cls, individual: Individual) -> Self:
        """Reads where it starts, its outline and its limits."""
        return cls(
            individual.id,
            *read_mobile(individual),
            individual.number("sk:maxLinear"),
            individual.number("sk:maxAngular"),
            individual.number("sk:maxLinearAcceleration"),
            individual.number("sk:maxAngularAcceleration"),
        )

    def fake(self, robot: FakeRobot) -> FakeBase:
        """Returns a base that drives exactly as commanded, with exact odometry."""

        def driven(state: BaseState, target: BaseTwist | None) -> BaseState:
            if target is None:
                return BaseState(state.pose, 0.0, 0.0, True)
            step = _step(target.linear * robot.period, target.angular * robot.period)
            still = not (target.linear or target.angular)
            return BaseState(state.pose @ step, target.linear, target.angular, still)

        return FakeBase(BaseState(self.start, 0.0, 0.0, True), driven)

    def simulate(self, robot: SimulatedRobot, rng: np.random.Generator) -> SimulatedBase:  # noqa: ARG002 - nothing is drawn
        """Returns its controller in a simulation."""
        return SimulatedBase(self, robot)

    def pose(self, state: BaseState) -> Pose:
        """Returns its pose in the map, by odometry."""
        return state.pose

    def still(self, state: BaseState) -> bool:
        """Returns True when it stands."""
        return state.still

    def check(self, target: BaseTwist) -> None:
        """Refuses what is no twist, or has numbers that are none."""
        DeviceSpec.check(self, target)
        require_numbers(self.id, target, (target.linear, target.angular))

    def follow(
        self, path: Path, pose: Callable[[], Pose], *, max_linear: float = math.inf, max_angular: float = math.inf
    ) -> Follower[BaseTwist]:
        """Turns and drives straight, leg by leg, and turns at the end.

        Raises:
            DeviceError: The path is not made of such legs.
        """
        if not isinstance(path, BasePath):
            raise DeviceError(f"{self.id}: it turns and drives straight, it cannot follow a {type(path).__name__}")
        linear, angular = min(max_linear, self.max_linear), min(max_angular, self.max_angular)
        for number, leg in enumerate(path.legs):
            yield from self._turn(number, leg.heading(pose()), pose, angular)
            if not (yield from self._straight(number, leg, pose, linear)):
                return False
        yield from self._turn(len(path.legs), path.heading, pose, angular)
        return True

    def _turn(self, driven: int, heading: float, pose: Callable[[], Pose], fastest: float) -> Follower[BaseTwist]:
        while abs(error := wrap_angle(heading - pose().yaw)) >= _ALIGNED:
            speed = min(fastest, math.sqrt(1.6 * self.max_angular_acceleration * abs(error)), 4.0 * abs(error))
            yield driven, BaseTwist(0.0, math.copysign(speed, error))
        return True

    def _straight(self, driven: int, leg: BaseLeg, pose: Callable[[], Pose], fastest: float) -> Follower[BaseTwist]:
        """Follows the line from here to the leg's end, steering by heading and distance from the line."""
        start = pose()
        x0, y0, _ = start.position
        length = math.hypot(leg.x - x0, leg.y - y0)
        if length < _SHORT:
            return True
        ux, uy, sign = (leg.x - x0) / length, (leg.y - y0) / length, -1.0 if leg.backwards else 1.0
        along = math.atan2(sign * uy, sign * ux)
        while True:
            here = pose()
            x, y, _ = here.position
            left = length - ((x - x0) * ux + (y - y0) * uy)
            if left < _SHORT:
                return True
            aside = -(x - x0) * uy + (y - y0) * ux
            if abs(aside) > _ASIDE:
                return False
            turned = wrap_angle(along - here.yaw)
            speed = min(fastest, math.sqrt(2.0 * 0.8 * self.max_linear_acceleration * left), 4.0 * left)
            speed *= max(0.0, math.cos(turned))
            steer = 2.5 * turned - sign * 4.0 * aside * speed
            twist = BaseTwist(sign * speed, max(-self.max_angular, min(self.max_angular, steer)))
            yield driven + 1.0 - left / length, twist

    def scaled(self, target: BaseTwist, rate: float) -> BaseTwist:
        """Returns a slower twist."""
        return BaseTwist(target.linear * rate, target.angular * rate)

    def mixed(self, contributions: Sequence[Contribution[BaseTwist]]) -> BaseTwist:
        """Returns the weighted mean of the twists."""
        weights = [one.weight for one in contributions]
        twists = [(one.target.linear, one.target.angular) for one in contributions]
        linear, angular = np.average(twists, axis=0, weights=weights).tolist()
        return BaseTwist(linear, angular)

    def noisy(self, state: BaseState, sigma: float, rng: np.random.Generator) -> BaseState:
        """Returns a state with noise on x and y [m] and on the heading [rad]."""
        x, y, turn = map(float, rng.normal(0.0, sigma, 3))
        return replace(state, pose=state.pose @ Pose.of(x, y, 0.0, yaw=turn))


class Base(DeviceHandle[BaseSpec, BaseState, BaseTwist]):
    """A base in the hands of a primitive; without a command it brakes, and it slows down while the run is paused."""

    spec_type: ClassVar[Any] = BaseSpec


class FakeBase(FakeModel[BaseState, BaseTwist]):
    """A base without physics, with exact odometry."""


class SimulatedBase:
    """The controller of a differential-drive base, which moves along its heading only.

    Args:
        spec: The base, and where it starts.
        robot: The robot that it belongs to.
    """

    def __init__(self, spec: BaseSpec, robot: SimulatedRobot) -> None:
        self.spec = spec
        self._plane = robot.joints(BASE_JOINTS)
        self._wheels = robot.joints(_WHEELS)
        self._radius, self._track = _wheel_geometry(robot)
        self._odometry = spec.start
        self._period = robot.engine.period
        self._linear = 0.0
        self._angular = 0.0
        self._held: tuple[float, ...] | None = None
        self._standstill = Standstill(BASE_STILL)
        self._plane.reset((spec.start.position[0], spec.start.position[1], spec.start.yaw))

    @property
    def braking_time(self) -> float:
        """Time from full speed to standing [s]."""
        spec = self.spec
        return max(spec.max_linear / spec.max_linear_acceleration, spec.max_angular / spec.max_angular_acceleration)

    def command(self, twist: BaseTwist | None) -> None:
        """Drives for one cycle; None brakes."""
        self._limit(twist or BaseTwist(0.0, 0.0))
        if self._linear == 0.0 and self._angular == 0.0:
            self._stand()
        else:
            self._roll()

    def state(self) -> BaseState:
        """Reads the speeds and adds them to the odometry; to be called once per cycle."""
        (_, _, yaw), (vx, vy, angular), _ = self._plane.read()
        linear = vx * math.cos(yaw) + vy * math.sin(yaw)
        still = self._standstill.update(math.hypot(vx, vy) + abs(angular))
        self._odometry @= _step(linear * self._period, angular * self._period)
        return BaseState(self._odometry, linear, angular, still)

    def _limit(self, twist: BaseTwist) -> None:
        spec = self.spec
        spec.check(twist)
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
        self._held = self._held or self._plane.read().positions
        self._wheels.drive_velocities((0.0, 0.0), effort=_WHEEL_TORQUE)
        self._plane.hold_positions(self._held, gain=_HOLDING_GAIN, effort=[_DRIVE_FORCE] * 3)


def _wheel_geometry(robot: SimulatedRobot) -> tuple[float, float]:
    """Returns radius and track of the driving wheels [m]; their axle is one radius above the floor."""
    base = robot.link(BASE_LINK).pose().inverse()
    left, right = (base @ robot.link(link).pose() for link in robot.joints(_WHEELS).links)
    return round(left.position[2], 6), round(left.distance(right), 6)


def _step(way: float, turn: float) -> Pose:
    """Returns the motion of one cycle: straight along its mean heading, exact for pure driving or turning."""
    return Pose.of(way * math.cos(turn / 2.0), way * math.sin(turn / 2.0), 0.0, yaw=turn)

"""Bases on wheels: with a differential drive, or omnidirectional ones that drive sideways, too."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from skiros_py.devices.base_curves import Curve, Place, Speeds
from skiros_py.devices.common import BASE_STILL, FakeModel, Standstill, approach
from skiros_py.errors import DeviceError
from skiros_py.geometry import Array, Pose, wrap_angle
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

_ALIGNED = math.radians(0.15)
_SHORT = 0.002  # [m] a shorter way counts as none
_ASIDE = 0.06  # [m] greatest distance from the line of a leg; paths keep a larger distance from obstacles
_DRIVE_FORCE = 160.0  # [N] and [N m]; enough for the acceleration limits of a base of 100 kg, and not to crush
_HOLDING = 3.75  # what braked wheels hold by friction, per force of the drives
_SLOWED = 0.003  # [m/s] a base this much slower than its drives were to make it is slowed from outside
_HINDERED = 0.02  # [rad/s] the same for turning
_YIELDING = 0.25  # share of the force that its drives still exert where it has met something: it is pushed back
_PUSHED_BACK = 0.15  # [m/s, rad/s]; where it is pushed back faster, it brakes
_YIELDING_TIME = 0.5  # [s]; the swinging of its arms does not push it away for longer
_HOLDING_GAIN = 0.2
_WHEEL_TORQUE = 5.0  # [N m]; wheels carry nothing
_WHEELS = ("wheel_left", "wheel_right")
_MECANUM = ("wheel_front_left", "wheel_front_right", "wheel_rear_left", "wheel_rear_right")


@dataclass(frozen=True, slots=True)
class BaseState:
    """What the wheels of a mobile base say.

    Attributes:
        pose: Pose of the base frame (on the floor) in the map by odometry: from where it started, along the speeds
            that were measured. A localiser knows it better.
        linear: Forward speed [m/s].
        angular: Turning speed, counter-clockwise [rad/s].
        still: True when the base stands.
        force: Forward force of its drives [N]; None where it is not measured.
        torque: What they exert to turn it, counter-clockwise [N m]; None where it is not measured.
        sideways: Speed to the left [m/s].
        side_force: Force of its drives to the left [N].
    """

    pose: Pose
    linear: float
    angular: float
    still: bool
    force: float | None = None
    torque: float | None = None
    sideways: float = 0.0
    side_force: float = 0.0


@dataclass(frozen=True, slots=True)
class BaseTwist:
    """Speeds of a base for one cycle: forward [m/s], counter-clockwise [rad/s], and to the left [m/s]."""

    linear: float
    angular: float
    sideways: float = 0.0


@dataclass(frozen=True, slots=True)
class BaseSpec(MobileSpec[BaseState, BaseTwist]):
    """A base on wheels; without a target it brakes within its limits and stands.

    Attributes:
        id: Its element id.
        start: Pose in the map where it stands at the start.
        footprint: Corners of its outline on the floor in the base frame [m], counter-clockwise.
        max_linear, max_angular: Speed limits [m/s, rad/s].
        max_linear_acceleration, max_angular_acceleration: Acceleration and braking limits [m/s², rad/s²].
        max_sideways: Speed limit sideways of an omnidirectional base [m/s]; 0 for a differential drive.
        drive_force: What the drives exert at most to move it [N], and to turn it [N m].
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
        DeviceSignal("sideways", lambda state: state.sideways, "m/s", "speed to the left", "own"),
        DeviceSignal("force", lambda state: state.force or 0.0, "N", "forward force of the drives", "own"),
        DeviceSignal("torque", lambda state: state.torque or 0.0, "N m", "turning moment of the drives", "own"),
        DeviceSignal("still", lambda state: state.still, help="whether it stands"),
    )
    jog: ClassVar[tuple[str, ...]] = ("jog_base",)
    teach: ClassVar[tuple[str, ...]] = ("teach_driving_pose",)

    max_linear: float
    max_angular: float
    max_linear_acceleration: float
    max_angular_acceleration: float
    max_sideways: float = 0.0
    drive_force: float = _DRIVE_FORCE

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
            individual.number("sk:maxSideways", 0.0),
            individual.number("sk:driveForce", _DRIVE_FORCE),
        )

    def fake(self, robot: FakeRobot) -> FakeBase:
        """Returns a base that drives exactly as commanded, with exact odometry."""

        def driven(state: BaseState, target: BaseTwist | None) -> BaseState:
            if target is None:
                return BaseState(state.pose, 0.0, 0.0, True)
            speeds = (target.linear, target.sideways, target.angular)
            step = _step(*(speed * robot.period for speed in speeds))
            return BaseState(
                state.pose @ step, target.linear, target.angular, not any(speeds), sideways=target.sideways
            )

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
        """Refuses what is no twist, has numbers that are none, or drives sideways what cannot."""
        DeviceSpec.check(self, target)
        require_numbers(self.id, target, (target.linear, target.angular, target.sideways))
        if target.sideways and not self.drives_sideways:
            raise DeviceError(f"{self.id}: a differential drive does not drive sideways: {target}")

    @property
    def drives_sideways(self) -> bool:
        """Whether it is an omnidirectional base."""
        return self.max_sideways > 0.0

    def direct_path(self, start: Pose, goal: Pose) -> Path:
        """Returns the path on which it drives a short way: straight, turning meanwhile, if it is omnidirectional."""
        if not self.drives_sideways or math.dist(start.position[:2], goal.position[:2]) < _SHORT:
            return MobileSpec.direct_path(self, start, goal)
        return BasePath((BaseLeg.gliding(start, goal),), goal.yaw)

    def follow(
        self, path: Path, pose: Callable[[], Pose], *, max_linear: float = math.inf, max_angular: float = math.inf
    ) -> Follower[BaseTwist]:
        """Turns towards each leg, drives it, and turns at the end.

        Raises:
            DeviceError: The path is not made of such legs.
        """
        if not isinstance(path, BasePath):
            raise DeviceError(f"{self.id}: it turns and drives ahead, it cannot follow a {type(path).__name__}")
        if any(leg.glides for leg in path.legs) and not self.drives_sideways:
            raise DeviceError(f"{self.id}: a differential drive cannot follow a path that goes sideways")
        linear, angular = min(max_linear, self.max_linear), min(max_angular, self.max_angular)
        for number, leg in enumerate(path.legs):
            yield from self._turn(number, leg.heading(pose()), pose, angular)
            if not (yield from self._drive(number, Curve(leg, pose()), pose, self._speeds(linear, angular))):
                return False
        yield from self._turn(len(path.legs), path.heading, pose, angular)
        return True

    def _turn(self, driven: int, heading: float, pose: Callable[[], Pose], fastest: float) -> Follower[BaseTwist]:
        while abs(error := wrap_angle(heading - pose().yaw)) >= _ALIGNED:
            speed = min(fastest, math.sqrt(1.6 * self.max_angular_acceleration * abs(error)), _SETTLING * abs(error))
            yield driven, BaseTwist(0.0, math.copysign(speed, error))
        return True

    def _speeds(self, linear: float, angular: float) -> Speeds:
        sideways = min(linear, self.max_sideways)
        return Speeds(linear, angular, self.max_linear_acceleration, self.max_angular_acceleration, sideways)

    def _drive(self, driven: int, curve: Curve, pose: Callable[[], Pose], speeds: Speeds) -> Follower[BaseTwist]:
        """Follows a curve as fast as braking and steering allow."""
        if curve.length < _SHORT:
            return True
        steer = self._glided if curve.glides else self._steered
        fastest, drift, before = speeds.along(curve), 0.0, 0.0
        while True:
            place = curve.nearest(pose())
            at = place.along
            left = curve.length - at
            drift, before = drift + place.aside * abs(curve.rates(at)[0]) * (at - before), at
            if left < _SHORT:
                return True
            if math.hypot(place.aside, place.behind) > _ASIDE:
                return False
            rate = min(float(np.interp(at, curve.along, fastest)), _SETTLING * left) * max(0.0, math.cos(place.turned))
            yield driven + 1.0 - left / curve.length, steer(curve, place, rate, drift)

    def _steered(self, curve: Curve, place: Place, rate: float, drift: float) -> BaseTwist:
        """Steers by heading and distance from a curve.

        The feedback is that of Samson (1995) for a point on the path next to the base.
        """
        ahead, _, turn = curve.rates(place.along)
        speed, left = ahead * rate, curve.length - place.along
        stiff = min(_STIFFEST, max(_STIFFNESS, _RETURNS / left))
        offset = stiff**2 * place.aside + _STIFFNESS**3 / 8.0 * drift  # without the sum, an error in heading stays
        steer = turn * rate - speed * offset + 2.0 * stiff * max(abs(speed), _CRAWL) * place.turned
        return BaseTwist(speed + _CATCHING_UP * place.behind, max(-self.max_angular, min(self.max_angular, steer)))

    def _glided(self, curve: Curve, place: Place, rate: float, drift: float) -> BaseTwist:  # noqa: ARG002 - needs no sum
        """Drives along a curve and straight back to it, whatever the heading."""
        ahead, left, turn = (rate * one for one in curve.rates(place.along))
        ahead, left = ahead + _PULL * place.behind, left - _PULL * place.aside
        cos, sin = math.cos(place.turned), math.sin(place.turned)
        return BaseTwist(ahead * cos - left * sin, turn + _PULL * place.turned, ahead * sin + left * cos)

    def scaled(self, target: BaseTwist, rate: float) -> BaseTwist:
        """Returns a slower twist."""
        return BaseTwist(target.linear * rate, target.angular * rate, target.sideways * rate)

    def mixed(self, contributions: Sequence[Contribution[BaseTwist]]) -> BaseTwist:
        """Returns the weighted mean of the twists."""
        weights = [one.weight for one in contributions]
        twists = [(one.target.linear, one.target.angular, one.target.sideways) for one in contributions]
        return BaseTwist(*np.average(twists, axis=0, weights=weights).tolist())

    def noisy(self, state: BaseState, sigma: float, rng: np.random.Generator) -> BaseState:
        """Returns a state with noise on x and y [m] and on the heading [rad]."""
        x, y, turn = map(float, rng.normal(0.0, sigma, 3))
        return replace(state, pose=state.pose @ Pose.of(x, y, 0.0, yaw=turn))


_SETTLING = 8.0
"""Speed per distance from the end of a motion [1/s]."""
_STIFFNESS = 8.0
"""Inverse of the way on which a base comes back to its path [1/m]; critically damped."""
_STIFFEST, _RETURNS = 16.0, 4.0
"""The most it may be [1/m], and how many times that way should fit into what is left of a leg."""
_CRAWL = 0.1
"""Speed below which steering by the heading does not become weaker [m/s]."""
_CATCHING_UP = 2.0
"""Speed per distance from its place on a curve, where that only turns [1/s]."""
_PULL = 4.0
"""Speed per distance from its place on a curve on which a base glides [1/s]."""


class Base(DeviceHandle[BaseSpec, BaseState, BaseTwist]):
    """A base in the hands of a primitive; without a command it brakes, and it slows down while the run is paused."""

    spec_type: ClassVar[Any] = BaseSpec


class FakeBase(FakeModel[BaseState, BaseTwist]):
    """A base without physics, with exact odometry."""


class SimulatedBase:
    """The controller of a base on wheels; one with a differential drive moves along its heading only.

    Args:
        spec: The base, and where it starts.
        robot: The robot that it belongs to.
    """

    def __init__(self, spec: BaseSpec, robot: SimulatedRobot) -> None:
        self.spec = spec
        self._plane = robot.joints(BASE_JOINTS)
        self._wheels = robot.joints(_MECANUM if spec.drives_sideways else _WHEELS)
        self._rolling = _rolling(robot, self._wheels.links)
        self._x, self._y, self._z = spec.start.position
        self._yaw = spec.start.yaw
        self._period = robot.engine.period
        self._wanted = self._measured = BaseTwist(0.0, 0.0)
        self._is_still = True
        self._resisted: BaseTwist | None = None  # how it drove when something began to slow it
        self._yields = 0.0  # for how long it still gives way [s]
        self._held: tuple[float, ...] | None = None
        self._standstill = Standstill(BASE_STILL)
        self._plane.reset((spec.start.position[0], spec.start.position[1], spec.start.yaw))

    @property
    def braking_time(self) -> float:
        """Time from full speed to standing [s]."""
        spec = self.spec
        return max(spec.max_linear / spec.max_linear_acceleration, spec.max_angular / spec.max_angular_acceleration)

    def command(self, twist: BaseTwist | None) -> None:
        """Drives for one cycle; None brakes.

        A base that something from outside slows does not push on: it brakes as hard as it can, then lets itself be
        pushed back until it stands, for half a second at most. What is commanded counts from then on.
        """
        wanted = twist or BaseTwist(0.0, 0.0)
        self.spec.check(wanted)
        if self._resisted is None and self._is_slowed():
            self._resisted, self._yields = self._wanted, _YIELDING_TIME
        elif self._is_still or self._yields <= 0.0:
            self._resisted = None
        if self._resisted is not None:
            self._let_go(self._resisted)
            return
        self._limit(wanted)
        if self._wanted == BaseTwist(0.0, 0.0):
            self._stand()
        else:
            self._roll()

    def state(self) -> BaseState:
        """Reads the speeds and adds them to the odometry; to be called once per cycle."""
        (_, _, yaw), (vx, vy, angular), (fx, fy, torque) = self._plane.read()
        cos, sin = math.cos(yaw), math.sin(yaw)
        linear, sideways = vx * cos + vy * sin, (vy * cos - vx * sin if self.spec.drives_sideways else 0.0)
        self._measured = BaseTwist(linear, angular, sideways)
        self._is_still = still = self._standstill.update(math.hypot(vx, vy) + abs(angular))
        turn = angular * self._period
        heading = self._yaw + turn / 2.0  # the mean one of the cycle: exact for pure driving or turning
        self._x += (linear * math.cos(heading) - sideways * math.sin(heading)) * self._period
        self._y += (linear * math.sin(heading) + sideways * math.cos(heading)) * self._period
        self._yaw += turn
        pose = Pose.of(self._x, self._y, self._z, yaw=self._yaw)
        force, aside = fx * cos + fy * sin, fy * cos - fx * sin
        return BaseState(pose, linear, angular, still, force, torque, sideways, aside)

    def _is_slowed(self) -> bool:
        """Returns whether it is slower than its drives were to make it in the last cycle, which includes braking."""
        wanted, measured = self._wanted, self._measured
        lags = (
            (wanted.linear, measured.linear, _SLOWED),
            (wanted.sideways, measured.sideways, _SLOWED),
            (wanted.angular, measured.angular, _HINDERED),
        )
        return any(math.copysign(1.0, wanted) * (wanted - measured) > most for wanted, measured, most in lags if wanted)

    def _let_go(self, resisted: BaseTwist) -> None:
        """Stops, and gives way to what pushes it back."""
        self._yields -= self._period
        measured = self._wanted = self._measured
        self._held = None
        ahead = math.copysign(measured.linear, resisted.linear * measured.linear)
        aside = math.copysign(measured.sideways, resisted.sideways * measured.sideways)
        around = math.copysign(measured.angular, resisted.angular * measured.angular)
        if max(ahead, aside) > _SLOWED or around > _HINDERED:
            effort = _HOLDING * self.spec.drive_force
        else:
            yields = min(ahead, aside, around) > -_PUSHED_BACK
            effort = (_YIELDING if yields else 1.0) * self.spec.drive_force
        self._wheels.drive_velocities([0.0] * len(self._rolling), effort=_WHEEL_TORQUE)
        self._plane.drive_velocities((0.0, 0.0, 0.0), effort=effort)

    def _limit(self, twist: BaseTwist) -> None:
        spec, before = self.spec, self._wanted
        most, turning = spec.max_linear_acceleration * self._period, spec.max_angular_acceleration * self._period
        linear = min(max(twist.linear, -spec.max_linear), spec.max_linear)
        angular = min(max(twist.angular, -spec.max_angular), spec.max_angular)
        sideways = min(max(twist.sideways, -spec.max_sideways), spec.max_sideways)
        self._wanted = BaseTwist(
            approach(before.linear, linear, most),
            approach(before.angular, angular, turning),
            approach(before.sideways, sideways, most),
        )

    def _roll(self) -> None:
        self._held = None
        wanted = self._wanted
        linear, sideways, angular = wanted.linear, wanted.sideways, wanted.angular
        heading = self._plane.read().positions[2] + angular * self._period / 2.0
        cos, sin = math.cos(heading), math.sin(heading)
        velocities = linear * cos - sideways * sin, linear * sin + sideways * cos, angular
        self._plane.drive_velocities(velocities, effort=self.spec.drive_force)
        speeds = (self._rolling @ (linear, sideways, angular)).tolist()
        self._wheels.drive_velocities(speeds, effort=_WHEEL_TORQUE)

    def _stand(self) -> None:
        """Holds the place where it came to rest: at zero velocity alone it would creep under the arm's motions."""
        self._held = self._held or self._plane.read().positions
        self._wheels.drive_velocities([0.0] * len(self._rolling), effort=_WHEEL_TORQUE)
        self._plane.hold_positions(self._held, gain=_HOLDING_GAIN, effort=[_HOLDING * self.spec.drive_force] * 3)


def _rolling(robot: SimulatedRobot, wheels: Sequence[str]) -> Array:
    """Returns how fast each wheel turns per speed ahead, to the left and around; their axles are one radius up.

    Wheels beside the middle roll ahead only; others are Mecanum wheels, their rollers at 45 degrees.
    """
    base = robot.link(BASE_LINK).pose().inverse()
    rows = []
    for wheel in wheels:
        x, y, radius = (round(float(one), 6) for one in (base @ robot.link(wheel).pose()).position)
        slant = -math.copysign(1.0, x * y) if x and y else 0.0
        rows.append((1.0 / radius, slant / radius, (slant * x - y) / radius))
    return np.array(rows)


def _step(way: float, aside: float, turn: float) -> Pose:
    """Returns the motion of one cycle: straight along its mean heading, exact for pure driving or turning."""
    cos, sin = math.cos(turn / 2.0), math.sin(turn / 2.0)
    return Pose.of(way * cos - aside * sin, way * sin + aside * cos, 0.0, yaw=turn)

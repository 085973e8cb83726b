"""Differential-drive bases."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import dropwhile
from typing import Any, ClassVar, Self

import numpy as np

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
_DRIVE_FORCE = 160.0  # [N] and [N m]; enough for the acceleration limits of a base of this weight, and not to crush
_HOLDING_FORCE = 600.0  # [N] and [N m]; what braked wheels hold by friction
_SLOWED = 0.003  # [m/s] a base this much slower than its drives were to make it is slowed from outside
_HINDERED = 0.02  # [rad/s] the same for turning
_YIELDING_FORCE = 40.0  # [N]; what its drives still exert where it has met something: it is pushed back
_PUSHED_BACK = 0.15  # [m/s, rad/s]; where it is pushed back faster, it brakes
_YIELDING_TIME = 0.5  # [s]; the swinging of its arms does not push it away for longer
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
        force: Forward force of its drives [N]; None where it is not measured.
        torque: What they exert to turn it, counter-clockwise [N m]; None where it is not measured.
    """

    pose: Pose
    linear: float
    angular: float
    still: bool
    force: float | None = None
    torque: float | None = None


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
        """Turns towards each leg, drives it, and turns at the end.

        Raises:
            DeviceError: The path is not made of such legs.
        """
        if not isinstance(path, BasePath):
            raise DeviceError(f"{self.id}: it turns and drives ahead, it cannot follow a {type(path).__name__}")
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
        return Speeds(linear, angular, self.max_linear_acceleration, self.max_angular_acceleration)

    def _drive(self, driven: int, curve: Curve, pose: Callable[[], Pose], speeds: Speeds) -> Follower[BaseTwist]:
        """Follows a curve as fast as braking and steering allow, steering by heading and distance from it.

        The feedback is that of Samson (1995) for a point on the path next to the base.
        """
        if curve.length < _SHORT:
            return True
        fastest, drift, before = speeds.along(curve), 0.0, 0.0
        while True:
            at, behind, aside, turned = curve.nearest(pose())
            ahead, turn = curve.rates(at)
            left = curve.length - at
            drift, before = drift + aside * abs(ahead) * (at - before), at
            if left < _SHORT:
                return True
            if math.hypot(aside, behind) > _ASIDE:
                return False
            rate = min(float(np.interp(at, curve.along, fastest)), _SETTLING * left) * max(0.0, math.cos(turned))
            speed = ahead * rate
            stiff = min(_STIFFEST, max(_STIFFNESS, _RETURNS / left))
            offset = stiff**2 * aside + _STIFFNESS**3 / 8.0 * drift  # without the sum, an error in heading stays
            steer = turn * rate - speed * offset + 2.0 * stiff * max(abs(speed), _CRAWL) * turned
            twist = BaseTwist(speed + _CATCHING_UP * behind, max(-self.max_angular, min(self.max_angular, steer)))
            yield driven + 1.0 - left / curve.length, twist

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


_SETTLING = 8.0
"""Speed per distance from the end of a motion [1/s]."""
_SHARES = (0.95, 0.87)
"""Share of the limits of driving and turning that is planned with; the rest is left for corrections."""
_BLIND = 0.4
"""Greatest speed backwards, where scanners that look ahead see nothing [m/s]."""
_STIFFNESS = 8.0
"""Inverse of the way on which a base comes back to its path [1/m]; critically damped."""
_STIFFEST, _RETURNS = 16.0, 4.0
"""The most it may be [1/m], and how many times that way should fit into what is left of a leg."""
_CRAWL = 0.1
"""Speed below which steering by the heading does not become weaker [m/s]."""
_CATCHING_UP = 2.0
"""Speed per distance from its place on a curve, where that only turns [1/s]."""
_GRID = 0.01
"""Distance between points of a curve [m]."""
_AHEAD = 60
"""Number of points ahead of the last one among which the nearest one is looked for."""
_NEAR = 0.05
"""Points of a curve this near to its beginning tell no direction, since the base is some millimetres beside it [m]."""
_LEVER = 0.4
"""How much a turn counts as way on a curve [m/rad]."""


class Curve:
    """The way of one leg, from where the base stands: what it drives and what it turns.

    Attributes:
        along: Ways from the beginning at even steps [m], shape (n,); a turn by 1 rad counts as 0.4 m.
        length: [m].

    Args:
        leg: The leg.
        start: Where the base stands.
        grid: Distance between the points [m].
    """

    def __init__(self, leg: BaseLeg, start: Pose, grid: float = _GRID) -> None:
        first, *via, last = leg.points(start)
        points = np.array([first, *dropwhile(lambda point: math.dist(point[:2], first[:2]) < _NEAR, via), last])
        points[:, 2] = np.unwrap(points[:, 2])
        way, turn = self._driven(points)
        steps = np.abs(way) + _LEVER * np.abs(turn)
        kept = steps > 1e-9
        points, way, turn, steps = points[np.concatenate([[True], kept])], way[kept], turn[kept], steps[kept]
        ends = np.concatenate([[0.0], np.cumsum(steps)])
        self.length = float(ends[-1])
        self.along = np.linspace(0.0, self.length, max(2, math.ceil(self.length / grid) + 1))
        self._points = np.column_stack([np.interp(self.along, ends, column) for column in points.T])
        # Rates are known in the middle of each step: in between they change evenly.
        middles = (ends[1:] + ends[:-1]) / 2.0 if len(steps) else np.zeros(1)
        rates = (way / steps, turn / steps) if len(steps) else (np.zeros(1), np.zeros(1))
        self.ahead, self.turn = (np.interp(self.along, middles, rate) for rate in rates)
        self._index = 0

    @staticmethod
    def _driven(points: Array) -> tuple[Array, Array]:
        """Returns what is driven, negative in reverse [m], and turned [rad] in each step."""
        dx, dy, turn = np.diff(points, axis=0).T
        yaw = points[:-1, 2] + turn / 2.0
        return np.copysign(np.hypot(dx, dy), dx * np.cos(yaw) + dy * np.sin(yaw)), turn

    def nearest(self, pose: Pose) -> tuple[float, float, float, float]:
        """Returns the nearest place ahead.

        Returns:
            How far along it is [m]; how far ahead of the base it is, in its heading, and how far left of it the base is
            [m]; and the angle by which the base has to turn [rad].
        """
        x, y, _ = pose.position
        away = self._points[self._index : self._index + _AHEAD] - (x, y, pose.yaw)
        away[:, 2] = _LEVER * ((away[:, 2] + math.pi) % (2.0 * math.pi) - math.pi)
        nearest = int(np.argmin((away**2).sum(axis=1)))
        self._index += nearest
        dx, dy, turned = away[nearest].tolist()
        ahead, turn, yaw = (float(one[self._index]) for one in (self.ahead, self.turn, self._points[:, 2]))
        behind, aside = dx * math.cos(yaw) + dy * math.sin(yaw), dx * math.sin(yaw) - dy * math.cos(yaw)
        past = -(behind * ahead + turned * _LEVER * turn) / (ahead**2 + (_LEVER * turn) ** 2)
        at = float(self.along[self._index]) + past
        return at, behind + past * ahead, aside, turned / _LEVER + past * turn

    def rates(self, along: float) -> tuple[float, float]:
        """Returns how much is driven, negative in reverse, and turned [rad] for each metre of the way at a place."""
        return float(np.interp(along, self.along, self.ahead)), float(np.interp(along, self.along, self.turn))


@dataclass(frozen=True, slots=True)
class Speeds:
    """Limits of speed and acceleration [m/s, rad/s, m/s², rad/s²]."""

    linear: float
    angular: float
    acceleration: float
    angular_acceleration: float

    def along(self, curve: Curve, *, start: float = math.inf) -> Array:
        """Returns the greatest rates of way at the points of a curve [m/s], which ends at rest.

        The rates are found backwards, from where the base can still brake, and then forwards: Pham and Pham, "A new
        approach to time-optimal path parameterization based on reachability analysis" (2018), for two velocities.

        Args:
            curve: The curve.
            start: Rate at its beginning [m/s].
        """
        step = float(curve.along[1] - curve.along[0])
        fastest = np.where(curve.ahead < 0.0, min(self.linear, _BLIND), self.linear)
        squared = np.full(len(curve.along), math.inf)
        parts = []
        pushes = _SHARES[0] * self.acceleration, _SHARES[1] * self.angular_acceleration
        for share, speed, limit in zip(
            (curve.ahead, curve.turn), (fastest, _SHARES[1] * self.angular), pushes, strict=True
        ):
            size = np.maximum(np.abs(share), 1e-9)  # a velocity is share * rate
            bend = np.gradient(share, step) * np.where(share < 0.0, -1.0, 1.0)
            squared = np.minimum(squared, (speed / size) ** 2)
            parts.append((size, bend, limit))
        (ahead, jolt, push), (turn, swerve, swing) = parts
        both = np.maximum(np.abs(jolt * turn - swerve * ahead), 1e-9)  # where one limit asks for what the other forbids
        squared = np.minimum(squared, (push * turn + swing * ahead) / both)
        squared[0], squared[-1] = min(squared[0], start**2), 0.0
        found = squared.tolist()
        gains = (2.0 * step * np.column_stack([push / ahead, jolt / ahead, swing / turn, swerve / turn])).tolist()
        for index in range(len(found) - 2, -1, -1):
            driving, bending, turning, swerving = gains[index]
            after = found[index + 1]
            if bending < 1.0:
                found[index] = min(found[index], (after + driving) / (1.0 - bending))
            if swerving < 1.0:
                found[index] = min(found[index], (after + turning) / (1.0 - swerving))
        for index, (driving, bending, turning, swerving) in enumerate(gains[:-1]):
            here = found[index]
            gain = min(driving - bending * here, turning - swerving * here)
            found[index + 1] = max(0.0, min(found[index + 1], here + gain))
        return np.asarray(np.sqrt(found))

    def duration(self, curve: Curve) -> float:
        """Returns how long a curve takes from rest to rest [s]."""
        rates = self.along(curve, start=0.0)
        return float(2.0 * (np.diff(curve.along) / np.maximum(1e-6, rates[1:] + rates[:-1])).sum())

    def turning(self, angle: float) -> float:
        """Returns how long a turn on the spot by an angle [rad] takes [s]."""
        angle, quick = abs(angle), self.angular**2 / self.angular_acceleration
        full = angle / self.angular + self.angular / self.angular_acceleration
        return full if angle > quick else 2.0 * math.sqrt(angle / self.angular_acceleration)


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
        self._x, self._y, self._z = spec.start.position
        self._yaw = spec.start.yaw
        self._period = robot.engine.period
        self._linear = 0.0
        self._angular = 0.0
        self._measured = BaseTwist(0.0, 0.0)
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
            self._resisted, self._yields = BaseTwist(self._linear, self._angular), _YIELDING_TIME
        elif self._is_still or self._yields <= 0.0:
            self._resisted = None
        if self._resisted is not None:
            self._let_go(self._resisted)
            return
        self._limit(wanted)
        if self._linear == 0.0 and self._angular == 0.0:
            self._stand()
        else:
            self._roll()

    def state(self) -> BaseState:
        """Reads the speeds and adds them to the odometry; to be called once per cycle."""
        (_, _, yaw), (vx, vy, angular), (fx, fy, torque) = self._plane.read()
        linear = vx * math.cos(yaw) + vy * math.sin(yaw)
        force = fx * math.cos(yaw) + fy * math.sin(yaw)
        self._measured = BaseTwist(linear, angular)
        self._is_still = still = self._standstill.update(math.hypot(vx, vy) + abs(angular))
        turn = angular * self._period
        heading = self._yaw + turn / 2.0  # the mean one of the cycle: exact for pure driving or turning
        self._x += linear * self._period * math.cos(heading)
        self._y += linear * self._period * math.sin(heading)
        self._yaw += turn
        return BaseState(Pose.of(self._x, self._y, self._z, yaw=self._yaw), linear, angular, still, force, torque)

    def _is_slowed(self) -> bool:
        """Returns whether it is slower than its drives were to make it in the last cycle, which includes braking."""
        lags = (
            (self._linear, self._measured.linear, _SLOWED),
            (self._angular, self._measured.angular, _HINDERED),
        )
        return any(math.copysign(1.0, wanted) * (wanted - measured) > most for wanted, measured, most in lags if wanted)

    def _let_go(self, resisted: BaseTwist) -> None:
        """Stops, and gives way to what pushes it back."""
        self._yields -= self._period
        measured = self._measured
        self._linear, self._angular, self._held = measured.linear, measured.angular, None
        ahead = math.copysign(measured.linear, resisted.linear * measured.linear)
        around = math.copysign(measured.angular, resisted.angular * measured.angular)
        if ahead > _SLOWED or around > _HINDERED:
            effort = _HOLDING_FORCE
        else:
            effort = _YIELDING_FORCE if min(ahead, around) > -_PUSHED_BACK else _DRIVE_FORCE
        self._wheels.drive_velocities((0.0, 0.0), effort=_WHEEL_TORQUE)
        self._plane.drive_velocities((0.0, 0.0, 0.0), effort=effort)

    def _limit(self, twist: BaseTwist) -> None:
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
        self._held = self._held or self._plane.read().positions
        self._wheels.drive_velocities((0.0, 0.0), effort=_WHEEL_TORQUE)
        self._plane.hold_positions(self._held, gain=_HOLDING_GAIN, effort=[_HOLDING_FORCE] * 3)


def _wheel_geometry(robot: SimulatedRobot) -> tuple[float, float]:
    """Returns radius and track of the driving wheels [m]; their axle is one radius above the floor."""
    base = robot.link(BASE_LINK).pose().inverse()
    left, right = (base @ robot.link(link).pose() for link in robot.joints(_WHEELS).links)
    return round(left.position[2], 6), round(left.distance(right), 6)


def _step(way: float, turn: float) -> Pose:
    """Returns the motion of one cycle: straight along its mean heading, exact for pure driving or turning."""
    return Pose.of(way * math.cos(turn / 2.0), way * math.sin(turn / 2.0), 0.0, yaw=turn)

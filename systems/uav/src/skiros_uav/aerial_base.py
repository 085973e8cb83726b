"""Aerial bases: rotors that lift a robot, and the autopilot that flies it level.

The autopilot tilts the airframe as far as its accelerations need; what is simulated is the motion that results: the
airframe stays level, the rotors lift it with a limited thrust, and everything that it carries weighs on them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from skiros_py.devices.common import BASE_STILL, FakeModel, Standstill, approach
from skiros_py.errors import DeviceError
from skiros_py.geometry import Pose, wrap_angle
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
from skiros_py.ports.paths import Path, PosePath
from skiros_py.ports.simulation import SimulatedRobot, Vector

LIFT_JOINT = "base_z"
"""Joint of the robot's model along which the rotors lift it; the others are those of any base."""
_DOWN = 0.4
"""How fast the autopilot comes down by itself [m/s]."""
_PUSH = 60.0
"""What tilting exerts sideways at most [N], and turning [N m]."""
_ON_GROUND = 200.0
"""What the skids hold by friction [N, N m]."""
_GAIN = 0.1
_SETTLING = 2.0
"""Speed per distance from the end of a leg [1/s]."""
_PULL = 3.0
"""Speed per distance from the line of a leg [1/s]."""
_CYCLE = 0.005
"""In this time it may get faster by what its acceleration allows: a control cycle [s]."""
_SHARE = 0.8
"""Share of the acceleration that is planned with; the rest is left for corrections."""
_NEAR, _ALIGNED = 0.004, math.radians(0.2)
"""So near to the end of a leg it has arrived [m, rad]."""
_ASTRAY = 0.3
"""Greatest distance from the line of a leg [m]."""
_STEEP = 0.7
"""Least vertical part of the normal of ground that a skid stands on."""


@dataclass(frozen=True, slots=True)
class AerialState:
    """What an autopilot says.

    Attributes:
        pose: Pose of the base frame, which is level with the skids, in the map.
        linear: Forward speed [m/s].
        sideways: Speed to the left [m/s].
        climb: Speed upwards [m/s].
        angular: Turning speed, counter-clockwise [rad/s].
        thrust: Thrust of all rotors [N].
        landed: True when it stands on the ground and its rotors are off.
        still: True when it does not move: it hovers, or has landed.
        failsafe: True where its battery is nearly empty: then it lands by itself, and does not take off.
    """

    pose: Pose
    linear: float = 0.0
    sideways: float = 0.0
    climb: float = 0.0
    angular: float = 0.0
    thrust: float = 0.0
    landed: bool = True
    still: bool = True
    failsafe: bool = False


@dataclass(frozen=True, slots=True)
class AerialTwist:
    """Speeds for one cycle: forward, to the left, up [m/s], counter-clockwise [rad/s]; down to the ground lands."""

    linear: float = 0.0
    sideways: float = 0.0
    climb: float = 0.0
    angular: float = 0.0


@dataclass(frozen=True, slots=True)
class AerialBaseSpec(MobileSpec[AerialState, AerialTwist]):
    """An aerial base; without a target it brakes and hovers, and with a nearly empty battery it lands.

    Attributes:
        id: Its element id.
        start: Pose in the map where it stands at the start.
        footprint: Corners of the outline of its rotors in the base frame [m], counter-clockwise.
        max_linear, max_angular, max_climb: Speed limits [m/s, rad/s, m/s].
        max_linear_acceleration, max_angular_acceleration: Acceleration limits [m/s², rad/s²].
        max_thrust: Greatest thrust of all rotors [N].
        height: Height of the robot above its skids [m].
        work_offset: Where the arm works best in the base frame: x, y, and how far below the skids [m].
    """

    kind: ClassVar[str] = "aerial_base"
    device_class: ClassVar[str] = "uav:AerialBase"
    state_type: ClassVar[type] = AerialState
    target_type: ClassVar[type] = AerialTwist
    signals: ClassVar[tuple[DeviceSignal[Any], ...]] = (
        DeviceSignal("x", lambda state: state.pose.position[0], "m", "position", "map"),
        DeviceSignal("y", lambda state: state.pose.position[1], "m", "position", "map"),
        DeviceSignal("altitude", lambda state: state.pose.position[2], "m", "height of the skids", "map"),
        DeviceSignal("yaw", lambda state: state.pose.yaw, "rad", "heading", "map"),
        DeviceSignal("climb", lambda state: state.climb, "m/s", "speed upwards", "map"),
        DeviceSignal("thrust", lambda state: state.thrust, "N", "thrust of all rotors", "own"),
        DeviceSignal("landed", lambda state: state.landed, help="whether it stands on the ground"),
        DeviceSignal("still", lambda state: state.still, help="whether it hovers or stands"),
    )
    jog: ClassVar[tuple[str, ...]] = ("jog_base",)

    max_linear: float
    max_angular: float
    max_climb: float
    max_linear_acceleration: float
    max_angular_acceleration: float
    max_thrust: float
    height: float
    work_offset: Vector

    @classmethod
    def read(cls, individual: Individual) -> Self:
        """Reads where it starts, its outline and its limits."""
        x, y, below = individual.vector("uav:workOffset", 3)
        return cls(
            individual.id,
            *read_mobile(individual),
            individual.number("sk:maxLinear"),
            individual.number("sk:maxAngular"),
            individual.number("uav:maxClimb"),
            individual.number("sk:maxLinearAcceleration"),
            individual.number("sk:maxAngularAcceleration"),
            individual.number("uav:maxThrust"),
            individual.number("uav:height"),
            (x, y, below),
        )

    def fake(self, robot: FakeRobot) -> FakeModel[AerialState, AerialTwist]:
        """Returns a base that flies exactly as commanded; the ground is at z = 0."""
        period = robot.period

        def flown(state: AerialState, target: AerialTwist | None) -> AerialState:
            twist = target or AerialTwist()
            x, y, z = (period * speed for speed in (twist.linear, twist.sideways, twist.climb))
            pose = state.pose @ Pose.of(x, y, z, yaw=period * twist.angular)
            landed = pose.position[2] <= 0.0 and twist.climb <= 0.0
            pose = Pose((*pose.position[:2], max(0.0, pose.position[2])), pose.orientation)
            speeds = (twist.linear, twist.sideways, twist.climb, twist.angular)
            return AerialState(pose, *speeds, landed=landed, still=not any(speeds))

        return FakeModel(AerialState(self.start, landed=self.start.position[2] <= 0.0), flown)

    def simulate(self, robot: SimulatedRobot, rng: np.random.Generator) -> SimulatedAerialBase:  # noqa: ARG002 - nothing is drawn
        """Returns its autopilot in a simulation."""
        return SimulatedAerialBase(self, robot)

    def pose(self, state: AerialState) -> Pose:
        """Returns its pose in the map."""
        return state.pose

    def still(self, state: AerialState) -> bool:
        """Returns True when it hovers or has landed."""
        return state.still

    def check(self, target: AerialTwist) -> None:
        """Refuses what is no twist, or has numbers that are none."""
        DeviceSpec.check(self, target)
        require_numbers(self.id, target, (target.linear, target.sideways, target.climb, target.angular))

    @property
    def drives_sideways(self) -> bool:
        """It flies in any direction."""
        return True

    def direct_path(self, start: Pose, goal: Pose) -> Path:  # noqa: ARG002 - it is straight
        """Returns the straight path at the height of the goal."""
        return PosePath((goal,))

    def follow(
        self, path: Path, pose: Callable[[], Pose], *, max_linear: float = math.inf, max_angular: float = math.inf
    ) -> Follower[AerialTwist]:
        """Flies straight from pose to pose, turning on the way, and stops at each.

        Raises:
            DeviceError: The path is not made of poses.
        """
        if not isinstance(path, PosePath):
            raise DeviceError(f"{self.id}: it flies from pose to pose, it cannot follow a {type(path).__name__}")
        for number, goal in enumerate(path.legs):
            begin = pose()
            length = max(1e-6, begin.distance(goal))
            before = 0.0
            while True:
                here = pose()
                off, turn = np.subtract(goal.position, here.position), wrap_angle(goal.yaw - here.yaw)
                left = float(np.linalg.norm(off))
                if left < _NEAR and abs(turn) < _ALIGNED:
                    break
                along = np.subtract(goal.position, begin.position) / length
                ahead = float(off @ along)
                aside = off - ahead * along
                if float(np.linalg.norm(aside)) > _ASTRAY:
                    return False
                fastest = min(max_linear, self._fastest(along))
                speed = math.copysign(self._slowing(abs(ahead), before, fastest), ahead)
                before = abs(speed)
                wanted = speed * along + _PULL * aside
                turning = min(max_angular, self.max_angular, _SETTLING * abs(turn))
                yield number + 1.0 - min(1.0, left / length), self._twist(here, wanted, math.copysign(turning, turn))
        return True

    def _fastest(self, along: np.ndarray[Any, Any]) -> float:
        """Returns the greatest speed along a direction [m/s]."""
        level, steep = float(np.hypot(*along[:2])), abs(float(along[2]))
        limits = ((self.max_linear, level), (self.max_climb, steep))
        return min((limit / share for limit, share in limits if share > 1e-6), default=self.max_linear)

    def _slowing(self, left: float, before: float, fastest: float) -> float:
        """Returns how fast it may be before the end of a leg [m/s]."""
        most = _SHARE * self.max_linear_acceleration
        return min(fastest, before + most * _CYCLE + 0.01, math.sqrt(2.0 * most * left), _SETTLING * left)

    def _twist(self, here: Pose, wanted: Iterable[float], turning: float) -> AerialTwist:
        cos, sin = math.cos(here.yaw), math.sin(here.yaw)
        x, y, z = (float(one) for one in wanted)
        return AerialTwist(x * cos + y * sin, y * cos - x * sin, z, turning)

    def scaled(self, target: AerialTwist, rate: float) -> AerialTwist:
        """Returns a slower twist."""
        speeds = (target.linear, target.sideways, target.climb, target.angular)
        return AerialTwist(*(rate * speed for speed in speeds))

    def mixed(self, contributions: Sequence[Contribution[AerialTwist]]) -> AerialTwist:
        """Returns the weighted mean of the twists."""
        weights = [one.weight for one in contributions]
        targets = (one.target for one in contributions)
        twists = [(one.linear, one.sideways, one.climb, one.angular) for one in targets]
        return AerialTwist(*np.average(twists, axis=0, weights=weights).tolist())

    def noisy(self, state: AerialState, sigma: float, rng: np.random.Generator) -> AerialState:
        """Returns a state with noise on the position [m] and on the heading [rad]."""
        x, y, z, turn = map(float, rng.normal(0.0, sigma, 4))
        return replace(state, pose=state.pose @ Pose.of(x, y, z, yaw=turn))


class SimulatedAerialBase:
    """An autopilot in a simulation.

    Args:
        spec: The base, and where it starts.
        robot: The robot that it belongs to.

    Attributes:
        thrust: Thrust of all rotors in the last cycle [N].
        landed: Whether it stands on the ground with its rotors off.
        is_empty: Tells whether the battery is nearly empty; a battery of the robot says it.
    """

    def __init__(self, spec: AerialBaseSpec, robot: SimulatedRobot) -> None:
        self.spec = spec
        self.thrust = 0.0
        self.landed = True
        self.is_empty: Callable[[], bool] = lambda: False
        self._robot = robot
        self._plane, self._lift = robot.joints(BASE_JOINTS), robot.joints((LIFT_JOINT,))
        self._period = robot.engine.period
        self._wanted = AerialTwist()
        self._held: tuple[float, ...] | None = None
        self._standstill = Standstill(BASE_STILL)
        x, y, z = spec.start.position
        self._plane.reset((x, y, spec.start.yaw))
        self._lift.reset((z,))

    @property
    def braking_time(self) -> float:
        """Time from full speed to hovering [s]."""
        spec = self.spec
        return max(
            max(spec.max_linear, spec.max_climb) / spec.max_linear_acceleration,
            spec.max_angular / spec.max_angular_acceleration,
        )

    def command(self, twist: AerialTwist | None) -> None:
        """Flies for one cycle; None brakes and hovers. With a nearly empty battery it lands where it is."""
        wanted = twist or AerialTwist()
        self.spec.check(wanted)
        if self.is_empty():
            wanted = AerialTwist(climb=-_DOWN)
        if self.landed and wanted.climb <= 0.0:
            self._stand()
            return
        if self.landed:
            self.landed, self._held = False, None
        self._limit(wanted)
        if wanted.climb < 0.0 and self._touches():
            self.landed, self._held = True, None
            self._wanted = AerialTwist()
            self._stand()
        elif self._wanted == AerialTwist():
            self._hover()
        else:
            self._fly()

    def state(self) -> AerialState:
        """Reads where it is; to be called once per cycle."""
        (x, y, yaw), (vx, vy, angular), _ = self._plane.read()
        (z,), (climb,), (thrust,) = self._lift.read()
        self.thrust = max(0.0, thrust)
        cos, sin = math.cos(yaw), math.sin(yaw)
        still = self._standstill.update(math.hypot(vx, vy, climb) + abs(angular))
        return AerialState(
            Pose.of(x, y, z, yaw=yaw),
            vx * cos + vy * sin,
            vy * cos - vx * sin,
            climb,
            angular,
            self.thrust,
            self.landed,
            still,
            self.is_empty(),
        )

    def _limit(self, twist: AerialTwist) -> None:
        spec, before = self.spec, self._wanted
        most, turning = spec.max_linear_acceleration * self._period, spec.max_angular_acceleration * self._period

        def within(value: float, limit: float) -> float:
            return min(max(value, -limit), limit)

        self._wanted = AerialTwist(
            approach(before.linear, within(twist.linear, spec.max_linear), most),
            approach(before.sideways, within(twist.sideways, spec.max_linear), most),
            approach(before.climb, within(twist.climb, spec.max_climb), most),
            approach(before.angular, within(twist.angular, spec.max_angular), turning),
        )

    def _fly(self) -> None:
        self._held, wanted = None, self._wanted
        heading = self._plane.read().positions[2] + wanted.angular * self._period / 2.0
        cos, sin = math.cos(heading), math.sin(heading)
        vx, vy = wanted.linear * cos - wanted.sideways * sin, wanted.linear * sin + wanted.sideways * cos
        self._plane.drive_velocities((vx, vy, wanted.angular), effort=_PUSH)
        self._lift.drive_velocities((wanted.climb,), effort=self.spec.max_thrust)

    def _hover(self) -> None:
        """Holds the place where it came to rest, against all that its arm does."""
        self._held = self._held or (*self._plane.read().positions, *self._lift.read().positions)
        *plane, height = self._held
        self._plane.hold_positions(plane, gain=_GAIN, effort=[_PUSH] * 3)
        self._lift.hold_positions((height,), gain=_GAIN, effort=[self.spec.max_thrust])

    def _stand(self) -> None:
        """Stands on its skids, rotors off."""
        self._held = self._held or self._plane.read().positions
        self._plane.hold_positions(self._held[:3], gain=_GAIN, effort=[_ON_GROUND] * 3)
        self._lift.drive_velocities((0.0,), effort=0.0)

    def _touches(self) -> bool:
        """Returns whether its skids touch ground."""
        found = self._robot.engine.contacts(self._robot.name, BASE_LINK)
        return any(contact.normal[2] > _STEEP and contact.depth > -1e-4 for contact in found)


def wired_base(models: Mapping[str, Any], base: str) -> SimulatedAerialBase | None:
    """Returns the simulated base of that id; None where it is not simulated here."""
    model = models.get(base)
    return model if isinstance(model, SimulatedAerialBase) else None

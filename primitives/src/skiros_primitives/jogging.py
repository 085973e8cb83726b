"""Jogs the joints or the tool of an arm, or a base, by a small step, for robot setup."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import shapely

from skiros_primitives import floor_obstacles
from skiros_primitives.arm_moves import ArmPrimitive, is_stowed
from skiros_primitives.driving import DrivingPrimitive
from skiros_primitives.playback import UNPLANNED_SPEED
from skiros_py.devices.arm import ArmSpec
from skiros_py.geometry import Pose
from skiros_py.messages import Message, listed
from skiros_py.ports.board import Mobile
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.motion import JointMove, LineMove, NoMotion, Obstacle
from skiros_py.ports.paths import Layer, Path, floor_area, placed, swept
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import map_pose, obstacles
from skiros_py.world.vocabulary import ARM, BASE, ROBOT, SPATIAL_THING

_SHOWN = 0.0005
"""Smaller joint motions are not reported [rad]."""


_DETOUR = 0.02
"""How much farther than commanded a joint may turn [rad]: more means a detour around something."""


class JogJoints(ArmPrimitive):
    """Turns the joints of an arm by at most 0.2 rad each, straight and only if nothing is touched."""

    name: ClassVar[str] = "jog_joints"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        arm: str = param(ARM, "The arm that moves.", kind=Kind.HARDWARE)
        deltas: tuple[float, ...] = param(
            "number", "By how much each joint turns, in the arm's order.", length=0, unit="rad", limits=(-0.2, 0.2)
        )

    def start(self) -> Failure | None:
        """Checks that there is a number for each joint."""
        joints, deltas = self.arm.spec.joints, self.params.deltas
        if len(deltas) != len(joints):
            return Failure(
                Message(
                    "deltas: {arm} has {count} joints ({joints}), not {given}",
                    arm=self.params.arm,
                    count=len(joints),
                    joints=", ".join(joints),
                    given=len(deltas),
                )
            )
        return None

    def execute(self) -> Execution[Outcome]:
        """Moves if the straight path is free."""
        goal = tuple(at + delta for at, delta in zip(self.arm.state.positions, self.params.deltas, strict=True))
        refusal = yield from self._go(goal) if self.is_planned else self.go_straight(goal)
        if refusal is not None:
            return Failure(Message("{arm} cannot turn so: {reason}", arm=self.params.arm, reason=refusal.reason))
        ways = zip(self.arm.spec.joints, self.params.deltas, strict=True)
        turned = [
            Message("{joint} by {delta:.3f} rad", joint=joint, delta=delta)
            for joint, delta in ways
            if abs(delta) >= _SHOWN
        ]
        return Success(Message("turned {turned}", turned=", ".join(turned)) if turned else "nothing to turn")

    def _go(self, goal: tuple[float, ...]) -> Execution[NoMotion | None]:
        planned = yield from self.plan([(JointMove(goal),)], speed=UNPLANNED_SPEED)
        if isinstance(planned, NoMotion):
            return planned
        ways = [np.abs(np.diff(leg.positions, axis=0)).sum(axis=0) for leg in planned.legs]
        more = np.sum(ways, axis=0) - np.abs(self.params.deltas)
        if more.max() > _DETOUR:
            return NoMotion("something is in the straight way")
        return (yield from self.follow_plan(planned))


_TOOL_FARTHEST = 0.1
"""Longest step [m]."""
_TURN = 0.35
"""Greatest turn in one step [rad]."""
_TOOL_SPEED = 0.05
"""Greatest speed of the tool [m/s]."""
_SHARE = 0.3
"""Fraction of the maximum joint speeds that is used."""

Triple = tuple[float, float, float]


class JogTool(ArmPrimitive):
    """Moves and turns the tool of an arm by at most 0.1 m and 0.35 rad, straight and only if nothing is touched."""

    name: ClassVar[str] = "jog_tool"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        arm: str = param(ARM, "The arm whose tool moves.", kind=Kind.HARDWARE)
        frame: str = param(
            "text", "Along whose axes: tool, base (of the robot), map, or the id of an element.", default="tool"
        )
        translation: Triple = param(
            "number",
            "By how much it moves along x, y, z; 0.1 m at most in all.",
            length=3,
            default=(0.0, 0.0, 0.0),
            unit="m",
            limits=(-_TOOL_FARTHEST, _TOOL_FARTHEST),
        )
        rotation: Triple = param(
            "number",
            "Axis in that frame, as long as it turns about the tool's tip; 0.35 rad at most.",
            length=3,
            default=(0.0, 0.0, 0.0),
            unit="rad",
            limits=(-_TURN, _TURN),
        )
        near: str | None = param(
            SPATIAL_THING, "A thing that gripper and held part may touch, and what it lies on.", kind=Kind.OPTIONAL
        )

    def start(self) -> Failure | None:
        """Checks that it is a small step in an existing frame."""
        way, turn = math.hypot(*self.params.translation), math.hypot(*self.params.rotation)
        if way > _TOOL_FARTHEST or turn > _TURN:
            return Failure(
                Message(
                    "one step is at most {longest:g} m and {widest:g} rad long, not {way:.3g} m and {turn:.3g} rad",
                    longest=_TOOL_FARTHEST,
                    widest=_TURN,
                    way=way,
                    turn=turn,
                )
            )
        if not self.is_planned:
            return Failure(Message("there is no planner for the arm: jog the joints instead"))
        frame = self.params.frame
        if frame not in ("tool", "base", "map"):
            if not self.world.has(frame):
                return Failure(
                    Message("frame: there is no element '{frame}'; else it is tool, base or map", frame=frame)
                )
            if map_pose(self.context, frame) is None:
                return Failure(Message("frame: the position of {frame} is unknown", frame=frame))
        return None

    def execute(self) -> Execution[Outcome]:
        """Moves along a line if it is free."""
        tool = self.tool_pose()
        line = LineMove(self._goal(tool), speed=_TOOL_SPEED, touching=self._touching())
        refusal = yield from self.go([(line,)], speed=_SHARE)
        if refusal is not None:
            return Failure(
                Message("{arm} cannot move its tool so: {reason}", arm=self.params.arm, reason=refusal.reason)
            )
        tool = self.tool_pose()
        return Success(
            Message("at {x:.3f} {y:.3f} {z:.3f} m in the map", **dict(zip("xyz", tool.position, strict=True)))
        )

    def _goal(self, tool: Pose) -> Pose:
        """The tool's pose in the map afterwards."""
        axes = Pose((0.0, 0.0, 0.0), self._frame(tool).orientation)
        step = axes.apply(np.array(self.params.translation))
        turn = axes @ Pose.turn(*self.params.rotation) @ axes.inverse()
        x, y, z = (at + by for at, by in zip(tool.position, step.tolist(), strict=True))
        return Pose((x, y, z), (turn @ Pose((0.0, 0.0, 0.0), tool.orientation)).orientation)

    def _frame(self, tool: Pose) -> Pose:
        own = {"tool": tool, "base": self.base_pose, "map": Pose()}
        return own.get(self.params.frame) or map_pose(self.context, self.params.frame) or Pose()

    def _touching(self) -> frozenset[str]:
        near = self.params.near
        if near is None:
            return frozenset()
        placement = self.world.placement(near)
        return frozenset((near, placement.place) if placement else (near,))


_FARTHEST = 0.2
"""Longest step [m]."""
_BASE_SPEED, _TURNING = 0.1, 0.3
"""Greatest speeds [m/s, rad/s]."""
_CLOSE = 0.02
"""Distance kept from everything [m]; things already nearer must not get nearer."""
_NEARER = 0.001
"""Approaching by less than this does not count [m]."""


class JogBase(DrivingPrimitive):
    """Drives a base by at most 0.2 m and 0.35 rad, with its arms at home, if nothing is touched.

    A sideways step of a differential drive is a turn, a straight path and a turn back: its wheels do not roll sideways.
    """

    name: ClassVar[str] = "jog_base"
    takes: ClassVar[tuple[str, ...]] = ("robot",)

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        base: str = param(BASE, "The base that drives.", kind=Kind.HARDWARE)
        robot: str = param(ROBOT, "The robot it carries along.", kind=Kind.PLANNING)
        dx: float = param(
            "number", "How far ahead; 0.2 m at most with dy.", default=0.0, unit="m", limits=(-_FARTHEST, _FARTHEST)
        )
        dy: float = param("number", "How far to the left.", default=0.0, unit="m", limits=(-_FARTHEST, _FARTHEST))
        dyaw: float = param("number", "How far it turns to the left.", default=0.0, unit="rad", limits=(-_TURN, _TURN))

    def start(self) -> Failure | None:
        """Checks that the step is small and the arms are in their travelling posture."""
        way = math.hypot(self.params.dx, self.params.dy)
        if way > _FARTHEST:
            return Failure(
                Message("one step is at most {longest:g} m long, not {way:.3g} m", longest=_FARTHEST, way=way)
            )
        stretched = [arm.id for arm in self._robot.of(ArmSpec) if not is_stowed(self.context, arm)]
        if stretched:
            return Failure(
                Message("{arms} is stretched out: bring it home before the base moves", arms=", ".join(stretched))
            )
        return None

    def execute(self) -> Execution[Outcome]:
        """Drives if the way is free, and returns how far it got."""
        base, before = Mobile(self.context.board, self.params.base), self.pose
        goal = before @ Pose.of(self.params.dx, self.params.dy, 0.0, yaw=self.params.dyaw)
        path = base.direct_path(before, goal)
        if touched := self._touched(before, path):
            return Failure(Message("{base} would touch {touched}", base=self.params.base, touched=touched))
        with self.context.floor.ask(self.params.robot, self._robot.outline, before, path) as way:
            if not way.free:
                return Failure(Message("{robots} is in the way", robots=listed(way.waits_for())))
            self.leave("is moved by hand")
            stuck = yield from self.drive(base, path, way, max_linear=_BASE_SPEED, max_angular=_TURNING)
        step = before.inverse() @ self.pose
        x, y, _ = step.position
        said = Message("by {x:.3f} m ahead, {y:.3f} m to the left and {yaw:.3f} rad", x=x, y=y, yaw=step.yaw)
        return (
            Success(Message("moved {said}", said=said))
            if stuck is None
            else Failure(Message("{base} is stuck: it moved {said}", base=self.params.base, said=said))
        )

    @property
    def _robot(self) -> RobotSpec:
        return self.context.cell.group_of(self.params.base)

    # ------------------------------------------------------------------ obstacles

    def _touched(self, start: Pose, path: Path) -> str:
        """Returns the things that would be touched or come too near; empty if the way is free."""
        there = obstacles(self.context, parts=False)
        things = [one for one in there if not floor_obstacles.rides(self.context, one.id, self._robot)]
        robots = floor_obstacles.standing(self.context, self.params.robot, margin=0.0)
        shape = floor_obstacles.shape(self.context, self._robot)
        near = [id_ for layer in shape for id_ in _nearing((*things, *robots), layer, start, path)]
        return " and ".join(dict.fromkeys(near))


def _nearing(around: Sequence[Obstacle], layer: Layer, start: Pose, path: Path) -> list[str]:
    """Returns the ids of things that a layer comes too near to: nearer than the margin and than at the start."""
    standing = placed(layer.outline, start)
    area = shapely.union_all(swept(layer.outline, (pose for _, pose in path.poses(start))))
    areas = ((one.id, floor_area(one.solid, one.pose, layer.bottom, layer.top)) for one in around)
    ways = (
        (id_, shapely.distance(standing, thing), shapely.distance(area, thing))
        for id_, thing in areas
        if not thing.is_empty
    )
    return [id_ for id_, now, then in ways if then < _CLOSE and (then <= 0.0 or then < now - _NEARER)]

"""Jogs the tool of an arm by a small step, for robot setup."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skiros_primitives.arm_moves import ArmPrimitive
from skiros_py.geometry import Pose
from skiros_py.ports.motion import LineMove
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import map_pose
from skiros_py.world.vocabulary import ARM, SPATIAL_THING

_FARTHEST = 0.1
"""Longest step [m]."""
_TURN = 0.35
"""Greatest turn in one step [rad]."""
_SPEED = 0.05
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
            "number", "By how much it moves along x, y, z; 0.1 m at most.", length=3, default=(0.0, 0.0, 0.0), unit="m"
        )
        rotation: Triple = param(
            "number",
            "Axis in that frame, as long as it turns about the tool's tip; 0.35 rad at most.",
            length=3,
            default=(0.0, 0.0, 0.0),
            unit="rad",
        )
        near: str | None = param(
            SPATIAL_THING,
            "A thing that gripper and held part may touch, and what it lies on.",
            kind=Kind.OPTIONAL,
            default=None,
        )

    def start(self) -> Failure | None:
        """Checks that it is a small step in an existing frame."""
        way, turn = math.hypot(*self.params.translation), math.hypot(*self.params.rotation)
        if way > _FARTHEST or turn > _TURN:
            return Failure(
                f"one step is at most {_FARTHEST:g} m and {_TURN:g} rad long, not {way:.3g} m and {turn:.3g} rad"
            )
        if not self.is_planned:
            return Failure("there is no planner for the arm: jog the joints instead")
        if self.params.frame not in ("tool", "base", "map"):
            return self._unplaced(self.params.frame)
        return None

    def execute(self) -> Execution[Outcome]:
        """Moves along a line if it is free."""
        tool = self.tool_pose()
        line = LineMove(self._goal(tool), speed=_SPEED, touching=self._touching())
        refusal = yield from self.go([(line,)], speed=_SHARE)
        if refusal is not None:
            return Failure(f"{self.params.arm} cannot move its tool so: {refusal.reason}")
        tool = self.tool_pose()
        return Success("at {:.3f} {:.3f} {:.3f} m in the map".format(*tool.position))

    def _goal(self, tool: Pose) -> Pose:
        """The tool's pose in the map afterwards."""
        axes = Pose((0.0, 0.0, 0.0), self._frame(tool).orientation)
        step = axes.apply(np.array(self.params.translation))
        turn = axes @ Pose((0.0, 0.0, 0.0), _quaternion(self.params.rotation)) @ axes.inverse()
        x, y, z = (at + by for at, by in zip(tool.position, step.tolist(), strict=True))
        return Pose((x, y, z), (turn @ Pose((0.0, 0.0, 0.0), tool.orientation)).orientation)

    def _frame(self, tool: Pose) -> Pose:
        match self.params.frame:
            case "tool":
                return tool
            case "base":
                return self.base_pose
            case "map":
                return Pose()
            case element:
                return map_pose(self.context, element) or Pose()

    def _unplaced(self, element: str) -> Failure | None:
        if not self.world.has(element):
            return Failure(f"frame: there is no element '{element}'; else it is tool, base or map")
        if map_pose(self.context, element) is None:
            return Failure(f"frame: nobody knows where {element} is")
        return None

    def _touching(self) -> frozenset[str]:
        near = self.params.near
        if near is None:
            return frozenset()
        placement = self.world.placement(near)
        return frozenset((near, placement.place) if placement else (near,))


def _quaternion(rotation: Triple) -> tuple[float, float, float, float]:
    """Converts a rotation vector [rad] to a unit quaternion."""
    angle = math.hypot(*rotation)
    if angle == 0.0:
        return (0.0, 0.0, 0.0, 1.0)
    x, y, z = (component * math.sin(angle / 2.0) / angle for component in rotation)
    return (x, y, z, math.cos(angle / 2.0))

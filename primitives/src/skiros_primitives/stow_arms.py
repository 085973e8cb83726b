"""Moves all arms of a robot to their travelling posture, unless they are already there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from skiros_py.devices.arm import ArmSpec, ArmState
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.world.vocabulary import ROBOT

_STOWED = 0.05
"""Maximum joint error of an arm in its posture [rad]."""


class StowArms(Primitive["StowArms.Params"]):
    """Moves all arms to their travelling posture: a base must not drive with an extended arm.

    The base's paths are planned for its outline alone.
    """

    name: ClassVar[str] = "stow_arms"
    takes: ClassVar[tuple[str, ...]] = ("robot",)

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        robot: str = param(ROBOT, "The robot.", kind=Kind.PLANNING)

    def execute(self) -> Execution[Outcome]:
        """Moves the arms one after the other."""
        robot = next(r for r in self.context.cell.robots if r.id == self.params.robot)
        for arm in robot.of(ArmSpec):
            if self._is_stowed(arm):
                continue
            outcome = yield from self.call("move_arm", arm=arm.id)
            if isinstance(outcome, Failure):
                return outcome
        return Success("stowed")

    def _is_stowed(self, arm: ArmSpec) -> bool:
        now = self.context.board.snapshot.state(arm.id, ArmState).positions
        return max(abs(is_ - home) for is_, home in zip(now, arm.home, strict=True)) <= _STOWED

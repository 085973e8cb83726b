"""A robot cell without physics: every device does at once what it is told."""

from __future__ import annotations

import math
from collections.abc import Mapping

from skiros_py.errors import DeviceError
from skiros_py.geometry import Pose
from skiros_py.ports.cell import CellSpec
from skiros_py.ports.pending import Pending
from skiros_py.ports.values import (
    ArmState,
    ArmTarget,
    BaseState,
    BaseTwist,
    Commands,
    DepthImage,
    GripperState,
    GripperTarget,
    Snapshot,
)

__all__ = ["FakeCell"]

_PERIOD = 1.0 / 200.0
_NO_COMMANDS = Commands()


class FakeCell:
    """A :class:`skiros_py.ports.driver.CellDriver` for trying skills and plans without physics.

    Arms and grippers reach their targets within the cycle, bases drive exactly as told and know exactly where they are.
    Bodies do not exist: nothing can be seen, held or bumped into.

    Args:
        spec: The cell; its robots are used, its bodies are not.
        seed: Accepted for likeness with a simulated cell; nothing here is drawn.
    """

    def __init__(self, spec: CellSpec, *, seed: int = 0) -> None:
        self.seed = seed
        self._halted = False
        self._snapshot = Snapshot(
            0,
            0.0,
            {arm.id: _resting(arm.home) for robot in spec.robots for arm in robot.arms},
            {
                gripper.id: GripperState(gripper.max_gap, 0.0, True)
                for robot in spec.robots
                for gripper in robot.grippers
            },
            {robot.base.id: BaseState(robot.base.start, 0.0, 0.0, True) for robot in spec.robots},
        )

    @property
    def period(self) -> float:
        """Length of one control cycle [s]."""
        return _PERIOD

    @property
    def kind(self) -> str:
        """Name of the adapter."""
        return "fake"

    @property
    def braking_time(self) -> float:
        """Longest time from full speed to standstill [s]: it stands in the next cycle."""
        return _PERIOD

    def read(self) -> Snapshot:
        """Returns the present state without advancing time."""
        return self._snapshot

    def exchange(self, commands: Commands) -> Snapshot:
        """Does what the commands say and returns the state one period later.

        Raises:
            DeviceError: A command is for a device that does not exist.
        """
        now = self._snapshot
        commands = _NO_COMMANDS if self._halted else commands
        _require(commands.arms, now.arms)
        _require(commands.grippers, now.grippers)
        _require(commands.bases, now.bases)
        cycle = now.cycle + 1
        self._snapshot = Snapshot(
            cycle,
            cycle * _PERIOD,
            {arm: _moved(state, commands.arms.get(arm)) for arm, state in now.arms.items()},
            {gripper: _closed(state, commands.grippers.get(gripper)) for gripper, state in now.grippers.items()},
            {base: _driven(state, commands.bases.get(base)) for base, state in now.bases.items()},
        )
        return self._snapshot

    def halt(self) -> None:
        """Stands still from the next exchange on, whatever is commanded; for any thread."""
        self._halted = True

    def release(self) -> None:
        """Obeys commands again."""
        self._halted = False

    def capture(self, camera: str) -> Pending[DepthImage]:
        """Refuses: there is nothing to see.

        Raises:
            DeviceError: Always.
        """
        raise DeviceError(f"the fake cell has no camera (asked for '{camera}')")

    def close(self) -> None:
        """Does nothing; there is nothing to bring down."""


def _require(commanded: Mapping[str, object], known: Mapping[str, object]) -> None:
    for device in commanded:
        if device not in known:
            raise DeviceError(f"no device '{device}'; there is {', '.join(sorted(known)) or 'none'}")


def _resting(positions: tuple[float, ...]) -> ArmState:
    return ArmState(positions, (0.0,) * len(positions), True)


def _moved(state: ArmState, target: ArmTarget | None) -> ArmState:
    if target is None:
        return _resting(state.positions)
    return ArmState(target.positions, target.velocities, not any(target.velocities))


def _closed(state: GripperState, target: GripperTarget | None) -> GripperState:
    return GripperState(state.gap if target is None else target.gap, 0.0, True)


def _driven(state: BaseState, twist: BaseTwist | None) -> BaseState:
    if twist is None:
        return BaseState(state.pose, 0.0, 0.0, True)
    turn = twist.angular * _PERIOD
    way = twist.linear * _PERIOD
    # Straight along the mean heading of the cycle: exact for a base that only drives or only turns.
    step = Pose.of(way * math.cos(turn / 2.0), way * math.sin(turn / 2.0), 0.0, yaw=turn)
    return BaseState(state.pose @ step, twist.linear, twist.angular, not (twist.linear or twist.angular))

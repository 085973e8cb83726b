"""Grippers whose fingers come together from two sides: one finger from one side, one or several from the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from skiros_py.devices.common import FakeModel, Standstill
from skiros_py.errors import DescriptionError, DeviceError
from skiros_py.ports.board import DeviceHandle
from skiros_py.ports.device import DeviceSignal, DeviceSpec, FakeRobot, Individual, require_numbers
from skiros_py.ports.simulation import SimulatedRobot, Surface, Vector

_GAIN = 0.2
_SPEED = 0.1  # greatest finger speed [m/s]; faster fingers dive into what they close on
_DEFAULT_FORCE = 30.0  # [N] per finger, until the first command
_COUPLING_FORCE = 200.0  # [N]
# The anchor remembers where finger and part met. Without it a held part creeps: 0.2 mm per second, and 9 mm for every
# full turn of the robot.
_PADS = Surface(lateral=1.0, anchored=True)
_STILL = 0.001  # [m/s]
_TWO = 2
FINGER: Vector = (0.022, 0.015, 0.010)
"""Width of the fingers on one side, their thickness, and how far they reach beyond the tip, where none is said [m]."""


@dataclass(frozen=True, slots=True)
class GripperState:
    """Sensors of a gripper.

    Attributes:
        gap: Distance between the finger pads of both sides [m]; of several on one side the mean counts.
        force: Force with which the fingers press on what they hold, per finger [N]; about 0 when nothing is held.
        still: True when the fingers do not move.
    """

    gap: float
    force: float
    still: bool


@dataclass(frozen=True, slots=True)
class GripperTarget:
    """Move the fingers to a gap [m] pressing with at most a force per finger [N]; it stays in force until replaced."""

    gap: float
    force: float


@dataclass(frozen=True, slots=True)
class GripperSpec(DeviceSpec[GripperState, GripperTarget]):
    """A gripper; without a target it keeps the last one, so that nothing is let go by omission.

    One drive couples all fingers: each is as far from the middle as the others.

    A stop does not wait for its fingers: they keep their target.

    Attributes:
        id: Its element id.
        joints: Names of the finger joints, each at 0 where its pad is in the middle; the finger that opposes all others
            comes first.
        arm: Id of the arm that it is mounted on.
        max_gap: Greatest gap [m].
        max_force: Greatest force per finger [N]; one that opposes others bears that of all of them.
        finger: Width of the fingers on one side together, their thickness, and how far they reach beyond the tip [m].
    """

    kind: ClassVar[str] = "gripper"
    device_class: ClassVar[str] = "sk:Gripper"
    state_type: ClassVar[type] = GripperState
    target_type: ClassVar[type] = GripperTarget
    signals: ClassVar[tuple[DeviceSignal[Any], ...]] = (
        DeviceSignal("gap", lambda state: state.gap, "m", "distance between the finger pads"),
        DeviceSignal("force", lambda state: state.force, "N", "force per finger"),
        DeviceSignal("still", lambda state: state.still, help="whether the fingers stand"),
    )
    jog: ClassVar[tuple[str, ...]] = ("gripper_control",)

    joints: tuple[str, ...]
    arm: str
    max_gap: float
    max_force: float
    finger: Vector = FINGER

    @classmethod
    def read(cls, individual: Individual) -> Self:
        """Reads ``sk:joints``, ``sk:maxGap``, ``sk:maxForce``, ``sk:fingerSize`` and the arm that has it."""
        arm = individual.owner("sk:Arm")
        if arm is None:
            raise DescriptionError(f"{individual.id} is on no arm: relate an sk:Arm to it by sk:hasA")
        joints = tuple(individual.text("sk:joints").split())
        width, thickness, beyond = individual.vector("sk:fingerSize", 3, FINGER)
        gap, force = individual.number("sk:maxGap"), individual.number("sk:maxForce")
        return cls(individual.id, joints, arm, gap, force, (width, thickness, beyond))

    def fake(self, robot: FakeRobot) -> FakeModel[GripperState, GripperTarget]:  # noqa: ARG002 - it is there at once
        """Returns a gripper that is open at first and reaches its targets within the cycle."""
        return FakeModel(
            GripperState(self.max_gap, 0.0, True),
            lambda state, target: state if target is None else replace(state, gap=target.gap),
        )

    def simulate(self, robot: SimulatedRobot, rng: np.random.Generator) -> SimulatedGripper:  # noqa: ARG002 - nothing is drawn
        """Returns its controller in a simulation."""
        return SimulatedGripper(self, robot)

    def check(self, target: GripperTarget) -> None:
        """Refuses what is no target, or has numbers that are none."""
        DeviceSpec.check(self, target)
        require_numbers(self.id, target, (target.gap, target.force))
        if target.force < 0.0:
            raise DeviceError(f"{self.id}: its fingers press with a force of 0 or more: {target}")

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Its finger joints."""
        return self.joints

    def joint_positions(self, state: GripperState) -> tuple[float, ...]:
        """Returns how far each finger is from the middle [m]."""
        return (state.gap / 2.0,) * len(self.joints)

    @property
    def mounted_on(self) -> str:
        """Its arm: what it holds has its pose in the frame of the arm's tip."""
        return self.arm

    def noisy(self, state: GripperState, sigma: float, rng: np.random.Generator) -> GripperState:
        """Returns a state with noise on the gap [m]."""
        return replace(state, gap=max(0.0, state.gap + rng.normal(0.0, sigma)))


class Gripper(DeviceHandle[GripperSpec, GripperState, GripperTarget]):
    """A gripper in the hands of a primitive; a target stays in force until it is replaced."""

    spec_type: ClassVar[Any] = GripperSpec


class SimulatedGripper:
    """The controller of one gripper; what it holds, it holds by friction.

    Args:
        spec: The gripper; it starts open.
        robot: The robot that it belongs to.

    Attributes:
        fingers: Links of the fingers.
        braking_time: 0: a stop does not open or close it [s].
    """

    braking_time = 0.0

    def __init__(self, spec: GripperSpec, robot: SimulatedRobot) -> None:
        self.spec = spec
        self._joints = robot.joints(spec.joints)
        self.fingers = self._joints.links
        self._target = GripperTarget(spec.max_gap, min(_DEFAULT_FORCE, spec.max_force))
        self._standstill = Standstill(_STILL)
        self._joints.reset([spec.max_gap / 2.0] * len(spec.joints))
        self._joints.set_surface(_PADS)
        # The real drive couples the fingers; without that they slide sideways together with the part.
        for other in spec.joints[1:]:
            robot.joints((spec.joints[0], other)).couple(ratio=1.0, effort=_COUPLING_FORCE)

    def command(self, target: GripperTarget | None) -> None:
        """Moves to a new target; None keeps the last one, so that nothing is let go by omission."""
        if target is not None:
            self.spec.check(target)
            gap = min(max(target.gap, 0.0), self.spec.max_gap)
            self._target = GripperTarget(gap, min(target.force, self.spec.max_force))
        count, force = len(self.fingers), self._target.force
        positions, efforts = [self._target.gap / 2.0] * count, [force] * count
        efforts[0] = force * max(1, count - 1)
        self._joints.hold_positions(positions, gain=_GAIN, effort=efforts, max_velocity=_SPEED)

    def state(self) -> GripperState:
        """Reads the sensors; to be called once per cycle."""
        positions, velocities, efforts = self._joints.read()
        pressing = -self._others(efforts) if len(efforts) > _TWO else -sum(efforts) / len(efforts)
        still = self._standstill.update(max(map(abs, velocities)))
        gap = positions[0] + self._others(positions)
        return GripperState(gap, max(0.0, pressing), still)

    @staticmethod
    def _others(values: Sequence[float]) -> float:
        """Returns the mean over all fingers but the one that opposes them."""
        return sum(values[1:]) / len(values[1:])

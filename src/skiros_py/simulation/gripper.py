"""A simulated parallel gripper: two fingers geared together, a gap sensor and a force sensor."""

from __future__ import annotations

import math

from skiros_py.errors import DeviceError
from skiros_py.ports.cell import GripperSpec
from skiros_py.ports.simulation import SimulatedRobot, Surface
from skiros_py.ports.values import GripperState, GripperTarget
from skiros_py.simulation.limits import Standstill

__all__ = ["SimulatedGripper"]

_GAIN = 0.2
_SPEED = 0.1  # greatest finger speed [m/s]; faster fingers dive into what they close on
_DEFAULT_FORCE = 30.0  # [N] per finger, until the first command
_COUPLING_FORCE = 200.0  # [N]
# The anchor remembers where finger and part met. Without it a held part creeps: 0.2 mm per second, and 9 mm for every
# full turn of the robot.
_PADS = Surface(lateral=1.0, anchored=True)
_STILL = 0.001  # [m/s]


class SimulatedGripper:
    """The controller of one parallel gripper; what it holds, it holds by friction.

    Args:
        spec: The gripper; it starts open.
        robot: The robot that it belongs to.

    Attributes:
        fingers: Links of the fingers.
    """

    def __init__(self, spec: GripperSpec, robot: SimulatedRobot) -> None:
        self.spec = spec
        self._joints = robot.joints(spec.joints)
        self.fingers = self._joints.links
        self._target = GripperTarget(spec.max_gap, min(_DEFAULT_FORCE, spec.max_force))
        self._standstill = Standstill(_STILL)
        self._joints.reset([spec.max_gap / 2.0] * len(spec.joints))
        self._joints.set_surface(_PADS)
        # The real drive couples the fingers; without that they slide sideways together with the part.
        self._joints.couple(ratio=1.0, effort=_COUPLING_FORCE)

    @property
    def braking_time(self) -> float:
        """0: a stop does not open or close it."""
        return 0.0

    def command(self, target: GripperTarget | None) -> None:
        """Moves to a new target; None keeps the last one, so that nothing is let go by omission."""
        if target is not None:
            self._target = self._checked(target)
        count = len(self.fingers)
        self._joints.hold_positions(
            [self._target.gap / 2.0] * count, gain=_GAIN, effort=[self._target.force] * count, max_velocity=_SPEED
        )

    def state(self) -> GripperState:
        """Reads the sensors; to be called once per cycle."""
        positions, velocities, efforts = self._joints.read()
        pressing = -sum(efforts) / len(efforts)
        still = self._standstill.update(max(map(abs, velocities)))
        return GripperState(sum(positions), max(0.0, pressing), still)

    def _checked(self, target: GripperTarget) -> GripperTarget:
        if not (math.isfinite(target.gap) and math.isfinite(target.force) and target.force >= 0.0):
            raise DeviceError(f"{self.spec.id}: a target needs a finite gap and force: {target}")
        gap = min(max(target.gap, 0.0), self.spec.max_gap)
        return GripperTarget(gap, min(target.force, self.spec.max_force))

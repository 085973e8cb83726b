"""A simulated arm: joint position control with velocity feed-forward, limits, and braking without a command."""

from __future__ import annotations

import numpy as np

from skiros_py.errors import DeviceError
from skiros_py.geometry import Array
from skiros_py.ports.cell import ArmSpec
from skiros_py.ports.simulation import SimulatedRobot
from skiros_py.ports.values import ArmState, ArmTarget
from skiros_py.simulation.limits import Standstill

__all__ = ["SimulatedArm"]

_GAIN = 0.3
_BRAKING = 7.5
"""Joint deceleration when commands cease [rad/s²]: the weakest joint limit of the Panda."""
_STILL = 0.01  # [rad/s]


class SimulatedArm:
    """The controller of one arm.

    Set-points are followed as a real controller follows them: within joint limits and joint speeds, so that a jump
    in the commands becomes a fast motion and not a teleport. Without a command it brakes along its path and holds.

    Args:
        spec: The arm.
        robot: The robot that it belongs to.
    """

    def __init__(self, spec: ArmSpec, robot: SimulatedRobot) -> None:
        self.spec = spec
        self._joints = robot.joints(spec.joints)
        self._lower, self._upper, self._efforts, self._speeds = self._joints.limits
        self._period = robot.engine.period
        self._reference: Array = np.array(spec.home, dtype=float)
        self._velocity: Array = np.zeros(len(spec.home))
        self._standstill = Standstill(_STILL)
        self._joints.reset(spec.home)

    @property
    def braking_time(self) -> float:
        """Time from full speed of the fastest joint to standing [s]."""
        return float(np.max(self._speeds)) / _BRAKING

    def command(self, target: ArmTarget | None) -> None:
        """Follows a set-point for one cycle; None brakes and holds."""
        if target is None:
            self._brake()
        else:
            self._follow(target)
        # The motor adds the speed during the coming step, so the place to correct towards is where that step begins.
        begin = self._reference - self._velocity * self._period
        self._joints.hold_positions(begin, gain=_GAIN, effort=self._efforts, velocities=self._velocity)

    def state(self) -> ArmState:
        """Reads the joint sensors; to be called once per cycle."""
        positions, velocities, _ = self._joints.read()
        still = self._standstill.update(max(map(abs, velocities)))
        return ArmState(positions, velocities, still)

    def _follow(self, target: ArmTarget) -> None:
        wanted, speed = np.asarray(target.positions), np.asarray(target.velocities)
        expected = self._reference.shape
        if wanted.shape != expected or speed.shape != expected or not np.isfinite([wanted, speed]).all():
            raise DeviceError(f"{self.spec.id}: a target needs {expected[0]} finite positions and velocities: {target}")
        step = self._speeds * self._period
        move = np.clip(np.clip(wanted, self._lower, self._upper) - self._reference, -step, step)
        self._reference = self._reference + move
        self._velocity = np.clip(speed, -self._speeds, self._speeds)

    def _brake(self) -> None:
        """Slows all joints in proportion, so that the arm stays on the line it was moving on."""
        time_to_stop = float(np.max(np.abs(self._velocity))) / _BRAKING
        share = max(0.0, 1.0 - self._period / time_to_stop) if time_to_stop > 0.0 else 0.0
        self._velocity = self._velocity * share
        self._reference = np.clip(self._reference + self._velocity * self._period, self._lower, self._upper)

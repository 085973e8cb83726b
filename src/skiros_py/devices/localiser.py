"""Localisers: where a robot is in the map, with an error like that of a laser localiser."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from skiros_py.devices.common import BASE_STILL, Standstill
from skiros_py.errors import DeviceError
from skiros_py.geometry import Array, Pose
from skiros_py.ports.device import DeviceSignal, FakeRobot, Individual, LocalisingSpec
from skiros_py.ports.kinematics import BASE_JOINTS, BASE_LINK
from skiros_py.ports.simulation import SimulatedRobot

POSITION_NOISE = 0.005
"""Standard deviation of the error in x and in y [m], where the individual says none."""

HEADING_NOISE = math.radians(0.3)
"""Standard deviation of the error of the heading [rad], where the individual says none."""

_SAME = 1e-6  # [m] between two poses that are one
_FADE = 0.5  # way [m], turning counted as [rad], after which an error has nothing in common with the one before


@dataclass(frozen=True, slots=True)
class LocaliserState:
    """Where a localiser estimates its robot to be.

    Attributes:
        pose: Estimated pose of the robot's base frame (on the floor) in the map.
    """

    pose: Pose


@dataclass(frozen=True, slots=True)
class LocaliserSpec(LocalisingSpec[LocaliserState, None]):
    """A localiser: a sensor for the pose of its robot in the map.

    Attributes:
        id: Its element id.
        position_noise: Standard deviation of its error in x and in y [m], in a simulation.
        heading_noise: Standard deviation of its error of the heading [rad], in a simulation.
    """

    kind: ClassVar[str] = "localiser"
    device_class: ClassVar[str] = "sk:Localiser"
    state_type: ClassVar[type] = LocaliserState
    signals: ClassVar[tuple[DeviceSignal[Any], ...]] = (
        DeviceSignal("x", lambda state: state.pose.position[0], "m", "estimated position", "map"),
        DeviceSignal("y", lambda state: state.pose.position[1], "m", "estimated position", "map"),
        DeviceSignal("yaw", lambda state: state.pose.yaw, "rad", "estimated heading", "map"),
    )

    position_noise: float = POSITION_NOISE
    heading_noise: float = HEADING_NOISE

    @classmethod
    def read(cls, individual: Individual) -> Self:
        """Reads how exact it is."""
        return cls(
            individual.id,
            individual.number("sk:positionNoise", POSITION_NOISE),
            individual.number("sk:headingNoise", HEADING_NOISE),
        )

    def fake(self, robot: FakeRobot) -> _FakeLocaliser:
        """Returns a localiser that knows exactly where its robot is."""
        return _FakeLocaliser(robot)

    def simulate(self, robot: SimulatedRobot, rng: np.random.Generator) -> SimulatedLocaliser:
        """Returns a localiser with errors.

        Raises:
            DeviceError: What moves the robot is not in the simulation.
        """
        return SimulatedLocaliser(self, robot, rng)

    def pose(self, state: LocaliserState) -> Pose:
        """Returns the estimate."""
        return state.pose

    def noisy(self, state: LocaliserState, sigma: float, rng: np.random.Generator) -> LocaliserState:
        """Returns a state with noise on x and y [m] and on the heading [rad]."""
        x, y, turn = map(float, rng.normal(0.0, sigma, 3))
        return replace(state, pose=state.pose @ Pose.of(x, y, 0.0, yaw=turn))


class _FakeLocaliser:
    braking_time = 0.0

    def __init__(self, robot: FakeRobot) -> None:
        self._robot = robot

    def command(self, target: None) -> None:
        pass

    def state(self) -> LocaliserState:
        return LocaliserState(self._robot.pose)


class SimulatedLocaliser:
    """Estimates the pose of a robot on wheels.

    The error is constant while the robot stands, and another one at each place to which it drives. On the way it fades
    smoothly from the old one to the new one: the blend is a rotation, so its size stays that of one draw all the way.

    Args:
        spec: The localiser.
        robot: The robot.
        rng: Source of the errors.

    Raises:
        DeviceError: What moves the robot is not in the simulation.
    """

    braking_time = 0.0

    def __init__(self, spec: LocaliserSpec, robot: SimulatedRobot, rng: np.random.Generator) -> None:
        self._plane = robot.joints(BASE_JOINTS)
        x, y, yaw = self._plane.read().positions
        if robot.link(BASE_LINK).pose().distance(Pose.of(x, y, 0.0, yaw=yaw)) > _SAME:
            raise DeviceError(f"{spec.id}: what moves its robot is not simulated: give both the same driver")
        self._period = robot.engine.period
        self._standstill = Standstill(BASE_STILL)
        self._sigmas = (spec.position_noise, spec.position_noise, spec.heading_noise)
        self._rng = rng
        self._old = self._draw()
        self._new = self._old
        self._faded = 1.0
        self._standing = True

    def command(self, target: None) -> None:
        """Does nothing: it is a sensor."""

    def state(self) -> LocaliserState:
        """Estimates the pose; to be called once per cycle."""
        (x, y, yaw), (vx, vy, angular), _ = self._plane.read()
        speed = math.hypot(vx, vy) + abs(angular)
        standing = self._standstill.update(speed)
        if self._standing and not standing:
            self._old, self._new, self._faded = self._error(), self._draw(), 0.0
        self._standing = standing
        if not standing:
            self._faded = min(1.0, self._faded + speed * self._period / _FADE)
        ex, ey, eyaw = self._error().tolist()
        return LocaliserState(Pose.of(x + ex, y + ey, 0.0, yaw=yaw + eyaw))

    def _error(self) -> Array:
        if self._faded >= 1.0:
            return self._new
        angle = self._faded * math.pi / 2.0
        return np.asarray(math.cos(angle) * self._old + math.sin(angle) * self._new)

    def _draw(self) -> Array:
        return self._rng.normal(size=3) * self._sigmas

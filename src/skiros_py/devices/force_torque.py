"""Force-torque sensors between the last joint of an arm and its hand: what the hand is pushed with."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from skiros_py.devices.common import FakeModel
from skiros_py.errors import DescriptionError
from skiros_py.geometry import rotation_matrix
from skiros_py.ports.device import DeviceSignal, DeviceSpec, FakeRobot, Individual
from skiros_py.ports.simulation import SimulatedRobot, Vector

FORCE_NOISE = 0.1
"""Standard deviation of each force [N], where the individual says none."""
TORQUE_NOISE = 0.005
"""Standard deviation of each torque [N m], where the individual says none."""
_GRAVITY = 9.81
_DRAWN = 200
_NOTHING: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class ForceTorqueState:
    """What pushes the hand, without the weight of the hand, at the origin of the sensor's frame and along its axes.

    A hand that presses down onto something is pushed up. What it holds, and what speeds it up, is measured, too.

    Attributes:
        force: Force [N].
        torque: Torque [N m].
    """

    force: Vector = _NOTHING
    torque: Vector = _NOTHING


@dataclass(frozen=True, slots=True)
class ForceTorqueSpec(DeviceSpec[ForceTorqueState, None]):
    """A force-torque sensor at the flange of an arm.

    Attributes:
        id: Its element id.
        arm: Id of the arm that it is on.
        joint: The joint of the robot's URDF that carries the flange: its reaction is measured.
        frame: URDF link of its frame, which does not move against the link behind the joint.
        mass: What the joint carries when the hand is empty [kg].
        centre: Centre of that mass in its frame [m].
        force_noise: Standard deviation of each force [N], in a simulation.
        torque_noise: Standard deviation of each torque [N m], in a simulation.
    """

    kind: ClassVar[str] = "force_torque"
    device_class: ClassVar[str] = "sk:ForceTorqueSensor"
    state_type: ClassVar[type] = ForceTorqueState
    signals: ClassVar[tuple[DeviceSignal[Any], ...]] = (
        DeviceSignal("force", lambda state: state.force, "N", "force on the hand", "own"),
        DeviceSignal("torque", lambda state: state.torque, "N m", "torque on the hand", "own"),
        DeviceSignal("press", lambda state: math.hypot(*state.force), "N", "size of the force"),
    )

    arm: str
    joint: str
    frame: str
    mass: float = 0.0
    centre: Vector = _NOTHING
    force_noise: float = FORCE_NOISE
    torque_noise: float = TORQUE_NOISE

    @classmethod
    def read(cls, individual: Individual) -> Self:
        """Reads the arm that has it, its joint and frame, the load that it leaves out, and its noise."""
        arm = individual.owner("sk:Arm")
        if arm is None:
            raise DescriptionError(f"{individual.id} is on no arm: relate an sk:Arm to it by sk:hasA")
        x, y, z = individual.vector("sk:loadCentre", 3, _NOTHING)
        return cls(
            individual.id,
            arm,
            individual.text("sk:joints"),
            individual.text("sk:frame"),
            individual.number("sk:loadMass", 0.0),
            (x, y, z),
            individual.number("sk:forceNoise", FORCE_NOISE),
            individual.number("sk:torqueNoise", TORQUE_NOISE),
        )

    def fake(self, robot: FakeRobot) -> FakeModel[ForceTorqueState, None]:  # noqa: ARG002 - nothing pushes
        """Returns a sensor that nothing pushes."""
        return FakeModel(ForceTorqueState(), lambda state, _target: state)

    def simulate(self, robot: SimulatedRobot, rng: np.random.Generator) -> SimulatedForceTorque:
        """Returns a sensor that measures the reaction of its joint, with noise."""
        return SimulatedForceTorque(self, robot, rng)

    @property
    def frame_names(self) -> tuple[str, ...]:
        """Its frame."""
        return (self.frame,)

    def noisy(self, state: ForceTorqueState, sigma: float, rng: np.random.Generator) -> ForceTorqueState:
        """Returns a state with noise on each force [N]."""
        x, y, z = (np.asarray(state.force) + rng.normal(0.0, sigma, 3)).tolist()
        return replace(state, force=(x, y, z))


class SimulatedForceTorque:
    """Measures the reaction of a joint, and takes from it the weight of the empty hand.

    Args:
        spec: The sensor.
        robot: Its robot.
        rng: Source of the noise.
    """

    braking_time = 0.0

    def __init__(self, spec: ForceTorqueSpec, robot: SimulatedRobot, rng: np.random.Generator) -> None:
        self._joint = robot.joints((spec.joint,))
        self._joint.reactions()  # engines measure them from the first call on
        self._link = robot.link(spec.frame)
        within = robot.link(self._joint.links[0]).pose().inverse() @ self._link.pose()
        self._from_joint = rotation_matrix(within.orientation).T.tolist()
        self._lever = _turned(self._from_joint, within.position)
        self._mass, self._centre = spec.mass, spec.centre
        self._sigmas = np.repeat((spec.force_noise, spec.torque_noise), 3)
        self._rng = rng
        self._noise: list[list[float]] = []

    def command(self, target: None) -> None:
        """Does nothing: it is a sensor."""

    def state(self) -> ForceTorqueState:
        """Measures; to be called once per cycle."""
        (reaction,) = self._joint.reactions()
        force, torque = _turned(self._from_joint, reaction.force), _turned(self._from_joint, reaction.torque)
        torque = _minus(torque, _cross(self._lever, force))
        weight = self._weight()
        load = _cross(self._centre, weight)
        if not self._noise:  # drawn for many cycles at once: that takes hardly longer than for one
            self._noise = self._rng.normal(0.0, self._sigmas, (_DRAWN, 6)).tolist()
        fx, fy, fz, tx, ty, tz = self._noise.pop()
        return ForceTorqueState(
            (fx - force[0] - weight[0], fy - force[1] - weight[1], fz - force[2] - weight[2]),
            (tx - torque[0] - load[0], ty - torque[1] - load[1], tz - torque[2] - load[2]),
        )

    def _weight(self) -> Vector:
        """Returns the weight of the hand in the sensor's frame [N]."""
        x, y, z, w = self._link.pose().orientation
        down = -self._mass * _GRAVITY
        return 2.0 * (x * z - y * w) * down, 2.0 * (y * z + x * w) * down, (1.0 - 2.0 * (x * x + y * y)) * down


# In plain Python: NumPy takes ten times as long for three numbers, and this runs in each cycle.


def _turned(rows: list[list[float]], vector: Vector) -> Vector:
    (x, y, z), (one, two, three) = vector, rows
    return (
        one[0] * x + one[1] * y + one[2] * z,
        two[0] * x + two[1] * y + two[2] * z,
        three[0] * x + three[1] * y + three[2] * z,
    )


def _cross(one: Vector, other: Vector) -> Vector:
    (ax, ay, az), (bx, by, bz) = one, other
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


def _minus(one: Vector, other: Vector) -> Vector:
    return one[0] - other[0], one[1] - other[1], one[2] - other[2]

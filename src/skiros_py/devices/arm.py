"""Arms: joints in a row, commanded by set-points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from skiros_py.devices.common import FakeModel, Standstill
from skiros_py.errors import DescriptionError, DeviceError
from skiros_py.geometry import Array, Pose
from skiros_py.ports.board import DeviceHandle
from skiros_py.ports.device import Contribution, DeviceSignal, DeviceSpec, FakeRobot, Individual, require_numbers
from skiros_py.ports.kinematics import Kinematics
from skiros_py.ports.motion import MotionPlan, MotionRequest
from skiros_py.ports.simulation import SimulatedRobot

_GAIN = 0.3
_BRAKING = 7.5
"""Joint deceleration when commands cease [rad/s²]: the weakest joint limit of the Panda."""
_STILL = 0.01  # [rad/s]
_EXACT = 1e-6
"""What a description may be beyond a limit by rounding [rad]."""
_BENT = 0.02
"""Distance of each joint from the end of a motion at which the arm has arrived, for displays [rad]."""
_MOST_POSES = 60
"""Maximum number of poses shown of a planned motion."""


@dataclass(frozen=True, slots=True)
class ArmState:
    """Joint sensors of one arm.

    Attributes:
        positions: Joint angles [rad], shape (n,).
        velocities: Joint speeds [rad/s], shape (n,).
        still: True when every joint is slower than the arm's standstill threshold.
        efforts: What the joints exert [N m], shape (n,); empty where they are not measured.
    """

    positions: tuple[float, ...]
    velocities: tuple[float, ...]
    still: bool
    efforts: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class ArmTarget:
    """Joint set-points for one cycle: positions [rad] and feed-forward velocities [rad/s], shape (n,)."""

    positions: tuple[float, ...]
    velocities: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class ArmSpec(DeviceSpec[ArmState, ArmTarget]):
    """One arm; without a target it brakes along its path and holds.

    Attributes:
        id: Its element id.
        joints: Joint names in the robot's URDF, in the order of every vector about this arm.
        tip: URDF link that motions are planned for (the tool centre point).
        home: Joint angles [rad] in which it starts and travels.
        accelerations: Greatest joint accelerations [rad/s²]; empty where they are not known.
    """

    kind: ClassVar[str] = "arm"
    device_class: ClassVar[str] = "sk:Arm"
    state_type: ClassVar[type] = ArmState
    target_type: ClassVar[type] = ArmTarget
    signals: ClassVar[tuple[DeviceSignal[Any], ...]] = (
        DeviceSignal("positions", lambda state: state.positions, "rad", "joint angles"),
        DeviceSignal("velocities", lambda state: state.velocities, "rad/s", "joint speeds"),
        DeviceSignal("efforts", lambda state: state.efforts, "N m", "joint efforts"),
        DeviceSignal("still", lambda state: state.still, help="whether it stands"),
    )
    jog: ClassVar[tuple[str, ...]] = ("jog_joints", "jog_tool", "home")
    teach: ClassVar[tuple[str, ...]] = ("teach_grasp", "teach_placing_pose")

    joints: tuple[str, ...]
    tip: str
    home: tuple[float, ...]
    accelerations: tuple[float, ...] = ()

    @classmethod
    def read(cls, individual: Individual) -> Self:
        """Reads ``sk:joints``, ``sk:tip``, ``sk:home`` and, where there are any, ``sk:maxJointAccelerations``."""
        joints = tuple(individual.text("sk:joints").split())
        home = individual.vector("sk:home")
        if len(home) != len(joints):
            raise DescriptionError(f"{individual.id}: sk:home has {len(home)} angles for {len(joints)} joints")
        accelerations = individual.vector("sk:maxJointAccelerations", default=())
        if accelerations and (len(accelerations) != len(joints) or min(accelerations) <= 0.0):
            needed = f"takes a positive number for each of {len(joints)} joints, not {accelerations}"
            raise DescriptionError(f"{individual.id}: sk:maxJointAccelerations {needed}")
        return cls(individual.id, joints, individual.text("sk:tip"), home, accelerations)

    def fake(self, robot: FakeRobot) -> FakeModel[ArmState, ArmTarget]:  # noqa: ARG002 - it is there at once
        """Returns an arm that reaches its targets within the cycle."""
        return FakeModel(_resting(self.home), _followed)

    def simulate(self, robot: SimulatedRobot, rng: np.random.Generator) -> SimulatedArm:  # noqa: ARG002 - nothing is drawn
        """Returns its controller in a simulation."""
        return SimulatedArm(self, robot)

    def still(self, state: ArmState) -> bool:
        """Returns True when no joint moves."""
        return state.still

    def check(self, target: ArmTarget) -> None:
        """Refuses what is no target, has numbers that are none, or the wrong count of them."""
        DeviceSpec.check(self, target)
        require_numbers(self.id, target, target.positions, target.velocities)
        count = len(self.joints)
        if len(target.positions) != count or len(target.velocities) != count:
            raise DeviceError(f"{self.id}: a target needs {count} positions and {count} velocities: {target}")

    def planned_poses(self, request: MotionRequest, plan: MotionPlan, kinematics: Kinematics | None) -> Sequence[Pose]:
        """Returns poses of the tip, evenly spread over the motion; none without kinematics."""
        rows = [row for leg in plan.legs for row in leg.positions.tolist()]
        if kinematics is None or not rows:
            return ()
        shown = np.unique(np.linspace(0, len(rows) - 1, min(len(rows), _MOST_POSES)).round().astype(int))
        postures = (dict(zip(self.joints, rows[index], strict=True)) for index in shown)
        return [request.base @ kinematics.pose(self.tip, posture) for posture in postures]

    def has_arrived(
        self,
        state: ArmState,
        robot: Pose,  # noqa: ARG002
        request: MotionRequest,  # noqa: ARG002
        plan: MotionPlan,
        cycles: float,
    ) -> bool:
        """Returns whether it stands in the last posture, which it may also pass on the way."""
        if cycles < sum(len(leg.positions) for leg in plan.legs) or not state.still:
            return False
        return not plan.legs or bool(np.abs(np.subtract(state.positions, plan.legs[-1].positions[-1])).max() < _BENT)

    def mixed(self, contributions: Sequence[Contribution[ArmTarget]]) -> ArmTarget:
        """Returns the weighted mean of set-points and velocities."""
        weights = [one.weight for one in contributions]
        positions = np.average([one.target.positions for one in contributions], axis=0, weights=weights)
        velocities = np.average([one.target.velocities for one in contributions], axis=0, weights=weights)
        return ArmTarget(tuple(positions.tolist()), tuple(velocities.tolist()))

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Its joints."""
        return self.joints

    def joint_positions(self, state: ArmState) -> tuple[float, ...]:
        """Returns its joint angles [rad]."""
        return state.positions

    @property
    def frame_names(self) -> tuple[str, ...]:
        """Its tip."""
        return (self.tip,)

    def noisy(self, state: ArmState, sigma: float, rng: np.random.Generator) -> ArmState:
        """Returns a state with noise on each joint angle [rad]."""
        blurred = np.asarray(state.positions) + rng.normal(0.0, sigma, len(state.positions))
        return replace(state, positions=tuple(map(float, blurred)))


class Arm(DeviceHandle[ArmSpec, ArmState, ArmTarget]):
    """An arm in the hands of a primitive.

    Sample a motion by the clock of the run: then it brakes along its own path when the run is paused.
    """

    spec_type: ClassVar[Any] = ArmSpec


def _followed(state: ArmState, target: ArmTarget | None) -> ArmState:
    if target is None:
        return _resting(state.positions)
    return ArmState(target.positions, target.velocities, not any(target.velocities))


def _resting(positions: tuple[float, ...]) -> ArmState:
    return ArmState(positions, (0.0,) * len(positions), True)


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
        self._lower, self._upper, efforts, self._speeds = self._joints.limits
        self._most_effort = efforts.tolist()
        self._require_home()
        self._period = robot.engine.period
        self._reference: Array = np.array(spec.home, dtype=float)
        self._velocity: Array = np.zeros(len(spec.home))
        self._standstill = Standstill(_STILL)
        self._joints.reset(spec.home)

    def _require_home(self) -> None:
        spec = self.spec
        for joint, angle, lower, upper in zip(spec.joints, spec.home, self._lower, self._upper, strict=True):
            if lower < upper and not lower - _EXACT <= angle <= upper + _EXACT:
                beyond = f"sk:home has {angle:g} rad for {joint}, which turns from {lower:g} to {upper:g} rad"
                raise DescriptionError(f"{spec.id}: {beyond}")

    @property
    def braking_time(self) -> float:
        """Time from full speed of the fastest joint to standing [s]."""
        return float(np.max(self._speeds)) / _BRAKING

    def command(self, target: ArmTarget | None) -> None:
        """Follows a set-point for one cycle; None brakes and holds."""
        if target is not None:
            self._follow(target)
        elif self._velocity.any():
            self._brake()
        # The motor adds the speed during the coming step, so the place to correct towards is where that step begins.
        begin = self._reference - self._velocity * self._period
        self._joints.hold_positions(
            begin.tolist(), gain=_GAIN, effort=self._most_effort, velocities=self._velocity.tolist()
        )

    def state(self) -> ArmState:
        """Reads the joint sensors; to be called once per cycle."""
        positions, velocities, efforts = self._joints.read()
        still = self._standstill.update(max(map(abs, velocities)))
        return ArmState(positions, velocities, still, efforts)

    def _follow(self, target: ArmTarget) -> None:
        self.spec.check(target)
        wanted, speed = np.asarray(target.positions), np.asarray(target.velocities)
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

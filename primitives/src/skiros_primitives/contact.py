"""Contact that nothing expects: felt in what the joints exert, answered within one control cycle.

The residual is that of De Luca and Haddadin (IROS 2006) without a filter: measured efforts less those that the motion,
gravity and the load account for. A contact beyond joint k loads joints 1 to k, so the last loaded joint says where.
"""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from skiros_py.devices.arm import Arm, ArmSpec, ArmState, ArmTarget
from skiros_py.devices.force_torque import ForceTorqueSpec, ForceTorqueState
from skiros_py.errors import DeviceError
from skiros_py.geometry import Array, Pose, rotation_matrix
from skiros_py.ports.board import DeviceHandle
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.kinematics import BASE_JOINTS, Dynamics, JointMotion, Kinematics
from skiros_py.skills.context import RunContext
from skiros_py.skills.primitive import Execution
from skiros_py.world import vocabulary as v
from skiros_py.world.element import Placement
from skiros_py.world.poses import write_pose
from skiros_py.world.world import World

TOLERANCE = 4.0
"""Residual that still counts as friction and noise, in a joint of up to ``_STRENGTH`` [N m]."""
GENTLE = 1.5
"""The same in slow motions that end where the arm is to touch something [N m]."""
_STRENGTH = 400.0
"""What a joint can exert up to which these hold; in a stronger one, friction and noise grow with it [N m]."""
_TRACE = 1.0
"""Residual from which such a joint counts as loaded when the place of a contact is estimated [N m]."""
_GRAVITY = 9.81
_CERTAIN = 2.0
"""Times the tolerance that is a contact at once, without a load; less has to be felt in two cycles in a row."""
_ARM_LENGTH = 1.0
"""Lever at which a load that slips by a hair in the fingers loads a joint for one cycle, and less than it [m]."""
_WRIST = 3
"""Joints at the end of the arm whose axes nearly meet: a contact beyond the first of them is one of the hand."""


@dataclass(frozen=True, slots=True)
class Touch:
    """A contact.

    Attributes:
        effort: Residual of the joint that feels it most [N m].
        link: The link that is touched, as far as known.
        point: Where about, in the frame of the base [m] ...
        end: ... or between there and here.
        direction: Unit vector in which that link moved.
        before: The links between it and the base, which are not touched.
    """

    effort: float
    link: str
    point: tuple[float, float, float]
    end: tuple[float, float, float]
    direction: tuple[float, float, float]
    before: frozenset[str] = frozenset()

    def may_be(self, link: str) -> bool:
        """Returns whether it may be a contact of a link, or of what is held."""
        return link not in self.before


def believe_obstacle(world: World, author: str, pose: Pose, size: tuple[float, float, float], reason: str) -> str:
    """Writes that something is in the way, so that later motions go around it; returns its id.

    Args:
        world: The world model.
        author: Who found it.
        pose: The middle of its lower side, in the map.
        size: Length, width and height of the block that is assumed [m].
        reason: How it was found.
    """
    box = json.dumps([{"kind": "box", "size": size, "at": (0.0, 0.0, size[2] / 2.0)}])
    with world.transaction(author=author, reason=reason) as tx:
        floor = next(iter(world.instances(v.FLOOR)), None) or world.instances(v.UNKNOWN_LOCATION)[0]
        found = tx.add(v.OBSTACLE, properties={v.SOLID: box}, placement=Placement(v.ON, floor))
        write_pose(tx, found, pose)
    return found


_KNOCK = 5.0
"""Acceleration that no base has by itself [m/s², rad/s²]."""
_SWINGING = 0.2
"""Time after such a knock in which its arms feel nothing else [s]."""


class WholeMotion:
    """How a robot moves, its base and its arms, from cycle to cycle: each loads the joints of the others.

    Attributes:
        is_knocked: Whether its base sped up or slowed down in the last cycle as only a collision does it.

    Args:
        context: The run.
        robot: The robot.
    """

    def __init__(self, context: RunContext, robot: RobotSpec) -> None:
        self._board = context.board
        self._base = robot.carrier
        self._arms = robot.of(ArmSpec)
        self.joints = (*(BASE_JOINTS if self._base else ()), *(joint for arm in self._arms for joint in arm.joints))
        self._before = self._speeds()
        self.is_knocked = False

    @property
    def stands(self) -> bool:
        """True when the base stands, or there is none."""
        return self._base is None or self._board.stand([self._base.id])

    def since_before(self) -> JointMotion:
        """Returns the motion of all joints, in the frame of the base; to be called once per cycle."""
        speeds = self._speeds()
        accelerations, self._before = (speeds - self._before) / self._board.period, speeds
        if self._base is not None:
            self.is_knocked = bool(np.abs(accelerations[: len(BASE_JOINTS)]).max() > _KNOCK)
            ahead, aside, around = speeds[: len(BASE_JOINTS)]
            accelerations[:2] += -aside * around, ahead * around  # it drives while it turns
        return JointMotion(self.joints, self._positions(), speeds, accelerations)

    def as_if_even(self) -> JointMotion:
        """Returns the motion of all joints as if none sped up."""
        return JointMotion(self.joints, self._positions(), self._before, np.zeros(len(self._before)))

    def _states(self) -> list[ArmState]:
        return [self._board.snapshot.state(arm.id, ArmState) for arm in self._arms]

    def _positions(self) -> Array:
        resting = [0.0] * len(BASE_JOINTS) if self._base else []
        return np.array([*resting, *(angle for state in self._states() for angle in state.positions)])

    def _speeds(self) -> Array:
        speeds: list[float] = []
        if self._base is not None:
            state = self._board.snapshot.devices[self._base.id]
            speeds = [getattr(state, name, None) or 0.0 for name in ("linear", "sideways", "angular")]
        return np.array([*speeds, *(speed for state in self._states() for speed in state.velocities)])


class ContactWatch:
    """Watches one motion of an arm, which begins at rest; to be asked once per cycle.

    What counts as a contact is told by each joint for itself: 4 N m, or 1 % of what a stronger joint can exert. The
    force behind it depends on where it acts: 4 N m are 4 N at 1 m from the axis. An arm whose first joints exert
    3000 N m feels there from 30 N m on: at its tip, 1.8 m away, 17 N.

    The load is weighed at the start: it is the force at the tip that explains best what the joints exert there. A
    contact that is there already may become weaker, but not stronger. While the base drives, the next cycle counts as
    the start: before it, nothing says whether the base speeds up.

    Attributes:
        weight: What the arm carries at its tip [N].
        tolerance: Residual that is no contact yet, in a joint that is not stronger than usual; less for slow motions
            that shall feel more [N m].

    Args:
        context: The run.
        arm: The arm.
        expected: Force at the tip that may come and go on the way without being a contact, such as the weight of a part
            that is lifted [N].
        tolerance: See above.
    """

    def __init__(self, context: RunContext, arm: Arm, *, expected: float = 0.0, tolerance: float = TOLERANCE) -> None:
        self._kinematics = context.port(Kinematics, arm.id)
        self._dynamics = context.port(Dynamics, arm.id)
        self._arm = arm
        self._board = context.board
        self._asked = context.board.snapshot.time
        self._expected, self.tolerance = expected, tolerance
        self._motion = WholeMotion(context, context.cell.group_of(arm.id))
        self._own = [self._motion.joints.index(joint) for joint in arm.spec.joints]
        strengths = [self._kinematics.joints[joint].effort or 0.0 for joint in arm.spec.joints]
        self._scale = np.maximum(1.0, np.array(strengths) / _STRENGTH)  # how much more each joint feels by error
        self.weight = 0.0
        self._swings = 0.0
        self._residual = np.zeros(len(arm.spec.joints))  # in the last cycle
        self._tip_speed: Array | None = None  # in the last cycle, along the axes of the base
        self._at_start: Array | None = None
        if self._motion.stands:
            self._weigh(self._left(self._motion.as_if_even()), self._lever(arm.state))

    def _weigh(self, left: Array, lever: Array) -> None:
        # What is being taken or put down still presses on its support: then the force at the tip is no weight.
        weighed = not self._expected
        self.weight = max(0.0, float(lever @ left) / max(1e-9, float(lever @ lever))) if weighed else 0.0
        self._at_start = np.abs(left - self.weight * lever)

    @property
    def touches_at_start(self) -> bool:
        """True when the arm touches something before it moves."""
        return self._at_start is not None and bool((self._at_start > self.tolerance * self._scale).any())

    @classmethod
    def of(
        cls, context: RunContext, arm: Arm, *, expected: float = 0.0, tolerance: float = TOLERANCE
    ) -> ContactWatch | None:
        """Returns a watch, or None for an arm that measures no efforts or whose dynamics are unknown."""
        known = context.ports.find(Dynamics, arm.id) is not None
        return cls(context, arm, expected=expected, tolerance=tolerance) if known and arm.state.efforts else None

    def felt(self) -> Touch | None:
        """Returns the contact in this cycle, or None; also None in the first cycle after a pause."""
        state = self._arm.state
        elapsed, self._asked = self._board.snapshot.time - self._asked, self._board.snapshot.time
        left, lever = self._left(self._motion.since_before()), self._lever(state)
        if self._motion.is_knocked:  # the arm swings: that is felt by the base, not by the arm
            self._swings = self._asked + _SWINGING
        if elapsed > 1.5 * self._board.period or self._asked < self._swings:  # how it came to its speed was not seen
            return None
        if self._at_start is None:
            self._weigh(left, lever)
        residual, before = left - self.weight * lever, self._residual
        self._residual = residual
        size = np.abs(residual)
        if (size <= _CERTAIN * self.tolerance * self._scale + self.weight * _ARM_LENGTH).all():
            # What slips in the fingers is caught in the next cycle: then the joints feel the opposite.
            size = np.minimum(size, np.abs(before)) * (residual * before > 0.0)
        over = size - self._at_start - self._expected * np.abs(lever)
        strongest = int(np.argmax(over / self._scale))
        is_felt = over[strongest] > self.tolerance * self._scale[strongest]
        return self._touch(state, left, float(over[strongest])) if is_felt else None

    def _left(self, motion: JointMotion) -> Array:
        efforts = self._arm.state.efforts
        if len(efforts) != len(self._own) or not np.isfinite(efforts).all():
            raise DeviceError(
                "{arm} does not measure what its joints exert: it would feel no contact", arm=self._arm.id
            )
        return np.asarray(efforts) - self._dynamics.efforts(motion)[self._own]

    def _lever(self, state: ArmState) -> Array:
        """Returns what the joints exert per weight at the tip, which has to be carried and sped up [m]."""
        spec = self._arm.spec
        positions = dict(zip(spec.joints, state.positions, strict=True))
        turn = rotation_matrix(self._kinematics.pose(spec.tip, positions).orientation)
        jacobian = turn @ self._kinematics.jacobian(spec.tip, positions, spec.joints)[:3]
        speed = jacobian @ np.asarray(state.velocities)
        gained = np.zeros(3) if self._tip_speed is None else (speed - self._tip_speed) / self._board.period
        self._tip_speed = speed
        return np.asarray((np.array([0.0, 0.0, 1.0]) + gained / _GRAVITY) @ jacobian)

    def _touch(self, state: ArmState, left: Array, effort: float) -> Touch:
        spec = self._arm.spec
        positions = dict(zip(spec.joints, state.positions, strict=True))
        loaded = int(np.flatnonzero(np.abs(left) > _TRACE * self._scale).max(initial=0))
        link, jacobian = spec.tip, self._kinematics.jacobian(spec.tip, positions, spec.joints)
        wrist = len(spec.joints) - _WRIST
        first, inner = min(loaded, wrist), jacobian
        while inner[:, first + 1 :].any() and link in self._kinematics.parents:
            link = self._kinematics.parents[link]
            inner = self._kinematics.jacobian(link, positions, spec.joints)
        before, end = frozenset(_above(self._kinematics, link)), self._kinematics.pose(link, positions).position
        if loaded < wrist:
            jacobian = inner
        else:
            link = spec.tip
        pose = self._kinematics.pose(link, positions)
        moved = rotation_matrix(pose.orientation) @ jacobian[:3] @ np.asarray(state.velocities)
        ahead = moved / max(1e-9, float(np.linalg.norm(moved)))
        return Touch(effort, link, pose.position, end, (float(ahead[0]), float(ahead[1]), float(ahead[2])), before)


PRESS = 5.0
"""Force on a hand from which on it presses onto something [N]."""
_MEAN = 4
"""Cycles over which the force on a hand is averaged."""
_WEIGHED = 10
"""Cycles in which what a hand holds is weighed."""


class HandForce:
    """What pushes the hand of an arm besides what it holds, by a force-torque sensor; to be asked once per cycle.

    A hand that speeds up downwards feels as light as one that is pushed up: what its mass and that of what it holds
    need to be sped up is taken off.

    Args:
        context: The run.
        arm: The arm.
        sensor: Its sensor.
    """

    def __init__(self, context: RunContext, arm: Arm, sensor: ForceTorqueSpec) -> None:
        self._kinematics = context.port(Kinematics, arm.id)
        self._arm, self._spec = arm, sensor
        self._sensor = DeviceHandle[ForceTorqueSpec, ForceTorqueState, None](context.board, sensor.id)
        self._board = context.board
        self._recent: deque[Array] = deque(maxlen=_MEAN)
        self._held = np.zeros(6)
        self._height = 0.0  # of the tip above the sensor
        self._asked, self._speed = -np.inf, np.zeros(3)  # when, and how fast the sensor moved then

    @classmethod
    def of(cls, context: RunContext, arm: Arm) -> HandForce | None:
        """Returns the force on an arm's hand; None where nothing measures it.

        Raises:
            DeviceError: What measures it is closed.
        """
        sensors = [one for one in context.cell.group_of(arm.id).of(ForceTorqueSpec) if one.arm == arm.id]
        known = context.ports.find(Kinematics, arm.id) is not None
        return cls(context, arm, sensors[0]) if sensors and known else None

    def weigh(self) -> Execution[None]:
        """Takes what pushes the hand at rest now as the weight of what it holds.

        Raises:
            DeviceError: The sensor does not answer.
        """
        seen = []
        for _ in range(_WEIGHED):
            self._arm.command(ArmTarget(self._arm.state.positions, (0.0,) * len(self._arm.spec.joints)))
            yield
            seen.append(self._now())
        self._held = np.mean(seen, axis=0)
        tip, flange = (
            self._kinematics.pose(link, self._positions()) for link in (self._arm.spec.tip, self._spec.frame)
        )
        self._height = tip.position[2] - flange.position[2]
        self._recent.clear()

    def push(self) -> Array:
        """Returns the mean force of the last cycles, along the axes of the base [N], shape (3,); z is upwards.

        Raises:
            DeviceError: The sensor does not answer.
        """
        now = self._board.snapshot.time
        if now > self._asked:
            joints = self._arm.spec.joints
            jacobian = self._axes() @ self._kinematics.jacobian(self._spec.frame, self._positions(), joints)[:3]
            speed = jacobian @ np.asarray(self._arm.state.velocities)
            gained = (speed - self._speed) / (now - self._asked)
            self._asked, self._speed = now, speed
            self._recent.append(self._now() - self._held + self._to_speed_up(gained))
        return np.asarray(np.mean(self._recent, axis=0)[:3])

    def pressed_at(self) -> Array:
        """Returns x and y of where what was returned last presses, from the sensor, along the axes of the base [m]."""
        fx, fy, fz, tx, ty, _ = np.mean(self._recent, axis=0)
        return np.asarray(np.array([self._height * fx - ty, self._height * fy + tx]) / max(1.0, fz))

    def _now(self) -> Array:
        turn, state = self._axes(), self._sensor.state
        return np.concatenate([turn @ state.force, turn @ state.torque])

    def _to_speed_up(self, gained: Array) -> Array:
        """Returns force and moment of an acceleration [m/s²]; what is held counts as in the middle of the hand."""
        force = (self._spec.mass + max(0.0, -float(self._held[2])) / _GRAVITY) * gained
        return np.concatenate([force, np.cross(self._axes() @ self._spec.centre, force)])

    def _axes(self) -> Array:
        return rotation_matrix(self._kinematics.pose(self._spec.frame, self._positions()).orientation)

    def _positions(self) -> dict[str, float]:
        return dict(zip(self._arm.spec.joints, self._arm.state.positions, strict=True))


def _above(kinematics: Kinematics, link: str) -> Iterator[str]:
    """Yields the links that carry a link."""
    while link in kinematics.parents:
        link = kinematics.parents[link]
        yield link

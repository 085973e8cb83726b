"""Postures: arms move to their travelling posture, or home with open grippers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from skiros_primitives.arm_moves import ArmPrimitive, carrying_postures, is_stowed
from skiros_primitives.floor_obstacles import reaches_over
from skiros_py.devices.arm import ArmSpec, ArmState
from skiros_py.devices.gripper import GripperSpec, GripperState
from skiros_py.geometry import Pose
from skiros_py.messages import Message
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.motion import JointMove, MotionPlan, NoMotion
from skiros_py.skills.context import RunContext
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.surroundings import map_pose
from skiros_py.world.vocabulary import ARM, DRIVING_POSE, HELD_BY, LOCATION, ROBOT

_POSTURES = {0: Message("home"), 5: Message("home, turned aside"), 6: Message("home, turned aside")}
"""What postures for travelling are called; the others are with the hand turned."""
_HERE = 0.05
"""What a joint may be beyond its limits as it is measured [rad or m]."""
_FELT = 2.0
"""Finger force from which the gripper counts as holding something [N]."""


class Home(Primitive[Any]):
    """Moves one arm or all arms home and opens empty grippers; one that holds something stays closed."""

    name: ClassVar[str] = "home"
    takes: ClassVar[tuple[str, ...]] = ("robot",)

    robot: str = param(ROBOT, "The robot.", kind=Kind.PLANNING)
    arm: str | None = param(ARM, "The arm; left out: all arms.", kind=Kind.OPTIONAL)

    def start(self) -> Failure | None:
        """Checks that the arm belongs to the robot."""
        if self.arm not in (None, *(arm.id for arm in self._robot.of(ArmSpec))):
            return Failure(Message("{arm} is no arm of {robot}", arm=self.arm, robot=self.robot))
        return None

    def execute(self) -> Execution[Outcome]:
        """Moves the arms first: anything between the fingers must not fall where it cannot be seen."""
        arm, robot = self.arm, self.robot
        moved = yield from self.call("move_arm", arm=arm) if arm else self.call("stow_arms", robot=robot)
        if isinstance(moved, Failure):
            return moved
        grippers = [gripper for gripper in self._robot.of(GripperSpec) if arm in (None, gripper.arm)]
        holding = [gripper.id for gripper in grippers if self._holds(gripper)]
        for gripper in grippers:
            if gripper.id not in holding:
                opened = yield from self.call("gripper_control", gripper=gripper.id)
                if isinstance(opened, Failure):
                    return opened
        return Success(Message("home; {holding} stays closed", holding=", ".join(holding)) if holding else "home")

    @property
    def _robot(self) -> RobotSpec:
        return next(r for r in self.context.cell.robots if r.id == self.robot)

    def _holds(self, gripper: GripperSpec) -> bool:
        """Returns whether it holds a part, believed or sensed: an unknown part must not be dropped, either."""
        felt = self.context.board.snapshot.state(gripper.id, GripperState).force >= _FELT
        return felt or bool(self.world.subjects(HELD_BY, gripper.id))


class MoveArm(ArmPrimitive):
    """Moves around obstacles to a posture for travelling, with whatever is held."""

    name: ClassVar[str] = "move_arm"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        arm: str = param(ARM, "The arm that moves.", kind=Kind.HARDWARE)
        location: str | None = param(LOCATION, "Where the base drives next; left out: anywhere.", kind=Kind.OPTIONAL)
        rehearse: bool = param("boolean", "Whether it only finds out if there is a way there.", default=False)

    def execute(self) -> Execution[Outcome]:
        """Plans and moves: home, or else to another posture for carrying."""
        if not self.is_planned:
            refusal = None if self.params.rehearse else (yield from self.go_straight(self.arm.spec.home))
            return Success(Message("home")) if refusal is None else self._stuck(refusal)
        found = yield from self.plan_posture(self.params.location)
        if isinstance(found, Failure):
            return found
        number, planned = found
        if self.params.rehearse:
            return Success(Message("there is a way home"))
        refusal = yield from self.follow_plan(planned)
        if refusal is None:
            return Success(_POSTURES.get(number, Message("home, with the hand turned")))
        self._note(number)
        return self._stuck(refusal)

    def plan_posture(self, location: str | None) -> Execution[tuple[int, MotionPlan] | Failure]:
        """Plans the motion to a posture for carrying, rather one that was not tried in vain yet.

        Args:
            location: Where the base drives next; None for anywhere.

        Returns:
            The number of the posture and the plan; or why there is none.
        """
        postures, stuck = carrying_postures(self.arm.spec), NoMotion("")
        robot, spec = self.robot, self.arm.spec
        fitting: list[int] = []
        for number, posture in enumerate(postures):
            fitting += [number] if fits(self.context, robot, spec, posture, location) else []
            yield
        for number in self.context.tried.fresh("posture", fitting or range(len(postures))):
            planned = yield from self.plan([(JointMove(postures[number]),)])
            if isinstance(planned, MotionPlan):
                return number, planned
            self._note(number)
            stuck = stuck if stuck.reason else planned
        return self._stuck(stuck)

    def _note(self, number: int) -> None:
        self.context.tried.note("posture", number, Message("posture {number}", number=number + 1))

    def _stuck(self, refusal: NoMotion) -> Failure:
        return Failure(Message("the arm cannot go home: {reason}", reason=refusal.reason))


def fits(context: RunContext, robot: RobotSpec, arm: ArmSpec, posture: Sequence[float], location: str | None) -> bool:
    """Returns whether an arm gets into a posture, and there touches nothing where its base stands and at a location.

    Of a robot that nothing moves only its joints tell: the planner finds out what its arm would touch.
    """
    kinematics = context.frames.kinematics(robot)
    ranges = {} if kinematics is None else kinematics.joints
    for joint, at in zip(arm.joints, posture, strict=True):
        limits = ranges.get(joint)
        if limits is not None and limits.lower is not None and limits.upper is not None:  # noqa: SIM102
            if not limits.lower - _HERE <= at <= limits.upper + _HERE:
                return False
    if robot.carrier is None:
        return True
    poses = [robot.pose(context.board.snapshot, context.board.guard)]
    if location is not None:
        place, driving = map_pose(context, location), context.world.value(location, DRIVING_POSE)
        poses += [place @ driving] if place is not None and isinstance(driving, Pose) else []
    return not any(reaches_over(context, robot, arm.id, posture, pose) for pose in poses)


def unstowed(context: RunContext, robot: RobotSpec, location: str | None) -> list[ArmSpec]:
    """Returns the arms of a robot that are in no posture in which it may drive to a location."""
    found = []
    for arm in robot.of(ArmSpec):
        now = context.board.snapshot.state(arm.id, ArmState).positions
        if not (is_stowed(context, arm) and fits(context, robot, arm, now, location)):
            found.append(arm)
    return found


class StowArms(Primitive[Any]):
    """Moves all arms to postures for travelling, which must not touch what stands where the base drives."""

    name: ClassVar[str] = "stow_arms"
    takes: ClassVar[tuple[str, ...]] = ("robot",)

    robot: str = param(ROBOT, "The robot.", kind=Kind.PLANNING)
    location: str | None = param(LOCATION, "Where the base drives next; left out: anywhere.", kind=Kind.OPTIONAL)

    def execute(self) -> Execution[Outcome]:
        """Moves the arms one after the other."""
        robot = next(r for r in self.context.cell.robots if r.id == self.robot)
        for arm in unstowed(self.context, robot, self.location):
            outcome = yield from self.call("move_arm", arm=arm.id, location=self.location)
            if isinstance(outcome, Failure):
                return outcome
        return Success(Message("stowed"))

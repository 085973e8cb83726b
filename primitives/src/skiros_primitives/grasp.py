"""Grasps a registered part, lifts it, and checks by touch and by a look whether it is held, and how."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from skiros_primitives.arm_moves import HandlingPrimitive, further, refused
from skiros_primitives.docking import can_put_down
from skiros_primitives.gripper import firm_force, move_fingers, opening
from skiros_primitives.part_models import Grasp as GraspData
from skiros_primitives.part_models import grasp_of, leaning, level
from skiros_primitives.playback import reversed_way
from skiros_py.devices.gripper import Gripper, GripperState
from skiros_py.errors import DescriptionError
from skiros_py.geometry import Pose
from skiros_py.messages import Message, joined
from skiros_py.ports.motion import MotionPlan, NoMotion, Trajectory
from skiros_py.skills.outcome import Failure, Outcome, Success, tick
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution
from skiros_py.skills.surroundings import map_pose
from skiros_py.world.element import Placement
from skiros_py.world.poses import write_pose
from skiros_py.world.vocabulary import ARM, CAMERA, GRIPPER, HELD_BY, MANIPULATABLE

_GAP_TOLERANCE = 0.007
"""Maximum difference between finger gap and part width when grasped [m]."""
_FIRM = 2.0
"""Minimum force per finger on a held part [N]."""
_TRIES = 2
"""How often it is tried to put a part back that was being lifted."""
_MOST_OFF = 0.015
"""A part that sits farther from where it was to be grasped is put down and grasped again [m]."""


class Grasp(HandlingPrimitive):
    """Comes from straight above; approach and lift are both checked before anything moves."""

    name: ClassVar[str] = "grasp"

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        arm: str = param(ARM, "The arm.", kind=Kind.HARDWARE)
        gripper: str = param(GRIPPER, "The gripper on it.", kind=Kind.HARDWARE)
        camera: str = param(CAMERA, "The camera on the hand, which sees what is held.", kind=Kind.HARDWARE)
        part: str = param(MANIPULATABLE, "The part; its pose is known exactly.")

    _lifting = False
    _from: Placement | None = None
    """Where the part was until it was gripped; None while it is not."""

    def start(self) -> Failure | None:
        """Checks that a grasp is known for the part."""
        try:
            grasp_of(self.world, self.params.part)
        except DescriptionError as error:
            return Failure(str(error))
        return None

    def execute(self) -> Execution[Outcome]:
        """Approaches, closes, lifts, checks the grasp."""
        part_pose = map_pose(self.context, self.params.part)
        if part_pose is None:
            return Failure(Message("{part} has no exact pose yet", part=self.params.part))
        grasp = grasp_of(self.world, self.params.part)
        self.opening = opening(self.gripper_spec, grasp.width)
        if abs(self.gripper.state.gap - self.opening) > _GAP_TOLERANCE:
            yield from self.open_wide(self.gripper)
        poses = (*grasp.poses, *leaning(grasp.poses))
        chosen, planned = yield from self._plan(level(part_pose), poses, len(grasp.poses))
        if isinstance(planned, NoMotion):
            reason = Message("{part} cannot be reached: {reason}", part=self.params.part, reason=planned.reason)
            return Failure(reason, values=planned.values)
        outcome = yield from self._take(planned, part_pose, grasp, poses[chosen])
        if isinstance(outcome, Failure):
            turn = math.degrees(poses[chosen].yaw)
            self.context.tried.note("grasp", chosen, Message("grasped turned by {turn:.0f} deg", turn=turn))
        return outcome

    def _plan(self, part: Pose, poses: Sequence[Pose], straight: int) -> Execution[tuple[int, MotionPlan | NoMotion]]:
        """Plans a grasp from straight above; a leaning one where that is out of reach, here or where the part goes.

        Args:
            part: Where the part is, in the map.
            poses: The grasps, in the frame of the part.
            straight: How many of these, the first ones, do not lean.
        """
        place = self.world.placement(self.params.part)
        touching, tools = {self.params.part, *([place.place] if place else [])}, [part @ pose for pose in poses]
        planning = self.plan_fresh("grasp", tools, touching, range(straight))
        checking = can_put_down(self, self.robot, self.arm.spec, self.params.part, poses[:straight])
        planned, delivers = tick(planning), tick(checking)
        while planned is None or delivers is None:
            yield
            planned = tick(planning) if planned is None else planned
            delivers = tick(checking) if delivers is None else delivers
        chosen, plan = planned
        if isinstance(plan, MotionPlan) and delivers:
            return chosen, plan
        leans, other = yield from self.plan_fresh("grasp", tools, touching, range(straight, len(poses)))
        if isinstance(other, MotionPlan):
            return leans, other
        return chosen, plan if isinstance(plan, MotionPlan) else further(plan, other)

    def _take(self, planned: MotionPlan, part_pose: Pose, grasp: GraspData, wanted: Pose) -> Execution[Outcome]:
        gripper, up = self.gripper, planned.legs[-1]
        refusal = yield from self.come_down(planned)
        if refusal is not None:
            return refused(refusal)
        self.progress(2, Message("closing"))
        yield from move_fingers(self.context, gripper, 0.0, firm_force(self.gripper_spec))
        guess = self._expected(self.tool_pose().inverse() @ part_pose, wanted)
        state = gripper.state
        if _holds(state, grasp):  # believed at once: if it is stopped from here on, it is known what is in the hand
            self._from = self.world.placement(self.params.part)
            self._believe_held(guess)
        self.progress(3, Message("lifting"))
        self._lifting = True
        refusal = yield from self.follow(up, expected=self.weight(self.params.part), landing=0.0)
        if refusal is not None:
            yield from self.recover()
            return refused(refusal)
        self.retreat = None
        state = gripper.state
        if not _holds(state, grasp):
            expected = Message("expected {width:.0f}", width=grasp.width * 1000.0)
            return (yield from self._let_go(gripper, joined(", ", (_felt(state), expected)), up))
        sits = yield from self._look(guess)
        if isinstance(sits, str):
            return (yield from self._let_go(gripper, sits, up))
        self._believe_held(sits)
        return Success(Message("holds {part}: {state}", part=self.params.part, state=_felt(gripper.state)))

    @staticmethod
    def _expected(at_closing: Pose, wanted: Pose) -> Pose:
        """Returns how the part sits as far as known without a look, in the frame of the tip.

        Args:
            at_closing: Where it was when the fingers closed, as registered.
            wanted: The grasp; the fingers centre and align what they close on.
        """
        nominal = wanted.inverse()
        x, _, z = at_closing.position
        return Pose((x, nominal.position[1], z), nominal.orientation)

    def _believe_held(self, sits: Pose) -> None:
        with self.world.transaction(author=self.name, reason=_felt(self.gripper.state)) as tx:
            tx.place(self.params.part, HELD_BY, self.params.gripper)
            write_pose(tx, self.params.part, sits, self.params.gripper)

    def _believe_back(self, reason: str) -> None:
        """Writes that the part is where it was taken from, but not exactly where."""
        before, self._from = self._from, None
        with self.world.transaction(author=self.name, reason=reason) as tx:
            if before is not None:
                tx.place(self.params.part, before.relation, before.place)
            write_pose(tx, self.params.part, None)

    def _look(self, guess: Pose) -> Execution[Pose | str]:
        """Returns how the part sits in the gripper, in the frame of the tip; or what speaks against holding it so.

        Args:
            guess: How it sits as far as known.
        """
        image = yield from self.take_picture(self.params.camera)
        found = yield from self.how_it_sits(image, self.params.camera, self.params.part, guess, self._around())
        if found is None or (found.pose is None and not found.visible):
            return guess
        if found.pose is None:
            return found.reason
        off = found.pose.distance(guess)
        return found.pose if off <= _MOST_OFF else Message("it sits {off:.0f} mm off", off=off * 1000.0)

    def recover(self) -> Execution[None]:
        """Opens at the bottom and retracts along the checked line; a part being lifted is put back first."""
        if self.retreat is None:
            return
        if self._lifting:
            down, weight, refusal = reversed_way(self.retreat, slower=2), self.weight(self.params.part), None
            for _ in range(_TRIES):
                refusal = yield from self.follow_from_here(down, expected=weight)
                if refusal is None:
                    break
            self._lifting = False
            if refusal is not None:
                return  # not dropped from where it is
        if self._from is not None:
            self._believe_back(Message("put back"))
        yield from self.open_wide(self.gripper)
        yield from self.follow_from_here(self.retreat)
        self.retreat = None

    def _let_go(self, gripper: Gripper, found: str, up: Trajectory) -> Execution[Outcome]:
        """Puts down whatever is between the fingers and opens; the part then has to be located again."""
        if gripper.state.force >= _FIRM:  # something is held, but not as expected: do not drop it
            yield from self.follow(reversed_way(up, slower=2), expected=self.weight(self.params.part), landing=0.0)
            self.retreat, self._lifting = up, False
        self._believe_back(Message("grasp failed: {found}", found=found))
        yield from self.open_wide(gripper)
        yield from self.recover()
        reason = Message("{part} is not in the gripper after the lift: {found}", part=self.params.part, found=found)
        return Failure(reason, values={"cause": "not grasped"})


def _holds(state: GripperState, grasp: GraspData) -> bool:
    """Returns whether fingers that have closed feel the part between them."""
    return abs(state.gap - grasp.width) <= _GAP_TOLERANCE and state.force >= _FIRM


def _felt(state: GripperState) -> str:
    return Message("gap {gap:.0f} mm, force {force:.0f} N", gap=max(0.0, state.gap) * 1000.0, force=state.force)

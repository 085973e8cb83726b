"""What arms do while their base drives: one is stowed while the base leaves, and one reaches out while it arrives.

The area that an arm covers at each moment of its motion is checked along the stretch of the path on which the base may
be at that moment; the base waits where the arm is not that far yet.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skiros_primitives.arm_moves import carrying_postures
from skiros_primitives.floor_obstacles import reaches_over
from skiros_primitives.looking import LookingPrimitive
from skiros_primitives.lookout import Lookout
from skiros_primitives.postures import MoveArm
from skiros_primitives.surfaces import support_region
from skiros_py.devices.arm import ArmSpec
from skiros_py.devices.camera import CameraSpec
from skiros_py.geometry import Array, Pose, wrap_angle
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.motion import ArmPlanner, MotionPlan, Vector
from skiros_py.ports.paths import Path
from skiros_py.skills.context import RunContext
from skiros_py.skills.outcome import Execution, Failure, Outcome, Success, tick
from skiros_py.skills.surroundings import map_pose
from skiros_py.world import vocabulary as v

_LEAVING = 0.40
"""Way from its start on which an arm may still be extended [m] ..."""
_WAITING = 0.28
"""... and after which the base waits for it: it brakes within the rest."""
_PLANNING = 0.40
"""Way left when the motion of an arm that reaches out is planned [m] ..."""
_REACHING = 0.20
"""... and when it begins at the earliest; it begins so that it takes as long as the rest of the drive."""
_BRAKING = 0.5
"""How fast bases brake at the end [m/s²], about."""
_RETREAT = 0.35
"""Way before its goal to which the base may come back meanwhile, when it meets something [m], from where it came."""
_NEAR = 0.1
"""Way before its goal at which it is looked from where the base comes [m]."""
_STRAIGHT = math.radians(5.0)
"""Greatest difference from the heading at the goal on that way [rad]."""
_CHECKED = 12
"""Number of postures of a motion whose areas are checked, one per cycle."""
_STRANGE = 1.0
"""An arm does not reach out where something unknown is seen this near to the place [m]."""


class _TravellingArm(MoveArm, LookingPrimitive):
    """Plans and follows the motions of one arm, in the name of the drive."""

    name: ClassVar[str] = "drive_base"
    looks_ahead: ClassVar[bool] = False  # it moves with its base: what is seen there now is not what is there then

    @dataclass(frozen=True, slots=True)
    class Params:
        """Parameters."""

        arm: str
        camera: str = ""
        rehearse: bool = False


class TravellingArms:
    """The arms of one robot during one drive; the base and they run at the same time.

    Attributes:
        postures: Joint angles with which arms travel that are stowed only while the base leaves, by id [rad].
        met: Why an arm could not be stowed; None while all is well.
        lookout: Watches the drive to the goal; None before that, and on other ways.
        ended: True once the base has ended.

    Args:
        context: The run.
        robot: The robot.
        location: Where it drives.
        goal: Where its base works there, in the map.
    """

    def __init__(self, context: RunContext, robot: RobotSpec, location: str, goal: Pose) -> None:
        self._context = context
        self._robot = robot
        self._location = location
        self._goal = goal
        self._start = self._pose
        self._comes_from = -1.0, 0.0
        self._stowing: tuple[_TravellingArm, MotionPlan] | None = None
        self._reaching: _TravellingArm | None = None
        self._began = self._clear_after = math.inf
        self.postures: dict[str, tuple[float, ...]] = {}
        self.met: Failure | None = None
        self.lookout: Lookout | None = None
        self.ended = False

    def plans(self, arm: ArmSpec) -> bool:
        """Returns whether there is a planner for an arm: none moves beside its base without."""
        return self._context.ports.find(ArmPlanner, arm.id) is not None

    def plan_stowing(self, arm: ArmSpec) -> Execution[Outcome]:
        """Plans how an arm gets into a posture for travelling."""
        mover = _TravellingArm(self._context, _TravellingArm.Params(arm.id))
        found = yield from mover.plan_posture(self._location)
        if isinstance(found, Failure):
            return found
        number, planned = found
        self._stowing = mover, planned
        self.postures[arm.id] = carrying_postures(arm)[number]
        return Success()

    def move(self) -> Execution[Outcome]:
        """Stows what was planned, and reaches out when the base arrives; ends after the base."""
        if self._stowing is not None:
            mover, planned = self._stowing
            self._began = self._context.now
            refusal = yield from mover.follow_plan(planned)
            self._stowing = None
            if refusal is not None:
                self.met = Failure(refusal.reason)
                return self.met
        while not (self.ended or self._is_near(_PLANNING)):
            yield
        return Success() if self.ended else (yield from self._reach_out())

    # ------------------------------------------------------------------ for the base

    def find_clear(self, path: Path) -> Execution[None]:
        """Finds out from when on the arm that is being stowed is clear of everything where the base will be."""
        self._comes_from = _last_direction(path, self._start, self._goal)
        if self._stowing is None:
            return
        mover, planned = self._stowing
        way = [pose for _, pose in path.poses(self._start, way=_LEAVING / 4.0)]
        near = [self._start, *(pose for pose in way if math.dist(pose.position, self._start.position) <= _LEAVING)]
        postures = np.vstack([leg.positions for leg in planned.legs])
        for sample in reversed(_samples(postures)):
            if reaches_over(self._context, self._robot, mover.params.arm, postures[sample].tolist(), *near):
                return
            self._clear_after = sample * self._context.board.period
            yield

    def must_wait(self) -> bool:
        """Returns whether the base must not drive on now, because of the arm that is being stowed."""
        if self._stowing is None:
            return False
        if self._stowing[0].touched or self._context.now < self._began + self._clear_after:
            return True
        return math.dist(self._pose.position, self._start.position) > _WAITING

    @property
    def touched(self) -> bool:
        """True when an arm has met something."""
        stowing = self._stowing[0] if self._stowing is not None else None
        return self.met is not None or any(arm.touched for arm in (stowing, self._reaching) if arm is not None)

    def settled(self) -> Execution[None]:
        """Waits until the arm that is being stowed has ended its motion."""
        while self._stowing is not None:
            yield

    # ------------------------------------------------------------------ reaching out

    @property
    def _pose(self) -> Pose:
        return self._robot.pose(self._context.board.snapshot, self._context.board.guard)

    def _is_near(self, way: float) -> bool:
        """Returns whether the base is on the last straight way to its goal [m]."""
        here = self._pose
        straight = abs(wrap_angle(here.yaw - self._goal.yaw)) < _STRAIGHT
        return self.lookout is not None and straight and math.dist(here.position, self._goal.position) <= way

    def _reach_out(self) -> Execution[Outcome]:
        """Moves a camera over the place as soon as the base is that far; leaves it where that is not safe."""
        arm = self._camera_arm()
        looked_at = self._looked_at(arm) if arm is not None else None
        if arm is None or looked_at is None:
            return Success()
        point, shown = looked_at
        planning = arm.plan_look(point, self._goal, shown)
        while (planned := tick(planning)) is None and not self.ended:
            yield
        if not isinstance(planned, MotionPlan):
            planning.close()
            return Success()
        postures = np.vstack([leg.positions for leg in planned.legs])
        x, y = self._comes_from
        way = self._goal @ Pose((_RETREAT * x, _RETREAT * y, 0.0)), self._goal
        for sample in _samples(postures):
            if reaches_over(self._context, self._robot, arm.params.arm, postures[sample].tolist(), *way):
                return Success()
            yield
        left = 0.5 * _BRAKING * (len(postures) * self._context.board.period) ** 2
        begins = min(_REACHING, left)
        while not (self.ended or self._is_near(begins)):
            yield
        if self._is_near(begins) and not self._is_strange(point):
            self._reaching = arm
            yield from arm.follow_plan(planned)
        return Success()

    def _camera_arm(self) -> _TravellingArm | None:
        """Returns an arm with a camera, for which there is a planner."""
        world = self._context.world
        cameras = {camera.id for camera in self._robot.of(CameraSpec)}
        for arm in self._robot.of(ArmSpec):
            mine = next((one for one in world.objects(arm.id, v.HAS_A) if one in cameras), None)
            if mine is not None and self.plans(arm):
                return _TravellingArm(self._context, _TravellingArm.Params(arm.id, mine))
        return None

    def _looked_at(self, arm: _TravellingArm) -> tuple[Vector, Vector | None] | None:
        """Returns what a look at the place looks at first, and what it should show; None where no look is to come.

        An empty hand is for parts that lie there; what is held goes into the first empty piece of the place.
        """
        world = self._context.world
        if arm.held() is None:
            region = support_region(self._context, self._location)
            return None if isinstance(region, str) else (region.pose.position, None)
        place = map_pose(self._context, self._location)
        hollows = (one for one in world.objects(self._location, v.HAS_A) if world.value(one, v.HOLLOW) is True)
        empty = (map_pose(self._context, one) for one in hollows if not world.subjects(v.IN, one))
        shown = next((pose for pose in empty if pose is not None), None)
        return (place.position, shown.position) if place is not None and shown is not None else None

    def _is_strange(self, point: Vector) -> bool:
        """Returns whether the scanners see something unknown near the place."""
        strange = self.lookout.strange if self.lookout is not None else np.empty((0, 3))
        return bool((np.hypot(*(strange[:, :2] - point[:2]).T) < _STRANGE).any())


def _last_direction(path: Path, start: Pose, goal: Pose) -> tuple[float, float]:
    """Returns from which direction, seen from its goal, a base comes there; from behind if it does not drive far."""
    away = ((goal.inverse() @ pose).position for _, pose in path.poses(start, way=_NEAR))
    far = [(x, y) for x, y, _ in away if math.hypot(x, y) >= _NEAR]
    x, y = far[-1] if far else (-1.0, 0.0)
    return x / math.hypot(x, y), y / math.hypot(x, y)


def _samples(postures: Array) -> list[int]:
    """Returns the numbers of postures that are spread over a motion, with its ends."""
    return sorted({round(sample) for sample in np.linspace(0, len(postures) - 1, _CHECKED).tolist()})

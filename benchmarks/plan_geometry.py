"""The motions of a plan: paths of the base, grasps and releases with their ways; or what geometry forbids."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np
import shapely

from skiros_primitives.arm_moves import LIFTS, above_routes, carrying_postures
from skiros_primitives.docking import docks_around
from skiros_primitives.floor_obstacles import shape
from skiros_primitives.gripper import opening
from skiros_primitives.part_models import grasp_of, leaning, level
from skiros_primitives.put_down import finger_room, fitting_quarters
from skiros_primitives.sighting import on_floor
from skiros_primitives.surfaces import inner_region, kit_of
from skiros_py.devices.arm import ArmSpec
from skiros_py.devices.gripper import GripperSpec
from skiros_py.geometry import Array, Pose
from skiros_py.motion.base_paths import BasePaths
from skiros_py.motion.pinocchio.arm_motion import ArmMotion
from skiros_py.planning.plan import Step
from skiros_py.planning.requests import RuledOut
from skiros_py.ports.adapters import InstalledPorts
from skiros_py.ports.kinematics import BASE_LINK, Kinematics
from skiros_py.ports.motion import (
    BasePathRequest,
    Held,
    JointMove,
    MotionPlan,
    MotionRequest,
    NoMotion,
    Obstacle,
    ReachRequest,
    Route,
)
from skiros_py.ports.paths import floor_area, placed
from skiros_py.skills.context import RunContext
from skiros_py.skills.surroundings import held_by, map_pose, obstacles, solid_of
from skiros_py.station.session import Session
from skiros_py.world import vocabulary as v
from skiros_py.world.overlay import Overlay

_DROP = 0.004
"""Height above the floor of a compartment at which a part is released [m]."""
_GAP = 0.03
"""Smallest distance between a base that has docked and what stands around [m]."""
_LEAST_ROOM = 0.004
"""Fingers must open by so much to release a part [m]."""


@dataclass
class Motion:
    """One motion of a plan.

    Attributes:
        step: What it is part of.
        base: Where the base stands, in the map.
        postures: Joint angles on the way [rad], shape (n, joints).
        around: What must not be touched.
        gap: Between the fingers [m].
        held: What the gripper holds, or None.
    """

    step: str
    base: Pose
    postures: Array
    around: tuple[Obstacle, ...]
    gap: float
    held: Held | None


@dataclass
class Situation:
    """What is so after some steps of a plan.

    Attributes:
        world: The world then.
        base: Where the base stands, in the map.
        posture: Joint angles of the arm [rad].
    """

    world: Overlay
    base: Pose
    posture: tuple[float, ...]

    @property
    def key(self) -> tuple[object, ...]:
        """What motions depend on."""
        parts = [(one, self.world.placement(one)) for one in self.world.instances(v.MANIPULATABLE)]
        return (*parts, self.base, self.posture)


@dataclass
class Geometry:
    """Finds the motions of a plan, or the first fact that forbids it.

    Attributes:
        session: Where the scene is open.
        calls: How many motions were planned.
    """

    session: Session
    calls: int = 0
    _known: dict[tuple[object, ...], tuple[list[Motion], Situation] | RuledOut] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.robot = self.session.spec.robots[0]
        self.arm, self.gripper = self.robot.of(ArmSpec)[0], self.robot.of(GripperSpec)[0]
        self.motion, self.paths = ArmMotion(self.robot), BasePaths()
        self.ports = InstalledPorts(self.session.spec.groups)
        context = self.session.runtime.context
        self.start = Situation(
            Overlay(context.world), self.robot.pose(context.board.snapshot, context.board.guard), tuple(self.arm.home)
        )

    def context(self, now: Situation) -> RunContext:
        """Returns a context in which the world is as in a situation."""
        return replace(self.session.runtime.context, world=now.world, ports=self.ports)  # type: ignore[arg-type]

    def motions(self, steps: Sequence[Step]) -> list[Motion] | RuledOut:
        """Returns the motions of a plan, or why one of its steps has none."""
        now, found = self.start, list[Motion]()
        for number, step in enumerate(steps):
            after = steps[number + 1] if step.skill == "drive" and number + 1 < len(steps) else None
            key = (str(step), str(after), *now.key)
            if key not in self._known:
                self._known[key] = self._step(now, step, after)
            known = self._known[key]
            if isinstance(known, RuledOut):
                return known
            motions, now = known
            found += motions
        return found

    def _step(self, now: Situation, step: Step, after: Step | None) -> tuple[list[Motion], Situation] | RuledOut:
        then = replace(now, world=now.world.copy())
        if step.skill == "drive":
            return self._drive(then, step, after)
        return self._pick(then, step) if step.skill == "pick" else self._place(then, step)

    # ------------------------------------------------------------------ driving

    def _drive(self, now: Situation, step: Step, after: Step | None) -> tuple[list[Motion], Situation] | RuledOut:
        """Drives to the first dock from which the arm reaches what comes next, and to which there is a path."""
        context, location = self.context(now), step.arguments["Location"]
        place, driving = map_pose(context, location), now.world.value(location, v.DRIVING_POSE)
        assert place is not None
        assert isinstance(driving, Pose)
        things, taught = obstacles(context, parts=False), place @ driving
        target = step.arguments["Location"] if after is None else after.arguments[_TARGET[after.skill]]
        tools, held = self._tools(context, after), held_by(context, self.gripper.id)
        docks = [taught, *self._docks(context, location, taught, tools)]
        touching = frozenset({location, target, *((kit_of(now.world, target),) if held else ())})
        request = ReachRequest(
            device=self.arm.id,
            bases=tuple(docks),
            targets=(tuple((tool, Pose((0.0, 0.0, LIFTS[-1])) @ tool) for tool in tools),) if tools else (),
            near=self.arm.home,
            obstacles=things,
            held=held[1] if held else None,
            touching=touching,
            enough=len(docks),
        )
        layers = shape(context, self.robot, {self.arm.id: now.posture})
        why = "out of reach from every dock"
        for dock, reached in zip(docks, self.motion.reach(request), strict=True):
            if None in reached:
                continue
            self.calls += 1
            path = self.paths.plan(BasePathRequest(now.base, dock, layers, things))
            if not isinstance(path, NoMotion):
                now.base = dock
                now.world.place(self.robot.id, v.AT, location)
                return [], now
            why = path.reason
        return RuledOut(None, self.robot.id, target, None, why)

    def _tools(self, context: RunContext, after: Step | None) -> list[Pose]:
        """Returns the poses of the tip that the next step may need."""
        if after is None:
            return []
        if after.skill == "pick":
            at, grasp = map_pose(context, after.arguments["Object"]), grasp_of(context.world, after.arguments["Object"])
            assert at is not None
            return [level(at) @ pose for pose in (*grasp.poses, *leaning(grasp.poses))]
        return [tool for tool, _ in self._releases(context, after.arguments["Compartment"])]

    def _docks(self, context: RunContext, location: str, taught: Pose, tools: Sequence[Pose]) -> list[Pose]:
        thing = on_floor(context, location)
        if thing is None or not tools:
            return []
        kinematics, link = self.ports.port(Kinematics, self.arm.id), self.arm.tip
        while (parent := kinematics.parents.get(link, BASE_LINK)) != BASE_LINK:
            link = parent
        mount = kinematics.pose(link, {})
        wanted = np.array([tool.position[:2] for tool in tools])
        area = floor_area(thing.solid, thing.pose)
        docks = docks_around(area, self.robot.outline, mount, taught, wanted)
        around = shapely.union_all([floor_area(one.solid, one.pose) for one in obstacles(context, parts=False)])
        free = (one for one in docks if not shapely.dwithin(placed(self.robot.outline, one), around, _GAP - 1e-3))
        return sorted(free, key=taught.distance)

    # ------------------------------------------------------------------ picking and placing

    def _pick(self, now: Situation, step: Step) -> tuple[list[Motion], Situation] | RuledOut:
        context, part, place = self.context(now), step.arguments["Object"], step.arguments["Container"]
        at, grasp, solid = map_pose(context, part), grasp_of(now.world, part), solid_of(now.world, part)
        assert at is not None
        assert solid is not None
        poses = (*grasp.poses, *leaning(grasp.poses))
        tools, gap = [level(at) @ pose for pose in poses], opening(self.gripper, grasp.width)
        touching = frozenset({part, place})
        refusal: NoMotion | None = None
        for some, lift in product((range(len(grasp.poses)), range(len(grasp.poses), len(poses))), LIFTS):
            routes = above_routes([tools[number] for number in some], touching, lift)
            found = self._planned(now, context, routes, gap, None)
            if isinstance(found, NoMotion):
                refusal = refusal or found
                continue
            grasped = poses[some[found.route]].inverse()
            around = obstacles(context, parts=True)
            ways = [Motion(str(step), now.base, found.legs[0].positions, around, gap, None)]
            ways.append(Motion(str(step), now.base, found.legs[1].positions, _without(around, touching), gap, None))
            now.world.place(part, v.HELD_BY, self.gripper.id)
            now.world.set_value(part, v.POSE, grasped)
            for frame in now.world.objects(part, v.POSE_FRAME):
                now.world.unset_relation(part, v.POSE_FRAME, frame)
            now.world.set_relation(part, v.POSE_FRAME, self.gripper.id)
            now.posture = tuple(found.legs[-1].positions[-1].tolist())
            return self._stowed(now, step, ways, grasp.width, Held(solid, grasped), part)
        assert refusal is not None
        return self._refused(now, step, part, refusal)

    def _place(self, now: Situation, step: Step) -> tuple[list[Motion], Situation] | RuledOut:
        context, compartment = self.context(now), step.arguments["Compartment"]
        part, held = held_by(context, self.gripper.id) or ("", None)
        assert held is not None
        width, around = grasp_of(now.world, part).width, obstacles(context, parts=True)
        choices = self._releases(context, compartment)
        rooms = [finger_room(around, tool, width, self.gripper.finger) for tool, _ in choices]
        open_ = [choice for choice, room in zip(choices, rooms, strict=True) if room >= _LEAST_ROOM]
        refusal = NoMotion("the fingers cannot open there") if not open_ else None
        touching = frozenset({part, compartment})
        for lift in (0.18, 0.14, LIFTS[-1]) if open_ else ():
            routes = above_routes([tool for tool, _ in open_], touching, lift)
            found = self._planned(now, context, routes, width, held)
            if isinstance(found, NoMotion):
                refusal = refusal or found
                continue
            ways = [Motion(str(step), now.base, leg.positions, around, width, held) for leg in found.legs[:2]]
            now.world.place(part, v.IN, compartment)
            now.world.unset_relation(part, v.POSE_FRAME, self.gripper.id)
            now.world.set_value(part, v.POSE, open_[found.route][1])
            now.posture = tuple(found.legs[-1].positions[-1].tolist())
            return self._stowed(now, step, ways, width + _LEAST_ROOM, None, compartment)
        assert refusal is not None
        if not open_:
            near = self._nearest(now, part, choices[0][0])
            return RuledOut(step.skill, self.arm.id, compartment, None, refusal.reason, near)
        return self._refused(now, step, compartment, refusal)

    def _releases(self, context: RunContext, compartment: str) -> list[tuple[Pose, Pose]]:
        """Returns poses of the tip at which what is held may be released, each with where it is put."""
        region, held = inner_region(context, compartment), held_by(context, self.gripper.id)
        assert not isinstance(region, str)
        assert held is not None
        low, high = held[1].solid.bounds()
        quarters = fitting_quarters(((high - low)[:2] / 2.0).tolist(), region.half_extents)
        poses = [level(region.pose @ Pose.of(0.0, 0.0, _DROP, yaw=one * np.pi / 2.0)) for one in quarters]
        return [(pose @ held[1].pose.inverse(), pose) for pose in poses]

    def _stowed(
        self, now: Situation, step: Step, ways: list[Motion], gap: float, held: Held | None, target: str
    ) -> tuple[list[Motion], Situation] | RuledOut:
        """Adds the way into a posture for driving."""
        context = self.context(now)
        found = self._planned(now, context, [(JointMove(one),) for one in carrying_postures(self.arm)], gap, held)
        if isinstance(found, NoMotion):
            return self._refused(now, step, target, found)
        around = obstacles(context, parts=True)
        ways.append(Motion(str(step), now.base, found.legs[0].positions, around, gap, held))
        now.posture = tuple(found.legs[0].positions[-1].tolist())
        return ways, now

    def _planned(
        self, now: Situation, context: RunContext, routes: Sequence[Route], gap: float, held: Held | None
    ) -> MotionPlan | NoMotion:
        self.calls += 1
        request = MotionRequest(
            device=self.arm.id,
            start=now.posture,
            base=now.base,
            routes=tuple(routes),
            obstacles=obstacles(context, parts=True),
            held=held,
            gap=gap,
        )
        return self.motion.plan(request)

    def _refused(self, now: Situation, step: Step, target: str, why: NoMotion) -> RuledOut:
        """Returns what a refusal rules out: the attempt, or only while the first part that blocks it lies there."""
        touched = [body for one in why.refusals for _, body in one.touches]
        for body in dict.fromkeys(touched):
            at = now.world.placement(body) if now.world.has(body) else None
            if body != target and at is not None and at.relation == v.IN:
                return RuledOut(step.skill, self.arm.id, target, None, why.reason, (body, at.place))
        return RuledOut(step.skill, self.arm.id, target, None, why.reason)

    def _nearest(self, now: Situation, held: str, tool: Pose) -> tuple[str, str] | None:
        """Returns the part in a compartment that is nearest to where another one is to be released, and its place."""
        there = [
            (pose.distance(tool), one, at.place)
            for one in now.world.instances(v.MANIPULATABLE)
            if one != held
            and (at := now.world.placement(one)) is not None
            and (pose := map_pose(self.context(now), one)) is not None
            and pose.distance(tool) < 0.15
        ]
        return min(there)[1:] if there else None


_TARGET = {"pick": "Object", "place": "Compartment", "drive": "Location"}


def _without(around: Iterable[Obstacle], touching: frozenset[str]) -> tuple[Obstacle, ...]:
    return tuple(one for one in around if one.id not in touching)

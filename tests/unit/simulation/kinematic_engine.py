"""A second physics engine, for tests: joints do what they are told, bodies stay where they are put, nothing collides.

Forward kinematics are Pinocchio's. Rays, and with them pictures, meet the bounding box of each primitive.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pinocchio as pin

from skiros_py.errors import DeviceError, UnknownName, UsageError
from skiros_py.geometry import Array, Pose, Solid
from skiros_py.ports.simulation import (
    FLOOR,
    Colour,
    Contact,
    JointLimits,
    JointReadings,
    RayHit,
    Rendering,
    Surface,
    Twist,
    Vector,
    View,
    Wrench,
)
from skiros_py.ports.values import CameraIntrinsics, Done

T = TypeVar("T")


@dataclass
class _Body:
    solid: Solid
    pose: Pose
    mass: float
    colour: Colour
    on: tuple[str, str, Pose] | None = None  # robot, link, pose in the link


class KinematicEngine:
    """An engine without dynamics."""

    name = "kinematic"

    def __init__(self, *, period: float, gui: bool = False) -> None:
        if gui:
            raise UsageError("the kinematic engine has no window")
        self.period = period
        self.robots: dict[str, _Robot] = {}
        self.bodies: dict[str, _Body] = {}

    def step(self) -> None:
        for robot in self.robots.values():
            robot.step()
        for body in self.bodies.values():
            if body.on is not None:
                name, link, relative = body.on
                body.pose = self.robots[name].link(link).pose() @ relative

    def add_robot(self, name: str, urdf: Path, pose: Pose = Pose()) -> _Robot:  # noqa: B008
        self._require_free(name)
        self.robots[name] = _Robot(self, name, urdf, pose)
        return self.robots[name]

    def add_body(
        self,
        name: str,
        solid: Solid,
        pose: Pose,
        *,
        mass: float = 0.0,
        colour: Colour,
        surface: Surface = Surface(),  # noqa: B008
    ) -> None:
        self._require_free(name)
        self.bodies[name] = _Body(solid, pose, mass, colour)

    def remove_body(self, name: str) -> None:
        self._body(name)
        del self.bodies[name]

    def move_body(self, name: str, pose: Pose) -> None:
        self._body(name).pose = pose

    def attach(self, body: str, robot: str, link: str) -> None:
        attached, at = self._body(body), self._robot(robot).link(link)
        if attached.mass <= 0.0 or attached.on is not None:
            raise UsageError(f"'{body}' has no mass, or is attached already")
        attached.on = (robot, link, at.pose().inverse() @ attached.pose)

    def detach(self, body: str) -> None:
        if self._body(body).on is None:
            raise UnknownName("attached body", body, [])
        self.bodies[body].on = None

    def pose(self, body: str) -> Pose:
        return self._body(body).pose

    def poses(self) -> dict[str, Pose]:
        return {name: body.pose for name, body in self.bodies.items()}

    def twist(self, body: str) -> Twist:
        self._body(body)
        return Twist()

    def contacts(self, name: str, link: str | None = None) -> tuple[Contact, ...]:
        if name not in self.bodies:
            self._robot(name)
        return ()

    def apply_wrench(self, name: str, wrench: Wrench, *, at: Vector | None = None, link: str = "") -> None:
        raise DeviceError("the kinematic engine knows no forces")

    def cast_rays(self, starts: Array, ends: Array) -> tuple[RayHit | None, ...]:
        fraction, which, normals = self._meet(np.asarray(starts), np.asarray(ends))
        names = [FLOOR, *(name for name, body in self.bodies.items() for _ in body.solid.primitives)]
        points = starts + np.where(fraction > 1.0, 0.0, fraction)[:, None] * (ends - starts)
        return tuple(
            None if f > 1.0 else RayHit(names[n], "", float(f), tuple(p), tuple(normal))
            for f, n, p, normal in zip(fraction, which, points, normals, strict=True)
        )

    def prepare_rendering(self) -> None:
        """Nothing to start."""

    def intrinsics(self, view: View) -> CameraIntrinsics:
        focal = view.height / 2.0 / math.tan(view.vertical_fov / 2.0)
        return CameraIntrinsics(
            view.width, view.height, focal, focal, view.width / 2.0, view.height / 2.0, view.near, view.far
        )

    def render(self, view: View, finish: Callable[[Rendering], T], *, latency: float = 0.0) -> Done[T]:
        k = self.intrinsics(view)
        link = Pose() if view.robot is None else self._robot(view.robot).link(view.link).pose()
        u, v = np.meshgrid(np.arange(k.width), np.arange(k.height))
        along = np.stack([(u - k.cx) / k.fx, (v - k.cy) / k.fy, np.ones(u.shape)], axis=-1).reshape(-1, 3)
        at = link @ view.pose
        fraction, _, _ = self._meet(at.apply(along * view.near), at.apply(along * view.far))
        depth = np.where(fraction > 1.0, np.inf, view.near + fraction * (view.far - view.near))
        shape = (k.height, k.width)
        return Done(finish(Rendering(depth.reshape(shape), np.zeros((*shape, 3), np.uint8))), latency)

    def look_at(self, target: Vector, distance: float) -> None:
        """No window."""

    def state_bytes(self) -> bytes:
        joints = [np.concatenate([robot.q, robot.v]) for robot in self.robots.values()]
        poses = [np.array((*body.pose.position, *body.pose.orientation)) for body in self.bodies.values()]
        return bytes(np.concatenate([*joints, *poses, np.zeros(0)]).tobytes())

    def save(self) -> object:
        states = {name: (robot.q.copy(), robot.v.copy()) for name, robot in self.robots.items()}
        return states, {name: copy.copy(body) for name, body in self.bodies.items()}

    def restore(self, state: Any) -> None:
        states, bodies = state
        if states.keys() != self.robots.keys() or bodies.keys() != self.bodies.keys():
            raise DeviceError("this state was saved with others in the world")
        for name, (q, v) in states.items():
            self.robots[name].q, self.robots[name].v = q.copy(), v.copy()
        self.bodies = {name: replace(body) for name, body in bodies.items()}

    def close(self) -> None:
        """Nothing to end."""

    def _meet(self, starts: Array, ends: Array) -> tuple[Array, Array, Array]:
        """Returns where each ray meets something first (share of it), which one (0: the floor), and the normal."""
        way = ends - starts
        with np.errstate(divide="ignore", invalid="ignore"):
            floor = -starts[:, 2] / way[:, 2]
        best = np.where((floor >= 0.0) & (way[:, 2] < 0.0), floor, np.inf)
        which, normals = np.zeros(len(starts), int), np.tile((0.0, 0.0, 1.0), (len(starts), 1))
        number = 0
        for body in self.bodies.values():
            for block in body.solid.primitives:
                number += 1
                at = body.pose @ block.pose
                size = block.size if block.kind == "box" else (2 * block.size[0], 2 * block.size[0], block.size[1])
                fraction, normal = _meet_box(at.inverse(), np.asarray(size) / 2.0, starts, ends)
                nearer = fraction < best
                best, which = np.where(nearer, fraction, best), np.where(nearer, number, which)
                normals = np.where(nearer[:, None], normal @ at.matrix()[:3, :3].T, normals)
        return best, which, normals

    def _require_free(self, name: str) -> None:
        if name in self.bodies or name in self.robots or name == FLOOR:
            raise UsageError(f"there is a '{name}' in the world already")

    def _body(self, name: str) -> _Body:
        if name not in self.bodies:
            raise UnknownName("body", name, self.bodies)
        return self.bodies[name]

    def _robot(self, name: str) -> _Robot:
        if name not in self.robots:
            raise UnknownName("body or robot", name, [*self.bodies, *self.robots])
        return self.robots[name]


class _Robot:
    def __init__(self, engine: KinematicEngine, name: str, urdf: Path, root: Pose) -> None:
        self.engine, self.name = engine, name
        self.root = pin.SE3(root.matrix())
        self.model = pin.buildModelFromUrdf(str(urdf))
        self.data = self.model.createData()
        self.joint_names = tuple(self.model.names[1:])
        self.link_names = tuple(f.name for f in self.model.frames if f.type == pin.FrameType.BODY)
        self.q: Array = np.zeros(len(self.joint_names))
        self.v: Array = np.zeros(len(self.joint_names))
        self.goals: dict[int, Callable[[float], float]] = {}  # joint: position -> position after a step
        self.couplings: list[tuple[int, int, float]] = []
        self.before = self.v

    def joints(self, names: Sequence[str]) -> _Joints:
        return _Joints(self, tuple(names))

    def link(self, name: str) -> _Link:
        if name not in self.link_names:
            raise UnknownName("link", name, self.link_names)
        return _Link(self, name)

    def step(self) -> None:
        self.before, before = self.v, self.q.copy()
        for joint, goal in self.goals.items():
            self.q[joint] = goal(self.q[joint])
        for first, second, ratio in self.couplings:
            self.q[second] = before[second] + ratio * (self.q[first] - before[first])
        self.v = (self.q - before) / self.engine.period

    def configuration(self) -> Array:
        """Pinocchio's, in which a joint without limits is a point on a circle."""
        parts = [(math.cos(q), math.sin(q)) if self.model.joints[n + 1].nq == 2 else (q,) for n, q in enumerate(self.q)]
        return np.array([value for part in parts for value in part])


class _Joints:
    def __init__(self, robot: _Robot, names: tuple[str, ...]) -> None:
        for name in names:
            if name not in robot.joint_names:
                raise UnknownName("joint", name, robot.joint_names)
        self._robot, self.names = robot, names
        self._numbers = [robot.joint_names.index(name) for name in names]
        model, frames = robot.model, robot.model.frames
        of_joint = {f.parentJoint: f.name for f in reversed(frames) if f.type == pin.FrameType.BODY}
        self.links = tuple(of_joint[number + 1] for number in self._numbers)
        q = [model.joints[number + 1].idx_q for number in self._numbers]
        v = [model.joints[number + 1].idx_v for number in self._numbers]
        self.limits = JointLimits(
            model.lowerPositionLimit[q], model.upperPositionLimit[q], model.effortLimit[v], model.velocityLimit[v]
        )

    def read(self) -> JointReadings:
        q, v = self._robot.q[self._numbers], self._robot.v[self._numbers]
        return JointReadings(tuple(q.tolist()), tuple(v.tolist()), (0.0,) * len(q))

    def reset(self, positions: Sequence[float]) -> None:
        for number, position in zip(self._numbers, positions, strict=True):
            self._robot.q[number], self._robot.v[number] = position, 0.0

    def hold_positions(
        self,
        positions: Sequence[float] | Array,
        *,
        gain: float,
        effort: Sequence[float] | Array,
        velocities: Sequence[float] | Array | None = None,
        max_velocity: float | None = None,
    ) -> None:
        period = self._robot.engine.period
        most = math.inf if max_velocity is None else max_velocity * period
        moves = [0.0] * len(self.names) if velocities is None else velocities
        for number, position, velocity in zip(self._numbers, positions, moves, strict=True):
            goal = float(position) + float(velocity) * period
            self._robot.goals[number] = lambda q, goal=goal: q + min(max(goal - q, -most), most)  # type: ignore[misc]

    def drive_velocities(self, velocities: Sequence[float], *, effort: float) -> None:
        for number, velocity in zip(self._numbers, velocities, strict=True):
            step = velocity * self._robot.engine.period
            self._robot.goals[number] = lambda q, step=step: q + step  # type: ignore[misc]

    def apply_efforts(self, efforts: Sequence[float]) -> None:
        raise DeviceError("the kinematic engine knows no forces")

    def reactions(self) -> tuple[Wrench, ...]:
        """The weight of what the joint carries."""
        robot = self._robot
        return tuple(
            Wrench(force=(0.0, 0.0, 9.81 * self._mass_beyond(robot.model, number + 1))) for number in self._numbers
        )

    @staticmethod
    def _mass_beyond(model: Any, joint: int) -> float:
        return sum(model.inertias[n].mass for n in range(1, model.njoints) if joint in list(model.supports[n]))

    def couple(self, *, ratio: float, effort: float) -> None:
        if len(self._numbers) != 2:
            raise UsageError("two joints can be coupled")
        self._robot.couplings.append((self._numbers[0], self._numbers[1], ratio))

    def set_surface(self, surface: Surface) -> None:
        """Nothing slides."""


class _Link:
    def __init__(self, robot: _Robot, name: str) -> None:
        self._robot = robot
        self._frame = robot.model.getFrameId(name)

    def pose(self) -> Pose:
        robot = self._robot
        pin.framesForwardKinematics(robot.model, robot.data, robot.configuration())
        return Pose.from_matrix((robot.root * robot.data.oMf[self._frame]).homogeneous)

    def twist(self) -> Twist:
        return self._turned(self._robot.v)

    def acceleration(self) -> Twist:
        robot, aligned = self._robot, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        change = (robot.v - robot.before) / robot.engine.period
        pin.forwardKinematics(robot.model, robot.data, robot.configuration(), robot.v, change)
        motion = pin.getFrameClassicalAcceleration(robot.model, robot.data, self._frame, aligned)
        return self._in_map(motion)

    def _turned(self, v: Array) -> Twist:
        robot, aligned = self._robot, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        pin.forwardKinematics(robot.model, robot.data, robot.configuration(), v)
        return self._in_map(pin.getFrameVelocity(robot.model, robot.data, self._frame, aligned))

    def _in_map(self, motion: Any) -> Twist:
        turn = self._robot.root.rotation
        return Twist(tuple((turn @ motion.linear).tolist()), tuple((turn @ motion.angular).tolist()))


def _meet_box(into: Pose, half: Array, starts: Array, ends: Array) -> tuple[Array, Array]:
    """Returns the share of each ray before a box around the origin of a frame, and the normal there in that frame."""
    begin, way = into.apply(starts), into.apply(ends) - into.apply(starts)
    with np.errstate(divide="ignore", invalid="ignore"):
        one, other = (-half - begin) / way, (half - begin) / way
    enter = np.nan_to_num(np.fmin(one, other), nan=-np.inf)
    leave = np.fmax(one, other)
    first, last = enter.max(axis=1), leave.min(axis=1)
    axis = enter.argmax(axis=1)
    normal = np.zeros_like(begin)
    rows = np.arange(len(begin))
    normal[rows, axis] = -np.sign(way[rows, axis])
    return np.where((first <= last) & (first >= 0.0), first, np.inf), normal

"""Shelves for arm motions: generated problems, and a judge of their solutions that shares no code with the planner.

A shelf has two rows of three cells, in some of which a part stands. The tip is in one cell and shall get into another.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

import coal
import numpy as np
import pinocchio as pin
from chance import Chance

from skiros_py.devices.arm import ArmSpec
from skiros_py.devices.gripper import GripperSpec
from skiros_py.geometry import Array, Pose, Primitive, Solid
from skiros_py.motion.pinocchio.arm_model import ArmModel, arm_model
from skiros_py.motion.pinocchio.collision import Checker, CollisionScene, self_collision_pairs
from skiros_py.motion.pinocchio.kinematics import IkSolver
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.kinematics import write_robot_urdf
from skiros_py.ports.motion import Held, JointMove, MotionRequest, Obstacle, PoseMove

GAP = 0.04
"""Gap between the fingers [m]."""
MARGIN = 0.005
"""Distance from everything at both ends of a problem [m]."""
_DEPTH, _THICK = 0.35, 0.02
_SHOULDER = np.array([0.22, 0.0, 1.066])
"""Shoulder of the built-in robot; the shelf stands before that of any other robot in the same way [m]."""
_TRIES = 4, 12
"""Poses drawn in each cell, and postures searched for each."""


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """One problem.

    Attributes:
        seed: Seed that it was drawn from.
        kind: "joint" or "pose": what is given of the goal.
        obstacles: The shelf and what stands in it.
        start: Joint angles at the start [rad].
        goal: Joint angles in which the goal is known to be reachable [rad].
        target: Pose of the tip at the goal, shape (4, 4).
    """

    seed: int
    kind: str
    obstacles: tuple[Obstacle, ...]
    start: Array
    goal: Array
    target: Array

    def request(self, arm: str, seed: int = 0) -> MotionRequest:
        """Returns it as a request to the planner of an arm."""
        goal = JointMove(tuple(self.goal.tolist())) if self.kind == "joint" else PoseMove(Pose.from_matrix(self.target))
        return MotionRequest(arm, tuple(self.start.tolist()), Pose(), ((goal,),), self.obstacles, gap=GAP, seed=seed)


def problems(robot: RobotSpec, seeds: range) -> Iterator[Problem]:
    """Draws a problem from each seed, joint to joint and pose to pose in turn; none where no two cells are clear.

    Args:
        robot: The robot, its arm at the origin of the map.
        seeds: The seeds.
    """
    arm = arm_model(robot, robot.of(ArmSpec)[0])
    solver, pairs = IkSolver(arm), self_collision_pairs(arm)
    for seed in seeds:
        chance = Chance(seed)
        obstacles, cells = _shelf(chance, np.round(arm.shoulder - _SHOULDER, 3))
        checker = CollisionScene(arm, pairs, Pose(), obstacles, None, GAP).checker(MARGIN)
        ends: list[tuple[Array, Array]] = []
        for number in chance.order(len(cells)):
            end = _end(chance, cells[number], arm, solver, checker)
            ends += [end] if end is not None else []
            if len(ends) == 2:
                (start, _), (goal, target) = ends
                yield Problem(seed, ("joint", "pose")[seed // 2 % 2], tuple(obstacles), start, goal, target)
                break


def _end(chance: Chance, cell: Array, arm: ArmModel, solver: IkSolver, checker: Checker) -> tuple[Array, Array] | None:
    for _ in range(_TRIES[0]):
        target = _tool(chance, cell)
        for _ in range(_TRIES[1]):
            posture = solver.solve(target, chance.posture(arm.lower, arm.upper))
            if posture is not None and checker.clear(posture):
                return posture, target
    return None


def _shelf(chance: Chance, shift: Array) -> tuple[list[Obstacle], list[Array]]:
    """Returns the shelf, and the middle of the lower front edge of each cell with its width and height [m]."""
    front, bottom = 0.22 + chance.within(0.42, 0.5) + shift[0], chance.within(0.35, 0.5) + shift[2]
    height, width = chance.within(0.33, 0.4), chance.within(0.34, 0.42)
    found = [
        _box(f"board_{n}", (_DEPTH, 3 * width + _THICK, _THICK), (front + _DEPTH / 2, 0.0, bottom + n * height))
        for n in range(3)
    ]
    middle = bottom + height
    found += [
        _box(f"side_{n}", (_DEPTH, _THICK, 2 * height + _THICK), (front + _DEPTH / 2, (n - 1.5) * width, middle))
        for n in range(4)
    ]
    found.append(_box("back", (_THICK, 3 * width + _THICK, 2 * height + _THICK), (front + _DEPTH, 0.0, middle)))
    cells = []
    for column in range(3):
        for row in range(2):
            y, z = (column - 1) * width, bottom + row * height
            cells.append(np.array([front, y, z, width, height]))
            if chance.sign() > 0.0:
                place = front + _DEPTH - 0.08, y + chance.sign() * chance.within(0.0, 0.1), z + _THICK / 2 + 0.06
                found.append(_box(f"part_{column}_{row}", (0.06, 0.06, 0.12), place))
    return found, cells


def _box(name: str, size: tuple[float, float, float], middle: tuple[float, float, float]) -> Obstacle:
    x, y, z = middle
    return Obstacle(name, Solid.box(*size), Pose((x, y, z - size[2] / 2)))


def _tool(chance: Chance, cell: Array) -> Array:
    """Returns a pose of the tip in a cell, shape (4, 4): it points into the shelf, pitched and rolled a little."""
    front, y, z, _, height = cell
    rise = chance.within(0.10, height - 0.12)
    place = np.array([front + chance.within(0.04, 0.16), y + chance.sign() * chance.within(0.0, 0.06), z + rise])
    pitch, roll = chance.sign() * chance.within(0.0, 0.3), chance.turn()
    pose = Pose.of(*place, pitch=math.pi / 2 + pitch) @ Pose.of(0.0, 0.0, 0.0, yaw=roll)
    return pose.matrix()


class Judge:
    """Judges paths with Coal on the meshes of the robot's description.

    Args:
        robot: The robot.
        margin: What is nearer counts as touched [m].

    Attributes:
        arm: Id of its arm.
    """

    def __init__(self, robot: RobotSpec, margin: float = 0.001) -> None:
        self._arm = robot.of(ArmSpec)[0]
        self.arm = self._arm.id
        with TemporaryDirectory() as directory:
            urdf = write_robot_urdf(robot.model, Path(directory))
            self._model = pin.buildModelFromUrdf(str(urdf))
            kind = pin.GeometryType.COLLISION
            self._shapes = pin.buildGeomFromUrdf(self._model, str(urdf), kind, package_dirs=[str(urdf.parent)])
        self._data, self._placed = self._model.createData(), self._shapes.createData()
        self._request = coal.CollisionRequest()
        self._request.security_margin = margin
        self._zero, self._tip = pin.neutral(self._model), self._model.getFrameId(self._arm.tip)
        joints = [joint for gripper in robot.of(GripperSpec) for joint in gripper.joints]
        self._fingers = [self._model.joints[self._model.getJointId(joint)].idx_q for joint in joints]
        self._zero[self._fingers] = GAP / 2.0
        first = self._model.getJointId(self._arm.joints[0])
        objects = self._shapes.geometryObjects
        for shape in objects:
            shape.geometry.computeLocalAABB()
        self._joints = [int(shape.parentJoint) for shape in objects]
        self._balls = [(np.array(shape.geometry.aabb_center), float(shape.geometry.aabb_radius)) for shape in objects]
        self._moved = [i for i, joint in enumerate(self._joints) if first in self._model.supports[joint].tolist()]
        self._pairs = [(i, j) for i in self._moved for j in range(len(objects)) if self._apart(i, j)]
        self._place(np.array(self._arm.home))
        self._pairs = [pair for pair in self._pairs if not self._near(*pair)]

    def first_contact(
        self, path: Sequence[Array] | Array, obstacles: Sequence[Obstacle], held: Held | None = None, gap: float = GAP
    ) -> str:
        """Returns what is touched first by the postures of a path; empty if nothing is.

        Args:
            path: Joint angles [rad].
            obstacles: What must not be touched, in the frame of the robot.
            held: What the gripper holds, or None.
            gap: Between the fingers [m].
        """
        self._zero[self._fingers] = gap / 2.0
        blocks = [(one.id, *_shape(block, one.pose)) for one in obstacles for block in one.solid.primitives]
        in_hand = [] if held is None else [_shape(block, held.pose) for block in held.solid.primitives]
        for posture in path:
            self._place(np.asarray(posture))
            tip = self._data.oMf[self._tip].homogeneous
            for (shape, at, size), (name, box, matrix, radius) in product(in_hand, blocks):
                far = np.linalg.norm((tip @ at)[:3, 3] - matrix[:3, 3]) - float(self._request.security_margin)
                if far < radius + size and self._touch(shape, tip @ at, box, matrix):
                    return f"what is held touches {name}"
            for i in self._moved:
                for name, box, matrix, radius in blocks:
                    if self._ball_distance(i, matrix[:3, 3]) < radius and self._collide(i, box, matrix):
                        return f"{self._shapes.geometryObjects[i].name} touches {name}"
            for i, j in self._pairs:
                if self._near(i, j):
                    return f"{self._shapes.geometryObjects[i].name} touches {self._shapes.geometryObjects[j].name}"
        return ""

    def _place(self, posture: Array) -> None:
        whole = self._zero.copy()
        for name, angle in zip(self._arm.joints, posture, strict=True):
            whole[self._model.joints[self._model.getJointId(name)].idx_q] = angle
        pin.updateGeometryPlacements(self._model, self._data, self._shapes, self._placed, whole)
        pin.updateFramePlacement(self._model, self._data, self._tip)

    def _apart(self, i: int, j: int) -> bool:
        """Returns whether two shapes are neither of one body nor neighbours; each pair once."""
        a, b = self._joints[i], self._joints[j]
        parents = self._model.parents
        return a != b and parents[a] != b and parents[b] != a and (j not in self._moved or i < j)

    def _ball_distance(self, i: int, place: Array) -> float:
        centre, radius = self._balls[i]
        away = float(np.linalg.norm(self._placed.oMg[i].act(centre) - place))
        return away - radius - float(self._request.security_margin)

    def _near(self, i: int, j: int) -> bool:
        centre, radius = self._balls[j]
        if self._ball_distance(i, self._placed.oMg[j].act(centre)) >= radius:
            return False
        return self._collide(i, self._shapes.geometryObjects[j].geometry, self._placed.oMg[j].homogeneous)

    def _collide(self, i: int, other: object, matrix: Array) -> bool:
        return self._touch(self._shapes.geometryObjects[i].geometry, self._placed.oMg[i].homogeneous, other, matrix)

    def _touch(self, shape: object, at: Array, other: object, matrix: Array) -> bool:
        first, second = (coal.Transform3s(one[:3, :3], one[:3, 3]) for one in (at, matrix))
        return bool(coal.collide(shape, first, other, second, self._request, coal.CollisionResult()))


def _shape(block: Primitive, frame: Pose) -> tuple[object, Array, float]:
    """Returns a block as Coal has it, where it is, and the radius of a ball around it [m]."""
    if block.kind == "box":
        return coal.Box(*block.size), (frame @ block.pose).matrix(), math.hypot(*block.size) / 2.0
    radius, length = block.size
    return coal.Cylinder(radius, length), (frame @ block.pose).matrix(), math.hypot(radius, length / 2.0)

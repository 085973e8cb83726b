"""Checks of postures: collisions of robot, obstacles and held body as convex shapes, with Coal; constraints."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from skiros_py.geometry import Array, Pose, Primitive, Solid
from skiros_py.motion.pinocchio.arm_model import ArmModel, se3
from skiros_py.motion.voxels import Voxels, boxes
from skiros_py.ports.motion import Cause, Cone, Constraint, Held, KeepOut, Obstacle

_HELD = "what it holds"
SEEN = "something unknown that a camera has seen"
_SAMPLES = 200
_ALWAYS = 0.9  # share of random postures; shapes that overlap that often are neighbours
_MANY = 150
"""Number of shapes from which a tree finds near ones faster than comparing all boxes around them."""
_PROJECTIONS = 20
"""Steps in which a posture is brought to where the constraints hold."""
_INSIDE = 0.7
"""Share of the angle of a cone within which such a posture is brought."""
_PALM = 0.05  # [m] from the tip to the palm: what is higher than that above the end of a line stands beside it
_LEAVING = 0.4  # [rad] within so much of its start a motion leaves what it is too near to
_OWN = 0.005  # [m] greatest margin between parts of the robot itself, whose places are known exactly


@dataclass(frozen=True, slots=True)
class Fault:
    """Why a posture, or a way through it, is not possible."""

    cause: Cause
    reason: str
    touches: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True, slots=True)
class Contact:
    """Two things that are too close: a robot link (or the held body), and an obstacle's id or another link."""

    link: str
    other: str
    obstacle: bool
    kept_out: bool = False

    @property
    def fault(self) -> Fault:
        """It as a reason."""
        if self.kept_out:
            return Fault("constraint", f"{self.link} would enter {self.other}")
        own = "" if self.obstacle else " of the robot itself"
        return Fault("collision", f"{self.link} would touch {self.other}{own}")


@dataclass(frozen=True, slots=True)
class _Pair:
    contact: Contact
    may_touch: bool  # the gripper or the held body against an obstacle: what a move may declare as touching
    top: float = 0.0  # height of the obstacle [m]


def self_collision_pairs(arm: ArmModel) -> frozenset[tuple[str, str]]:
    """Returns the pairs of shapes of the robot that can collide, by name.

    Left out are shapes of one rigid body, neighbours across one joint, and those whose hulls overlap in nearly every
    posture or in the arm's home posture.
    """
    shapes = arm.collision_shapes(0.0)
    add_distant_pairs(arm.model, shapes)
    data, results = arm.model.createData(), shapes.createData()
    hits = np.zeros(len(shapes.collisionPairs))
    rng = np.random.default_rng(0)
    for _ in range(_SAMPLES):
        hits += _hits(arm, data, shapes, results, rng.uniform(arm.lower, arm.upper))
    at_home = _hits(arm, data, shapes, results, np.array(arm.spec.home))
    kept = (hits < _ALWAYS * _SAMPLES) & ~at_home
    names = [shape.name for shape in shapes.geometryObjects]
    pairs = [(names[pair.first], names[pair.second]) for pair in shapes.collisionPairs]
    return frozenset(pair for pair, keep in zip(pairs, kept, strict=True) if keep)


def add_distant_pairs(model: pin.Model, shapes: pin.GeometryModel) -> None:
    """Adds all pairs of shapes that at least one other link is between."""
    parents = [shape.parentJoint for shape in shapes.geometryObjects]
    for i, first in enumerate(parents):
        for j, second in enumerate(parents[i + 1 :], start=i + 1):
            if first != second and model.parents[max(first, second)] != min(first, second):
                shapes.addCollisionPair(pin.CollisionPair(i, j))


def _hits(
    arm: ArmModel, data: pin.Data, shapes: pin.GeometryModel, results: pin.GeometryData, q: Array
) -> NDArray[np.bool_]:
    pin.computeCollisions(arm.model, data, shapes, results, q, False)
    return np.array([result.isCollision() for result in results.collisionResults])


class CollisionScene:
    """The robot among the obstacles of one request.

    Args:
        arm: The arm that moves.
        self_pairs: Pairs of robot shapes to check, from :func:`self_collision_pairs`.
        base: Pose of the robot's base in the map.
        obstacles: Bodies in the map.
        held: What the gripper holds, or None.
        gap: Gap between the fingers [m].
        constraints: What holds everywhere.
        voxels: What was seen and is unknown, in the map; None for nothing.

    Attributes:
        near: The obstacles within reach, keep-out volumes among them, their poses in the frame of the base.
        held: What the gripper holds, or None.
        gap: Gap between the fingers [m].
        cones: The constraints on the direction of the tip, in the frame of the base.
    """

    def __init__(
        self,
        arm: ArmModel,
        self_pairs: Iterable[tuple[str, str]],
        base: Pose,
        obstacles: Iterable[Obstacle],
        held: Held | None,
        gap: float,
        constraints: Iterable[Constraint] = (),
        voxels: Voxels | None = None,
    ) -> None:
        self._arm = arm
        self.held, self.gap = held, gap
        self._shapes = arm.collision_shapes(gap)
        self._pairs: list[_Pair] = []
        # Plain values: references into the list of shapes do not survive that shapes are added to it.
        self._robot = [
            (i, int(shape.parentJoint), str(arm.model.frames[shape.parentFrame].name))
            for i, shape in enumerate(self._shapes.geometryObjects)
        ]
        self._held = self._add_held(held) if held else []
        for first, second in sorted(self_pairs):
            self._pair(self._shapes.getGeometryId(first), self._shapes.getGeometryId(second), None)
        for shape_id in self._held:
            for i, joint, _ in self._robot:
                if joint != self._arm.model.njoints - 1:
                    self._pair(shape_id, i, None)
        to_base, demands = base.inverse(), tuple(constraints)
        turn = to_base.matrix()[:3, :3]
        self.cones = [
            (np.array(one.axis), turn @ np.array(one.direction), one.angle) for one in demands if isinstance(one, Cone)
        ]
        volumes = [Obstacle(one.id, one.solid, one.pose) for one in demands if isinstance(one, KeepOut)]
        self.near: list[Obstacle] = []
        for number, obstacle in enumerate((*volumes, *obstacles)):
            self._add_obstacle(replace(obstacle, pose=to_base @ obstacle.pose), kept_out=number < len(volumes))
        self._voxels = self._add_voxels(voxels, to_base) if voxels is not None else None

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """The pairs that are checked, as the contacts they would be."""
        return tuple(pair.contact for pair in self._pairs)

    @property
    def seen(self) -> tuple[Obstacle, ...]:
        """The voxels within reach as one obstacle of boxes, its pose in the frame of the base; nothing for none."""
        if self._voxels is None:
            return ()
        voxels, to_base = self._voxels
        return (Obstacle(SEEN, boxes(voxels), to_base),)

    def checker(
        self,
        margin: float,
        touching: frozenset[str] = frozenset(),
        start: Array | None = None,
        lowest: float = math.inf,
    ) -> Checker:
        """Returns a checker for one kind of move.

        Args:
            margin: Smallest distance to keep [m].
            touching: Ids of obstacles that gripper and held body may touch, where they are not above the palm.
            start: Joint angles [rad] at which the move starts; pairs closer than the margin there only must not get
                closer, and are left within 0.4 rad.
            lowest: Least height of the tip in the move [m].
        """
        touchable = (pair.may_touch and pair.contact.other in touching for pair in self._pairs)
        highest = lowest + _PALM
        active = [not may or pair.top > highest for may, pair in zip(touchable, self._pairs, strict=True)]
        checker = Checker(self._arm, self._shapes, list(self.contacts), active, margin, self.cones)
        if start is not None and not checker.clear(start):
            strict = Checker(self._arm, self._shapes, list(self.contacts), active, margin, self.cones)
            checker.tolerate(start, strict)
        return checker

    def _add_held(self, held: Held) -> list[int]:
        tip = self._arm.model.frames[self._arm.tip]
        mount = tip.placement * se3(held.pose)
        return [self._add(_HELD, tip.parentJoint, mount, block) for block in held.solid.primitives]

    def _add_obstacle(self, obstacle: Obstacle, *, kept_out: bool) -> None:
        placement = se3(obstacle.pose)
        blocks = tuple(block for block in obstacle.solid.primitives if self._within_reach(placement, block))
        if blocks:
            self.near.append(replace(obstacle, solid=Solid(blocks)))
        for block in blocks:
            shape_id = self._add(obstacle.id, 0, placement, block)
            top = float(Solid((replace(block, pose=obstacle.pose @ block.pose),)).bounds()[1][2])
            for i, joint, _ in self._robot:
                if joint > 0:
                    self._pair(i, shape_id, obstacle.id, kept_out=kept_out, top=top)
            for held_id in self._held:
                self._pair(held_id, shape_id, obstacle.id, kept_out=kept_out, top=top)

    def _add_voxels(self, voxels: Voxels, to_base: Pose) -> tuple[Voxels, Pose] | None:
        away = np.linalg.norm(to_base.apply(voxels.centres) - self._arm.shoulder, axis=1)
        near = replace(voxels, centres=voxels.centres[away < self._arm.reach + 0.4])
        if not len(near.centres):
            return None
        size, shift = (near.size / 2.0, near.size / 4.0) if near.only_middles else (near.size, 0.0)
        shape = coal.makeOctree(near.centres + shift, size)  # the middle of a cube must be in the middle of a node
        placement = se3(to_base @ Pose((-shift, -shift, -shift)))
        shape_id = int(self._shapes.addGeometryObject(pin.GeometryObject(SEEN, 0, 0, placement, shape)))
        for i in (*(i for i, joint, _ in self._robot if joint > 0), *self._held):
            self._pair(i, shape_id, SEEN, top=math.inf)
        return near, to_base

    def _within_reach(self, placement: pin.SE3, block: Primitive) -> bool:
        radius = float(np.linalg.norm(block.size))
        centre = placement.act(np.array(block.pose.position))
        return float(np.linalg.norm(centre - self._arm.shoulder)) - radius < self._arm.reach + 0.4

    def _add(self, name: str, joint: int, placement: pin.SE3, block: Primitive) -> int:
        shape = coal.Box(*block.size) if block.kind == "box" else coal.Cylinder(*block.size)
        unique = f"{name}#{len(self._shapes.geometryObjects)}"
        return int(
            self._shapes.addGeometryObject(pin.GeometryObject(unique, joint, 0, placement * se3(block.pose), shape))
        )

    def _link(self, shape_id: int) -> str:
        return _HELD if shape_id in self._held else self._robot[shape_id][2]

    def _pair(self, first: int, second: int, obstacle: str | None, *, kept_out: bool = False, top: float = 0.0) -> None:
        link = self._link(first)
        other = obstacle if obstacle is not None else self._link(second)
        is_hand = link == _HELD or link in self._arm.gripper_links
        free_to_touch = obstacle is not None and is_hand and not kept_out
        self._shapes.addCollisionPair(pin.CollisionPair(first, second))
        self._pairs.append(_Pair(Contact(link, other, obstacle is not None, kept_out), free_to_touch, top))


class Checker:
    """Checks postures for one kind of move; made by :meth:`CollisionScene.checker`."""

    def __init__(
        self,
        arm: ArmModel,
        shapes: pin.GeometryModel,
        contacts: list[Contact],
        active: list[bool],
        margin: float,
        cones: Sequence[tuple[Array, Array, float]] = (),
    ) -> None:
        self._arm = arm
        self._cones = cones
        self._shapes = shapes
        self._contacts = contacts
        self._data = arm.model.createData()
        self._results = shapes.createData()
        self._start: Array | None = None
        self._strict: Checker | None = None
        for i, is_active in enumerate(active):
            self._results.collisionRequests[i].security_margin = margin if contacts[i].obstacle else min(margin, _OWN)
            if not is_active:
                self._results.deactivateCollisionPair(i)
        manager = pin.BroadPhaseManager_NaiveCollisionManager
        if len(shapes.geometryObjects) > _MANY:
            manager = pin.BroadPhaseManager_DynamicAABBTreeCollisionManager
        self._manager = manager(arm.model, shapes, self._results)

    def clear(self, q: Array) -> bool:
        """Returns True when nothing is nearer than the margin at joint angles [rad], and the constraints hold."""
        if (strict := self._beyond(q)) is not None:
            return strict.clear(q)
        hits = pin.computeCollisions(self._arm.model, self._data, self._manager, q, True)
        return not hits and (not self._cones or self._tilted(q) is None)

    def fault(self, q: Array) -> Fault | None:
        """Returns what is too close at joint angles [rad], or the constraint that does not hold; None for neither."""
        if (strict := self._beyond(q)) is not None:
            return strict.fault(q)
        touching = [self._contacts[i] for i in self._touching(q)]
        if touching:
            touches = tuple((one.link, one.other) for one in touching if one.obstacle and not one.kept_out)
            return replace(touching[0].fault, touches=touches)
        if (tilted := self._tilted(q)) is None:
            return None
        (_, _, most), angle = tilted
        return Fault("constraint", f"the tip would tilt by {math.degrees(angle):.0f} deg, of {math.degrees(most):.0f}")

    def project(self, q: Array) -> Array | None:
        """Moves joint angles [rad] to where the constraints on the tip's direction hold; None where that fails."""
        for _ in range(_PROJECTIONS):
            tilted = self._tilted(q)
            if tilted is None:
                return q
            (axis, direction, most), angle = tilted
            pose, jacobian = self._arm.tip_jacobian(q)
            turn = np.cross(axis, pose.rotation.T @ direction)
            turn *= (angle - _INSIDE * most) / max(float(np.linalg.norm(turn)), 1e-9)
            q = np.clip(q + np.linalg.pinv(jacobian[3:]) @ turn, self._arm.lower, self._arm.upper)
        return None

    def _tilted(self, q: Array) -> tuple[tuple[Array, Array, float], float] | None:
        """Returns a cone that the tip leaves and the angle [rad]; None where it leaves none."""
        for cone in self._cones:
            axis, direction, most = cone
            cosine = float(direction @ (self._arm.tip_pose(q).rotation @ axis))
            angle = math.acos(min(1.0, max(-1.0, cosine)))
            if angle > most:
                return cone, angle
        return None

    def tolerate(self, q: Array, strict: Checker) -> None:
        """Permits pairs that are too close at joint angles [rad] to stay as close as they are there while it leaves.

        Args:
            q: The joint angles.
            strict: Checks postures further away.
        """
        for i in self._touching(q):
            distance = pin.computeDistance(self._shapes, self._results, i).min_distance
            request = self._results.collisionRequests[i]
            if self._contacts[i].other == SEEN and distance <= 0.001:  # Coal measures no depth in octrees
                self._results.deactivateCollisionPair(i)
            else:
                request.security_margin = min(request.security_margin, distance - 0.001)
        self._start, self._strict = q, strict

    def _beyond(self, q: Array) -> Checker | None:
        """Returns what checks joint angles at which the start must have been left."""
        return self._strict if self._start is not None and np.abs(q - self._start).max() > _LEAVING else None

    def _touching(self, q: Array) -> list[int]:
        if not pin.computeCollisions(self._arm.model, self._data, self._manager, q, True):
            return []
        pin.computeCollisions(self._arm.model, self._data, self._shapes, self._results, q, False)
        results, active = self._results.collisionResults, self._results.activeCollisionPairs
        return [i for i in range(len(self._contacts)) if active[i] and results[i].isCollision()]

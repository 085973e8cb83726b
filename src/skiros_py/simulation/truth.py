"""What is really so in the simulation: for reports, benchmarks and tests only, never for a decision of a robot."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from skiros_py.geometry import Pose
from skiros_py.robot.cell import BodySpec
from skiros_py.simulation.pybullet.bodies import Body
from skiros_py.simulation.pybullet.cell import PyBulletCell
from skiros_py.simulation.pybullet.gripper import Gripper

__all__ = ["FLOOR", "Contact", "Truth"]

FLOOR = "floor"
"""The place of what lies on nothing in particular."""

_WALL_TOLERANCE = 0.002  # how much nearer than its wall a part's origin must be to be inside a compartment [m]
_LOW = 0.015  # greatest height of a part's origin above the floor of its compartment [m]
_UPRIGHT = math.cos(math.radians(15.0))
_SUNK = 0.01  # how far below a surface an origin may be that lies on it, a fallen part's for instance [m]


_CARRIERS = frozenset({"base_link"})
"""Links that may touch what is bolted to the robot: it stands on them."""


@dataclass(frozen=True, slots=True)
class Contact:
    """A robot touches a body or another robot.

    Attributes:
        link: Name of the robot's link.
        body: Id of the body or of the other robot, or "floor".
        depth: How deep the two are in each other [m]; 0 when they only touch.
    """

    link: str
    body: str
    depth: float


class Truth:
    """Looks behind the sensors of a simulated cell.

    Args:
        cell: The cell.

    Attributes:
        worst: The deepest contact seen by :meth:`watch` for each pair of robot link and body.
    """

    def __init__(self, cell: PyBulletCell) -> None:
        self._scene = cell.scene
        self.worst: dict[tuple[str, str], Contact] = {}

    def pose(self, body_id: str) -> Pose:
        """Returns where a body or compartment is in the map.

        Raises:
            UnknownName: There is no such body.
        """
        return self._scene.pose(body_id)

    def poses(self) -> Mapping[str, Pose]:
        """Returns where every body and compartment is in the map."""
        return {body_id: self.pose(body_id) for body_id in (*self._scene.bodies, *self._scene.compartments)}

    def base_pose(self, base_id: str) -> Pose:
        """Returns where a base is in the map, without its localiser's error."""
        return next(robot.base.true_pose() for robot in self._scene.robots if robot.base.spec.id == base_id)

    def placements(self) -> Mapping[str, str]:
        """Returns the place of every movable body, by body id.

        A body is *held by a gripper* when it touches both its fingers and nothing else than that robot. It is *in a
        compartment* when its origin is inside the compartment's inner rectangle by at least 2 mm, at most 15 mm above
        its floor, and the body stands within 15 degrees of upright. Otherwise it is *on* the highest body with a
        support surface, or kit, that is below its origin, or else on the floor.
        """
        movable = [body for body in self._scene.bodies.values() if body.spec.mass > 0.0 and body.constraint is None]
        return {body.spec.id: self._placement(body) for body in movable}

    def contacts(self) -> tuple[Contact, ...]:
        """Returns what the robots touch now, except the floor under their base and what stands on it."""
        bodies = {body.index: body for body in self._scene.bodies.values()}
        names = {robot.body: robot.spec.id for robot in self._scene.robots} | {self._scene.floor: FLOOR}
        names |= {body.index: body.spec.id for body in bodies.values()}
        found: dict[tuple[str, str], Contact] = {}
        for robot in self._scene.robots:
            for point in self._scene.client.getContactPoints(robot.body):
                body = bodies.get(point[2])
                bolted = body is not None and body.constraint is not None
                if point[2] == robot.body or (bolted and robot.joints.link_name(point[3]) in _CARRIERS):
                    continue
                link = robot.joints.link_name(point[3])
                _keep_deeper(found, Contact(link, names[point[2]], max(0.0, -point[8])))
        return tuple(found.values())

    def watch(self) -> None:
        """Notes what the robots touch now in :attr:`worst`; to be called as often as contacts matter (0.1 ms)."""
        for contact in self.contacts():
            _keep_deeper(self.worst, contact)

    def _placement(self, body: Body) -> str:
        holder = self._holder(body)
        if holder is not None:
            return holder.spec.id
        pose = self.pose(body.spec.id)
        for compartment, _ in self._scene.compartments.values():
            if _stands_in(compartment, self.pose(compartment.id), pose):
                return compartment.id
        return self._support_below(body, pose)

    def _holder(self, body: Body) -> Gripper | None:
        points = self._scene.client.getContactPoints(body.index)
        touched = {(point[2], point[4]) for point in points}
        for robot in self._scene.robots:
            if any(other != robot.body for other, _ in touched):
                continue
            for gripper in robot.grippers:
                if all((robot.body, finger) in touched for finger in gripper.fingers):
                    return gripper
        return None

    def _support_below(self, body: Body, pose: Pose) -> str:
        best, best_height = FLOOR, -_SUNK
        kits = {compartment.place for compartment, _ in self._scene.compartments.values()}
        for place in self._scene.bodies.values():
            if place is body or (place.spec.support is None and place.spec.id not in kits):
                continue
            there = self.pose(place.spec.id)
            height = there.position[2] + place.spec.support_height
            at = there.inverse() @ pose
            inside = _above(place.spec, at)
            if inside and height >= best_height and at.position[2] >= place.spec.support_height - _SUNK:
                best, best_height = place.spec.id, height
        return best


def _keep_deeper(found: dict[tuple[str, str], Contact], contact: Contact) -> None:
    known = found.get((contact.link, contact.body))
    if known is None or contact.depth > known.depth:
        found[contact.link, contact.body] = contact


def _stands_in(compartment: BodySpec, there: Pose, pose: Pose) -> bool:
    low, high = compartment.solid.bounds()
    at = (there.inverse() @ pose).matrix()
    x, y, z = at[:3, 3]
    inside = np.all((low[:2] + _WALL_TOLERANCE <= (x, y)) & ((x, y) <= high[:2] - _WALL_TOLERANCE))
    return bool(inside and -_SUNK <= z - low[2] <= _LOW and at[2, 2] >= _UPRIGHT)


def _above(place: BodySpec, at: Pose) -> bool:
    """Tells whether a pose in a place's frame is over its outline."""
    x, y, _ = at.position
    low, high = place.solid.bounds()
    return bool(low[0] <= x <= high[0] and low[1] <= y <= high[1])

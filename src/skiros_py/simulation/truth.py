"""What is really so in the simulation: for reports, benchmarks and tests only, never for a decision of a robot."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skiros_py.errors import UnknownName
from skiros_py.geometry import Pose
from skiros_py.ports.cell import BodySpec
from skiros_py.ports.kinematics import BASE_LINK
from skiros_py.ports.simulation import FLOOR, SimulatedHolder
from skiros_py.simulation.cell import SimulatedCell

_WALL_TOLERANCE = 0.002  # how much nearer than its wall a part's origin must be to be inside a compartment [m]
_LOW = 0.015  # greatest height of a part's origin above the floor of its compartment [m]
_UPRIGHT = math.cos(math.radians(15.0))
_ON_TOP = 0.5  # least vertical part of the contact normal of a body that lies on a device
_SUNK = 0.01  # how far below a surface an origin may be that lies on it, a fallen part's for instance [m]


_CARRIERS = frozenset({BASE_LINK})
"""Links that may touch what is bolted to the robot: it stands on them."""


@dataclass(frozen=True, slots=True)
class RobotContact:
    """A robot touches a body or another robot.

    Attributes:
        link: Name of the robot's link.
        body: Id of the body or of the other robot, or "floor".
        depth: How deep the two are in each other [m]; 0 when they only touch.
        force: Normal force between the two, over all points [N].
    """

    link: str
    body: str
    depth: float
    force: float = 0.0


@dataclass(frozen=True)
class Glance:
    """What only the simulation itself knows at one moment; all else is worked out from it, in any thread.

    Attributes:
        bodies: The bodies.
        body_poses: Their poses in the map, by body id.
        compartments: The compartments, and where they are in the bodies that they belong to.
        holders: Which gripper holds what, by body id.
        resting: On which device without a robot a body lies, by body id.
    """

    bodies: tuple[BodySpec, ...]
    body_poses: Mapping[str, Pose]
    compartments: tuple[tuple[BodySpec, Pose], ...]
    holders: Mapping[str, str]
    resting: Mapping[str, str]

    @cached_property
    def poses(self) -> Mapping[str, Pose]:
        """Where every body and compartment is in the map."""
        poses = dict(self.body_poses)
        for spec, relative in self.compartments:
            if spec.place in poses:
                poses[spec.id] = poses[spec.place] @ relative
        return poses

    def placements(self) -> Mapping[str, str]:
        """Returns the place of every movable body, by body id; see :meth:`Truth.placements`."""
        return {body.id: self.holders.get(body.id) or self._place(body) for body in self.bodies if _is_movable(body)}

    def _place(self, body: BodySpec) -> str:
        pose = self.poses[body.id]
        for compartment, _ in self.compartments:
            if compartment.id in self.poses and _stands_in(compartment, self._into[compartment.id] @ pose):
                return compartment.id
        return self.resting.get(body.id) or self._support_below(body, pose)

    def _support_below(self, body: BodySpec, pose: Pose) -> str:
        best, best_height = FLOOR, -_SUNK
        for place in self._supports:
            if place is body:
                continue
            height = self.poses[place.id].position[2] + place.support_height
            at = self._into[place.id] @ pose
            inside = _above(place, at)
            if inside and height >= best_height and at.position[2] >= place.support_height - _SUNK:
                best, best_height = place.id, height
        return best

    @cached_property
    def _supports(self) -> tuple[BodySpec, ...]:
        kits = {compartment.place for compartment, _ in self.compartments}
        return tuple(body for body in self.bodies if body.support is not None or body.id in kits)

    @cached_property
    def _into(self) -> Mapping[str, Pose]:
        """The map as it is seen from each place."""
        places = {place.id for place in self._supports} | {spec.id for spec, _ in self.compartments}
        return {name: pose.inverse() for name, pose in self.poses.items() if name in places}


class Truth:
    """Looks behind the sensors of a simulated cell.

    Args:
        cell: The cell.

    Attributes:
        worst: The deepest contact seen by :meth:`watch` for each pair of robot link and body.
    """

    def __init__(self, cell: SimulatedCell) -> None:
        self._scene = cell.scene
        self.worst: dict[tuple[str, str], RobotContact] = {}

    def pose(self, body_id: str) -> Pose:
        """Returns where a body or compartment is in the map.

        Raises:
            UnknownName: There is no such body.
        """
        return self._scene.pose(body_id)

    def poses(self) -> Mapping[str, Pose]:
        """Returns where every body and compartment is in the map."""
        return self.glance().poses

    def base_pose(self, base_id: str) -> Pose:
        """Returns the real pose of a base of any kind in the map.

        Raises:
            UnknownName: There is no such base.
        """
        robots = ((robot.spec.carrier, robot.model) for robot in self._scene.robots)
        bases = {carrier.id: model.link(carrier.platform_link) for carrier, model in robots if carrier is not None}
        if base_id not in bases:
            raise UnknownName("base", base_id, bases)
        return bases[base_id].pose()

    def placements(self) -> Mapping[str, str]:
        """Returns the place of every movable body, by body id.

        A body is *held by a gripper* when it touches both its fingers and nothing else than that robot. It is *in a
        compartment* when its origin is inside the compartment's inner rectangle by at least 2 mm, at most 15 mm above
        its floor, and the body stands within 15 degrees of upright. Otherwise it is *on* the device without a robot
        that it touches from above, or on the highest body with a support surface, or kit, that is below its origin, or
        else on the floor.
        """
        return self.glance().placements()

    def glance(self) -> Glance:
        """Takes what the simulation has to be asked for; quick, so that a cycle does not wait for the rest."""
        scene = self._scene
        return Glance(
            tuple(scene.bodies.values()),
            scene.engine.poses(),
            tuple(scene.compartments.values()),
            self._holders(),
            self._resting(),
        )

    def contacts(self) -> tuple[RobotContact, ...]:
        """Returns what the robots touch now, except the floor under their base and what stands on it."""
        scene = self._scene
        found: dict[tuple[str, str], RobotContact] = {}
        for robot in scene.robots:
            for point in scene.engine.contacts(robot.spec.id):
                body = scene.bodies.get(point.other)
                bolted = body is not None and body.carrier is not None
                if point.other == robot.spec.id or (bolted and point.link in _CARRIERS):
                    continue
                key = point.link, point.other
                before = found.get(key, RobotContact(*key, 0.0))
                found[key] = RobotContact(*key, max(before.depth, point.depth), before.force + point.force)
        return tuple(found.values())

    def watch(self) -> None:
        """Notes what the robots touch now in :attr:`worst`; to be called as often as contacts matter (0.1 ms)."""
        for contact in self.contacts():
            _keep_deeper(self.worst, contact)

    def _holders(self) -> dict[str, str]:
        """Returns the gripper that holds each held body: one that touches both fingers, and nothing but that robot."""
        scene, holders = self._scene, {}
        for robot in scene.robots:
            name = robot.spec.id
            holding = {id_: one for id_, one in robot.devices.items() if isinstance(one, SimulatedHolder)}
            for id_, gripper in holding.items():
                pads = [{c.other for c in scene.engine.contacts(name, finger)} for finger in gripper.fingers]
                for held in sorted(set.intersection(*pads) & scene.bodies.keys()):
                    others = {contact.other for contact in scene.engine.contacts(held)}
                    if others == {name} and _is_movable(scene.bodies[held]):
                        holders[held] = id_
        return holders

    def _resting(self) -> dict[str, str]:
        scene, resting = self._scene, {}
        for robot in scene.robots:
            for contact in scene.engine.contacts(robot.spec.id) if robot.spec.has(robot.spec.id) else ():
                body = scene.bodies.get(contact.other)
                if body is not None and _is_movable(body) and contact.force > 0.0 and contact.normal[2] < -_ON_TOP:
                    resting[contact.other] = robot.spec.id
        return resting


def _is_movable(body: BodySpec) -> bool:
    return body.mass > 0.0 and body.carrier is None


def _keep_deeper(found: dict[tuple[str, str], RobotContact], contact: RobotContact) -> None:
    known = found.get((contact.link, contact.body))
    if known is None or contact.depth > known.depth:
        found[contact.link, contact.body] = contact


def _stands_in(compartment: BodySpec, pose: Pose) -> bool:
    """Tells whether a pose in a compartment's frame is that of something that stands in it."""
    low, high = compartment.solid.bounds()
    at = pose.matrix()
    x, y, z = at[:3, 3]
    inside = np.all((low[:2] + _WALL_TOLERANCE <= (x, y)) & ((x, y) <= high[:2] - _WALL_TOLERANCE))
    return bool(inside and -_SUNK <= z - low[2] <= _LOW and at[2, 2] >= _UPRIGHT)


def _above(place: BodySpec, at: Pose) -> bool:
    """Tells whether a pose in a place's frame is over its outline."""
    x, y, _ = at.position
    low, high = place.solid.bounds()
    return bool(low[0] <= x <= high[0] and low[1] <= y <= high[1])

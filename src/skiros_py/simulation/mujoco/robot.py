"""Robots in MuJoCo: joints and links by name."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from skiros_py.errors import UnknownName, UsageError
from skiros_py.geometry import Array, Pose
from skiros_py.ports.simulation import JointLimits, JointReadings, Surface, Twist, Wrench
from skiros_py.simulation.models import attach_robot, read_urdf, robot_spec, soft_links

if TYPE_CHECKING:
    from skiros_py.simulation.mujoco.engine import MujocoEngine

_IMPEDANCE = 0.02
"""So small that soft contacts are springs with dampers, whatever else pushes what they touch."""
_MOST_POINTS = 4
"""At so many points two shapes touch at most."""
_LIGHTEST = 0.5
"""What is lighter than the inverse of this finds them softer than they are [1/kg]: it would bounce."""
_NO_LIMIT = {"lower": -math.inf, "upper": math.inf, "effort": math.inf, "velocity": math.inf}


class MujocoRobot:
    """A :class:`skiros_py.ports.simulation.SimulatedRobot`.

    Args:
        engine: The engine.
        name: Its name.
        urdf: Its model.
        pose: Pose of the root link in the map.

    Attributes:
        engine: The engine.
        name: Its name.
        urdf: Its file.
        joint_names: All movable joints, in the order of the model.
        link_names: All links, in the order of the model.
        limits: Lower and upper end, greatest effort and speed of each joint that has such limits.
        moved: The link that each joint moves.
    """

    def __init__(self, engine: MujocoEngine, name: str, urdf: Path, pose: Pose, group: int) -> None:
        self.engine = engine
        self.name = name
        self.urdf = urdf
        spec = robot_spec(urdf, visuals=False)
        self.joint_names = tuple(joint.name for joint in spec.joints)
        self.link_names = tuple(body.name for body in spec.bodies if body.name != "world")
        self.moved = {joint.name: joint.parent.name for joint in spec.joints}
        described = read_urdf(urdf)
        self.limits = _limits_of(described)
        self._links: dict[str, MujocoLink] = {}
        for joint in spec.joints:
            joint.damping, joint.frictionloss = (0.0, 0.0, 0.0), 0.0
            joint.actfrclimited = mujoco.mjtLimited.mjLIMITED_FALSE
        for geom in spec.geoms:  # it does not collide with itself
            geom.contype, geom.conaffinity = group, ~group & 0x7FFFFFFF
            engine.set_contact(geom, Surface())
        self._soft = {link: np.array(softness) for link, softness in soft_links(described).items()}
        for geom in (geom for link in self._soft for geom in spec.body(link).geoms):
            geom.priority = 1  # it is as soft, whatever touches it
            geom.solimp = (_IMPEDANCE, _IMPEDANCE, 0.001, 0.5, 2.0)
        attach_robot(engine.spec, spec, name, pose)

    def joints(self, names: Sequence[str]) -> MujocoJoints:
        """Returns some joints, to be read and driven together.

        Raises:
            UnknownName: It has no such joint.
        """
        return MujocoJoints(self, tuple(names))

    def link(self, name: str) -> MujocoLink:
        """Returns a link.

        Raises:
            UnknownName: It has no such link.
        """
        if name not in self._links:
            self._links[name] = MujocoLink(self.engine, self.body_name(name))
        return self._links[name]

    def body_name(self, link: str) -> str:
        """Returns the name of a link in MuJoCo's model.

        Raises:
            UnknownName: It has no such link.
        """
        if link not in self.link_names:
            raise UnknownName("link", link, self.link_names)
        return f"{self.name}/{link}"

    def share_softness(self) -> None:
        """Shares the stiffness of each soft link among the points at which it was touched in the last step.

        MuJoCo has it for each point, as acceleration of what touches there. Where nothing was touched it counts with
        the most points and for what stands fast, so that no blow is harder.
        """
        model, touching = self.engine.model, self.engine.data.contact.geom
        for link, softness in self._soft.items():
            body = model.body(self.body_name(link))
            first, behind = body.geomadr[0], body.geomadr[0] + body.geomnum[0]
            mine = (touching >= first) & (touching < behind)
            others = model.geom_bodyid[touching[mine[:, ::-1]]]
            points = len(others) or _MOST_POINTS
            light = min(float(model.body_invweight0[others, 0].min()), _LIGHTEST) if len(others) else 0.0
            share = (1.0 + _IMPEDANCE * (points - 1)) / points
            model.geom_solref[first:behind] = -softness * (float(body.invweight0[0]) + light) * share

    def link_poses(self) -> Mapping[str, Pose]:
        """Returns the poses of all links in the map."""
        return {link: self.engine.body_pose(f"{self.name}/{link}") for link in self.link_names}


class MujocoJoints:
    """A :class:`skiros_py.ports.simulation.JointGroup`.

    Args:
        robot: The robot.
        names: Joint names.

    Raises:
        UnknownName: The robot has no such joint.
    """

    def __init__(self, robot: MujocoRobot, names: tuple[str, ...]) -> None:
        for name in names:
            if name not in robot.joint_names:
                raise UnknownName("joint", name, robot.joint_names)
        self.names = names
        self.links = tuple(robot.moved[name] for name in names)
        rows = [robot.limits.get(name, _NO_LIMIT) for name in names]
        self.limits = JointLimits(*(np.array([row[key] for row in rows]) for key in _NO_LIMIT))
        self._engine = robot.engine
        self._motors = robot.engine.motors
        self._in_model = [f"{robot.name}/{name}" for name in names]
        self._numbers = [self._motors.names.index(name) for name in self._in_model]
        self._bodies = [robot.body_name(link) for link in self.links]

    def read(self) -> JointReadings:
        """Reads the sensors."""
        columns = self._motors.state(self._engine.data, self._numbers)
        positions, velocities, efforts = (tuple(column.tolist()) for column in columns)
        return JointReadings(positions, velocities, efforts)

    def reset(self, positions: Sequence[float]) -> None:
        """Puts the joints to positions, at rest."""
        self._motors.reset(self._engine.data, self._numbers, positions)
        self._engine.refresh()

    def hold_positions(
        self,
        positions: Sequence[float] | Array,
        *,
        gain: float,
        effort: Sequence[float] | Array,
        velocities: Sequence[float] | Array | None = None,
        max_velocity: float | None = None,
    ) -> None:
        """Lets the motors drive to positions and hold them."""
        wanted = 0.0 if velocities is None else velocities
        self._motors.control(
            self._numbers, positions=positions, velocities=wanted, gain=gain, most=max_velocity, effort=effort
        )

    def drive_velocities(self, velocities: Sequence[float], *, effort: float) -> None:
        """Lets the motors keep velocities."""
        self._motors.control(self._numbers, velocities=velocities, effort=effort)

    def apply_efforts(self, efforts: Sequence[float]) -> None:
        """Applies efforts for one step; the motors are switched off."""
        self._motors.push(self._numbers, efforts)

    def reactions(self) -> tuple[Wrench, ...]:
        """Returns the wrench through each joint after the last step, in the frame of the link that it moves."""
        return tuple(map(self._engine.reaction, self._bodies))

    def couple(self, *, ratio: float, effort: float) -> None:  # noqa: ARG002 - MuJoCo's couplings have no limit
        """Couples two joints mechanically."""
        if len(self.names) != 2:
            raise UsageError(f"two joints can be coupled, not {len(self.names)}: {', '.join(self.names)}")
        self._engine.couple(self._in_model[0], self._in_model[1], ratio)

    def set_surface(self, surface: Surface) -> None:
        """Sets the friction of the links that the joints move."""
        for name in self._bodies:
            for geom in self._engine.spec.body(name).geoms:
                self._engine.set_contact(geom, surface)
        self._engine.recompile()


class MujocoLink:
    """A :class:`skiros_py.ports.simulation.Link`; accelerations are differences of velocities.

    Args:
        engine: The engine; it tells links whose acceleration is wanted of each step.
        name: Its name in the model.
    """

    def __init__(self, engine: MujocoEngine, name: str) -> None:
        self._engine = engine
        self._name = name
        self._before: Twist | None = None

    def pose(self) -> Pose:
        """Returns the pose of the link frame in the map."""
        return self._engine.body_pose(self._name)

    def twist(self) -> Twist:
        """Returns the velocity of the link frame."""
        return self._engine.velocity(self._name, mujoco.mjtObj.mjOBJ_XBODY)

    def acceleration(self) -> Twist:
        """Returns the acceleration of the link frame over the last step; zero at the first call."""
        if self._before is None:
            self.remember()
            self._engine.before_step(self.remember)
        now, before, period = self.twist(), self._before or Twist(), self._engine.period
        return Twist(
            vector(np.subtract(now.linear, before.linear) / period),
            vector(np.subtract(now.angular, before.angular) / period),
        )

    def remember(self) -> None:
        """Keeps the current velocity."""
        self._before = self.twist()


def _limits_of(urdf: ET.Element) -> dict[str, dict[str, float]]:
    return {
        joint.get("name", ""): {key: float(limit.get(key, bound)) for key, bound in _NO_LIMIT.items()}
        for joint in urdf.iter("joint")
        for limit in joint.findall("limit")
    }


def vector(values: Any) -> tuple[float, float, float]:
    """Returns three numbers as Python's own."""
    return float(values[0]), float(values[1]), float(values[2])

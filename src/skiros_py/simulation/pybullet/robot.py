"""Robots in PyBullet: joints and links by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from skiros_py.errors import DescriptionError, DeviceError, UnknownName, UsageError
from skiros_py.geometry import Array, Pose, rotation_matrix
from skiros_py.ports.simulation import JointLimits, JointReadings, Surface, Twist, Vector, Wrench
from skiros_py.simulation.models import read_urdf, soft_links
from skiros_py.simulation.pybullet.client import Client

if TYPE_CHECKING:
    from skiros_py.simulation.pybullet.engine import PyBulletEngine

_COUPLING_ERP = 0.1
_MOST_POINTS = 4
"""At so many points two shapes touch at most."""


class RobotModel:
    """A loaded URDF: numbers of its joints and links by name.

    Args:
        client: The physics client.
        urdf: The file.
        pose: Pose of the root link in the map.

    Attributes:
        body: PyBullet's id.
        movable: Numbers of all joints that are not fixed.
        links: Link numbers by name; the root is -1.
        readings: What :meth:`read` has read since the last step; None if nothing.
    """

    def __init__(self, client: Client, urdf: Path, pose: Pose) -> None:
        self.client = client
        flags = client.URDF_USE_INERTIA_FROM_FILE
        at = {} if pose == Pose() else {"basePosition": pose.position, "baseOrientation": pose.orientation}
        try:
            self.body: int = client.loadURDF(str(urdf), useFixedBase=True, flags=flags, **at)
        except DeviceError as error:
            read_urdf(urdf)  # says more than a mere "cannot load", where it knows more
            raise DescriptionError(f"{urdf}: {error}") from error
        self.infos = [client.getJointInfo(self.body, index) for index in range(client.getNumJoints(self.body))]
        self.numbers: dict[str, int] = {info[1].decode(): info[0] for info in self.infos}
        self.links: dict[str, int] = {client.getBodyInfo(self.body)[0].decode(): -1}
        self.links |= {info[12].decode(): info[0] for info in self.infos}
        self.link_names = {number: name for name, number in self.links.items()}
        self.movable: list[int] = [info[0] for info in self.infos if info[2] != client.JOINT_FIXED]
        self.readings: dict[int, Any] | None = None

    def read(self) -> Mapping[int, Any]:
        """Returns the states of all movable joints, by number; they are read once after each step."""
        if self.readings is None:
            states = self.client.getJointStates(self.body, self.movable) if self.movable else ()
            self.readings = dict(zip(self.movable, states, strict=True))
        return self.readings

    def link(self, name: str) -> int:
        """Returns the number of a link.

        Raises:
            UnknownName: The robot has no such link.
        """
        if name not in self.links:
            raise UnknownName("link", name, self.links)
        return self.links[name]

    def link_pose(self, link: int) -> Pose:
        """Returns the pose of a link frame in the map."""
        if link >= 0:
            state = self.client.getLinkState(self.body, link, computeForwardKinematics=True)
            return Pose(state[4], state[5])
        inertial = self.client.getDynamicsInfo(self.body, -1)
        position, orientation = self.client.getBasePositionAndOrientation(self.body)
        return Pose(position, orientation) @ Pose(tuple(inertial[3]), tuple(inertial[4])).inverse()


class PyBulletRobot:
    """A :class:`skiros_py.ports.simulation.SimulatedRobot`.

    Args:
        engine: The engine.
        name: Its name.
        urdf: Its model.
        pose: Pose of the root link in the map.

    Attributes:
        engine: The engine.
        name: Its name.
        model: The loaded model.
        urdf: Its file.
    """

    def __init__(self, engine: PyBulletEngine, name: str, urdf: Path, pose: Pose) -> None:
        self.engine = engine
        self.name = name
        self.urdf = urdf
        self.model = RobotModel(engine.client, urdf, pose)
        self._links: dict[str, PyBulletLink] = {}
        self._soft = {self.model.link(link): softness for link, softness in soft_links(read_urdf(urdf)).items()}
        self._shared: dict[int, int] = {}  # among how many points the stiffness of each soft link is shared now
        self._free_joints()

    @property
    def joint_names(self) -> tuple[str, ...]:
        """All movable joints, in the order of the model."""
        return tuple(self.model.infos[index][1].decode() for index in self.model.movable)

    @property
    def link_names(self) -> tuple[str, ...]:
        """All links, in the order of the model."""
        return tuple(self.model.links)

    def joints(self, names: Sequence[str]) -> PyBulletJoints:
        """Returns some joints, to be read and driven together.

        Raises:
            UnknownName: It has no such joint.
        """
        return PyBulletJoints(self.model, tuple(names))

    def link(self, name: str) -> PyBulletLink:
        """Returns a link.

        Raises:
            UnknownName: It has no such link.
        """
        if name not in self._links:
            self._links[name] = PyBulletLink(self.engine, self.model, self.model.link(name))
        return self._links[name]

    def link_poses(self) -> Mapping[str, Pose]:
        """Returns the poses of all links in the map."""
        return {name: self.model.link_pose(number) for name, number in self.model.links.items()}

    def share_softness(self) -> None:
        """Shares the stiffness of each soft link among the points at which it was touched in the last step.

        PyBullet has it for each point. Where nothing was touched it counts with the most, so that no blow is harder.
        """
        for link, whole in self._soft.items():
            points = len(self.model.client.getContactPoints(bodyA=self.model.body, linkIndexA=link)) or _MOST_POINTS
            if points != self._shared.get(link):
                self._shared[link] = points
                stiffness, damping = whole.stiffness / points, whole.damping / points
                self.model.client.changeDynamics(
                    self.model.body, link, contactStiffness=stiffness, contactDamping=damping
                )

    def motion(self) -> tuple[float, ...]:
        """Returns position and velocity of each movable joint in turn."""
        return tuple(value for state in self.model.read().values() for value in state[:2])

    def _free_joints(self) -> None:
        """Removes the damping and the holding motors that PyBullet gives every joint of a new robot."""
        client, model = self.model.client, self.model
        for index in range(-1, len(model.infos)):
            client.changeDynamics(model.body, index, linearDamping=0, angularDamping=0, jointDamping=0)
        _switch_off(client, model.body, model.movable)


class PyBulletJoints:
    """A :class:`skiros_py.ports.simulation.JointGroup`.

    Args:
        model: The robot.
        names: Joint names.

    Raises:
        UnknownName: The robot has no such joint.
    """

    def __init__(self, model: RobotModel, names: tuple[str, ...]) -> None:
        for name in names:
            if name not in model.numbers:
                raise UnknownName("joint", name, model.numbers)
        self.names = names
        self._model = model
        self._client = model.client
        self._body = model.body
        self._indices = [model.numbers[name] for name in names]
        self._centres: list[tuple[Vector, Array | None]] = []  # of mass where reactions are measured, and its axes
        rows = [model.infos[index] for index in self._indices]
        self.links = tuple(str(row[12].decode()) for row in rows)
        lower, upper, effort, velocity = (np.array([row[column] for row in rows]) for column in (8, 9, 10, 11))
        self.limits = JointLimits(lower, upper, effort, velocity)

    def read(self) -> JointReadings:
        """Reads the sensors."""
        states = self._model.read()
        positions, velocities, _, efforts = zip(*(states[index] for index in self._indices), strict=True)
        return JointReadings(positions, velocities, efforts)

    def reset(self, positions: Sequence[float]) -> None:
        """Puts the joints to positions, at rest."""
        for index, position in zip(self._indices, positions, strict=True):
            self._client.resetJointState(self._body, index, position)
        self._model.readings = None

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
        client, mode = self._client, self._client.POSITION_CONTROL
        wanted = [0.0] * len(self._indices) if velocities is None else velocities
        if max_velocity is None:
            client.setJointMotorControlArray(
                self._body,
                self._indices,
                mode,
                targetPositions=positions,
                targetVelocities=wanted,
                positionGains=[gain] * len(self._indices),
                velocityGains=[1.0] * len(self._indices),
                forces=effort,
            )
            return
        for index, position, velocity, force in zip(self._indices, positions, wanted, effort, strict=True):
            client.setJointMotorControl2(
                self._body,
                index,
                mode,
                targetPosition=position,
                targetVelocity=velocity,
                positionGain=gain,
                force=force,
                maxVelocity=max_velocity,
            )

    def drive_velocities(self, velocities: Sequence[float], *, effort: float) -> None:
        """Lets the motors keep velocities."""
        self._client.setJointMotorControlArray(
            self._body,
            self._indices,
            self._client.VELOCITY_CONTROL,
            targetVelocities=velocities,
            forces=[effort] * len(self._indices),
        )

    def apply_efforts(self, efforts: Sequence[float]) -> None:
        """Applies efforts for one step; the motors are switched off."""
        _switch_off(self._client, self._body, self._indices)
        self._client.setJointMotorControlArray(
            self._body, self._indices, self._client.TORQUE_CONTROL, forces=list(efforts)
        )

    def reactions(self) -> tuple[Wrench, ...]:
        """Returns the wrench through each joint after the last step, in the frame of the link that it moves."""
        if not self._centres:
            for index in self._indices:
                self._client.enableJointForceTorqueSensor(self._body, index, True)
                inertial = self._client.getDynamicsInfo(self._body, index)
                turn = rotation_matrix(inertial[4])
                self._centres.append((_vector(inertial[3]), None if np.allclose(turn, np.eye(3)) else turn))
        states = self._model.read()
        return tuple(
            _at_joint(states[index][2], *centre) for index, centre in zip(self._indices, self._centres, strict=True)
        )

    def couple(self, *, ratio: float, effort: float) -> None:
        """Couples two joints mechanically; a gear of PyBullet counts the turns of both against each other."""
        if len(self._indices) != 2:
            raise UsageError(f"two joints can be coupled, not {len(self._indices)}: {', '.join(self.names)}")
        client, (first, second), origin = self._client, self._indices, (0.0, 0.0, 0.0)
        axis = (1.0, 0.0, 0.0)
        gear = client.createConstraint(self._body, first, self._body, second, client.JOINT_GEAR, axis, origin, origin)
        client.changeConstraint(gear, gearRatio=-ratio, erp=_COUPLING_ERP, maxForce=effort)

    def set_surface(self, surface: Surface) -> None:
        """Sets the friction of the links that the joints move."""
        for index in self._indices:
            self._client.changeDynamics(self._body, index, **surface_options(surface))


class PyBulletLink:
    """A :class:`skiros_py.ports.simulation.Link`; PyBullet measures no accelerations, so they are differences.

    Args:
        engine: The engine; it tells links whose acceleration is wanted of each step.
        model: The robot.
        number: Number of the link; -1 for the root.
    """

    def __init__(self, engine: PyBulletEngine, model: RobotModel, number: int) -> None:
        self._engine = engine
        self._model = model
        self._number = number
        self._before: Twist | None = None

    def pose(self) -> Pose:
        """Returns the pose of the link frame in the map."""
        return self._model.link_pose(self._number)

    def twist(self) -> Twist:
        """Returns the velocity of the link frame."""
        if self._number < 0:
            return Twist()
        state = self._model.client.getLinkState(
            self._model.body, self._number, computeLinkVelocity=True, computeForwardKinematics=True
        )
        linear, angular = np.array(state[6]), np.array(state[7])  # of the centre of mass
        at_frame = linear + np.cross(angular, np.subtract(state[4], state[0]))
        return Twist(_vector(at_frame), _vector(angular))

    def acceleration(self) -> Twist:
        """Returns the acceleration of the link frame over the last step; zero at the first call."""
        if self._before is None:
            self.remember()
            self._engine.before_step(self.remember)
        now, before, period = self.twist(), self._before or Twist(), self._engine.period
        return Twist(
            _vector(np.subtract(now.linear, before.linear) / period),
            _vector(np.subtract(now.angular, before.angular) / period),
        )

    def remember(self) -> None:
        """Keeps the current velocity."""
        self._before = self.twist()


def surface_options(surface: Surface) -> Mapping[str, Any]:
    """Returns a surface in PyBullet's words, without what it does not state."""
    stated = {
        "lateralFriction": surface.lateral,
        "spinningFriction": surface.spinning,
        "rollingFriction": surface.rolling,
        "frictionAnchor": 1 if surface.anchored else None,
    }
    return {key: value for key, value in stated.items() if value is not None}


def _at_joint(reaction: Sequence[float], centre: Vector, turn: Array | None) -> Wrench:
    """Returns a reaction in the frame of its link: PyBullet gives it at the link's centre of mass, along its axes.

    Args:
        reaction: Force and torque as PyBullet gives them.
        centre: The centre of mass in the frame of the link [m].
        turn: How the axes there are turned in that frame; None where they are not.
    """
    if turn is not None:
        reaction = (*(turn @ np.asarray(reaction[:3])), *(turn @ np.asarray(reaction[3:])))
    (x, y, z), (fx, fy, fz, tx, ty, tz) = centre, reaction
    return Wrench((fx, fy, fz), (tx + y * fz - z * fy, ty + z * fx - x * fz, tz + x * fy - y * fx))


def _switch_off(client: Client, body: int, indices: Sequence[int]) -> None:
    count = len(indices)
    if count:
        client.setJointMotorControlArray(
            body, indices, client.VELOCITY_CONTROL, targetVelocities=[0.0] * count, forces=[0.0] * count
        )


def _vector(values: Any) -> tuple[float, float, float]:
    return float(values[0]), float(values[1]), float(values[2])

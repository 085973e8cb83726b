"""The simulation port: physics in the words of robotics, the same for every engine.

Simulated devices, bodies and the truth reach physics through these protocols only, so they run unchanged on every
engine. An engine is found by the entry-point group ``skiros.engines``, and only its adapter imports its library.

Bodies and robots share one set of names. All poses are in the map frame unless stated otherwise; joint values are in
rad and N m (revolute) or m and N (prismatic).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple, Protocol, TypeVar, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from skiros_py.geometry import Array, Pose, Solid
from skiros_py.ports.values import CameraIntrinsics, Pending

FLOOR = "floor"
"""Name of the floor, the plane z = 0; every engine has it."""

T = TypeVar("T")

Vector = tuple[float, float, float]
Colour = tuple[float, float, float, float]
"""Red, green, blue, opacity, each 0 to 1."""


@dataclass(frozen=True, slots=True)
class Wrench:
    """A force [N] and a torque [N m] at one point."""

    force: Vector = (0.0, 0.0, 0.0)
    torque: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Twist:
    """Linear [m/s] and angular [rad/s] velocity of a frame, expressed in the map; an acceleration has the same form."""

    linear: Vector = (0.0, 0.0, 0.0)
    angular: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Surface:
    """Friction of a surface; None keeps the engine's value.

    Attributes:
        lateral: Coefficient of sliding friction.
        spinning: Coefficient of friction against spinning about the contact normal.
        rolling: Coefficient of rolling friction.
        anchored: True to hold a resting contact at the point where it began, so that a gripped part does not creep.
    """

    lateral: float | None = None
    spinning: float | None = None
    rolling: float | None = None
    anchored: bool = False


class JointLimits(NamedTuple):
    """Limits of some joints, each of shape (n,): positions, greatest effort and greatest speed."""

    lower: Array
    upper: Array
    effort: Array
    velocity: Array


class JointReadings(NamedTuple):
    """Sensors of some joints, each of length n.

    Attributes:
        positions: Joint positions.
        velocities: Joint velocities.
        efforts: What the joint motors applied in the last step.
    """

    positions: tuple[float, ...]
    velocities: tuple[float, ...]
    efforts: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Contact:
    """Two bodies touch at one point.

    Attributes:
        body: One of the bodies or robots.
        link: Its link; empty for a body.
        other: The other body, robot or :data:`FLOOR`.
        other_link: Its link; empty for a body.
        point: Where [m].
        normal: Unit vector from ``other`` to ``body``.
        depth: Penetration [m]; negative while they are apart by less than the engine's margin.
        force: Normal force [N].
    """

    body: str
    link: str
    other: str
    other_link: str
    point: Vector
    normal: Vector
    depth: float
    force: float


@dataclass(frozen=True, slots=True)
class RayHit:
    """The first body on a ray and its link (empty for a body), the share of the ray before it (0…1), point, normal."""

    body: str
    link: str
    fraction: float
    point: Vector
    normal: Vector


@dataclass(frozen=True, slots=True)
class View:
    """A view to render.

    Attributes:
        width, height: Image size [px].
        vertical_fov: Vertical field of view [rad].
        near, far: Range of depth [m].
        pose: Pose of the optical frame (z forward, x right, y down), in the map or in the link's frame.
        robot: Robot that carries the camera; None for a view from a fixed point.
        link: Link that carries it.
    """

    width: int
    height: int
    vertical_fov: float
    near: float
    far: float
    pose: Pose = field(default_factory=Pose)
    robot: str | None = None
    link: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Rendering:
    """A rendered view without noise.

    Attributes:
        depth: Distance along the optical axis [m], shape (height, width); infinite where nothing is in range.
        colour: RGB, shape (height, width, 3).
    """

    depth: Array
    colour: NDArray[np.uint8]


class JointGroup(Protocol):
    """Some joints of one robot, read and driven together; all vectors follow the order of :attr:`names`."""

    @property
    def names(self) -> tuple[str, ...]:
        """Joint names."""

    @property
    def links(self) -> tuple[str, ...]:
        """The link that each joint moves."""

    @property
    def limits(self) -> JointLimits:
        """Limits as the URDF states them."""

    def read(self) -> JointReadings:
        """Reads the sensors."""

    def reset(self, positions: Sequence[float]) -> None:
        """Puts the joints to positions, at rest, without simulating a motion."""

    def hold_positions(
        self,
        positions: Sequence[float] | Array,
        *,
        gain: float,
        effort: Sequence[float] | Array,
        velocities: Sequence[float] | Array | None = None,
        max_velocity: float | None = None,
    ) -> None:
        """Lets the motors drive to positions and hold them, until they are driven otherwise.

        Args:
            positions: Where to go.
            gain: Share of the position error that is corrected in one step (0 to 1).
            effort: Greatest effort of each motor.
            velocities: Velocities to have there; 0 where left out.
            max_velocity: Greatest speed of all; None for no such limit.
        """

    def drive_velocities(self, velocities: Sequence[float], *, effort: float) -> None:
        """Lets the motors keep velocities, with at most an effort, until they are driven otherwise."""

    def apply_efforts(self, efforts: Sequence[float]) -> None:
        """Applies efforts for one step; the motors are switched off."""

    def reactions(self) -> tuple[Wrench, ...]:
        """Returns the wrench through each joint after the last step, in the frame of the link that it moves.

        It is what the parent exerts on that link at the joint: a link that rests on its joint is pushed up. Engines
        may measure it only from the step after the first call on, and return zeros until then.
        """

    def couple(self, *, ratio: float, effort: float) -> None:
        """Couples two joints mechanically: the second moves by ``ratio`` times what the first does.

        Args:
            ratio: Displacement of the second per displacement of the first.
            effort: Greatest effort of the coupling.

        Raises:
            UsageError: The group has not exactly two joints.
        """

    def set_surface(self, surface: Surface) -> None:
        """Sets the friction of the links that the joints move."""


class Link(Protocol):
    """One link of a robot."""

    def pose(self) -> Pose:
        """Returns the pose of the link frame in the map."""

    def twist(self) -> Twist:
        """Returns the velocity of the link frame."""

    def acceleration(self) -> Twist:
        """Returns the acceleration of the link frame over the last step, without gravity; zero at the first call."""


class SimulatedRobot(Protocol):
    """One articulated robot."""

    @property
    def name(self) -> str:
        """Its name."""

    @property
    def engine(self) -> Engine:
        """The engine that it lives in."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """All movable joints, in the order of the model."""

    @property
    def link_names(self) -> tuple[str, ...]:
        """All links, in the order of the model."""

    def joints(self, names: Sequence[str]) -> JointGroup:
        """Returns some joints, to be read and driven together.

        Raises:
            UnknownName: It has no such joint.
        """

    def link(self, name: str) -> Link:
        """Returns a link.

        Raises:
            UnknownName: It has no such link.
        """


@dataclass(frozen=True, slots=True)
class Print:
    """Something black on white, on a face of a body.

    Attributes:
        dark: Rows of square cells, each True where it is black; cells of a row follow each other along the x axis.
        cell: Side length of a cell [m].
        pose: Pose of the outer corner of the first cell in the frame of the body; its z axis points into the body.
    """

    dark: tuple[tuple[bool, ...], ...]
    cell: float
    pose: Pose


class Engine(Protocol):
    """A physics engine with one world in it; owned by one thread.

    Its world has gravity of 9.81 m/s² along -z and a floor.

    Attributes:
        printed: What pictures show on bodies, by name.
    """

    printed: dict[str, Print]

    @property
    def name(self) -> str:
        """Name of the engine ("pybullet")."""

    @property
    def period(self) -> float:
        """Length of one step [s]."""

    def step(self) -> None:
        """Simulates one period."""

    # ------------------------------------------------------------------ what is in the world

    def add_robot(self, name: str, urdf: Path, pose: Pose = ...) -> SimulatedRobot:
        """Loads a robot with its root link fixed at a pose; its joints have neither damping nor motors that hold.

        Raises:
            UsageError: The name is taken.
        """

    def add_body(
        self, name: str, solid: Solid, pose: Pose, *, mass: float = 0.0, colour: Colour, surface: Surface = ...
    ) -> None:
        """Builds a rigid body of even density, at rest.

        Args:
            name: Its name.
            solid: Its shape.
            pose: Pose of the solid's frame.
            mass: [kg]; 0 for a body that never moves by itself.
            colour: For pictures.
            surface: Its friction.

        Raises:
            UsageError: The name is taken.
        """

    def remove_body(self, name: str) -> None:
        """Removes a body, and its attachment to a link.

        Raises:
            UnknownName: There is no such body.
        """

    def move_body(self, name: str, pose: Pose) -> None:
        """Puts a body to a pose, at rest.

        Raises:
            UnknownName: There is no such body.
        """

    def attach(self, body: str, robot: str, link: str) -> None:
        """Fixes a body with mass to a link, where it is now; it no longer collides with that link.

        Raises:
            UnknownName: There is no such body, robot or link.
            UsageError: The body has no mass, or is attached already.
        """

    def detach(self, body: str) -> None:
        """Releases an attached body.

        Raises:
            UnknownName: There is no such body, or it is not attached.
        """

    # ------------------------------------------------------------------ what physics says

    def pose(self, body: str) -> Pose:
        """Returns the pose of a body's solid frame.

        Raises:
            UnknownName: There is no such body.
        """

    def poses(self) -> Mapping[str, Pose]:
        """Returns the current poses of all bodies; quick to take, each pose is computed when it is first read."""

    def twist(self, body: str) -> Twist:
        """Returns the velocity of a body's centre of mass.

        Raises:
            UnknownName: There is no such body.
        """

    def contacts(self, name: str, link: str | None = None) -> tuple[Contact, ...]:
        """Returns the contacts of a body or robot after the last step.

        Args:
            name: The body or robot; it is ``body`` of each contact.
            link: Only those of this link.

        Raises:
            UnknownName: There is no such body, robot or link.
        """

    def cast_rays(self, starts: Array, ends: Array) -> tuple[RayHit | None, ...]:
        """Returns what each ray meets first.

        Args:
            starts: Where the rays start [m], shape (n, 3).
            ends: Where they end [m], shape (n, 3).
        """

    def apply_wrench(self, name: str, wrench: Wrench, *, at: Vector | None = None, link: str = "") -> None:
        """Applies a wrench during the next step.

        Args:
            name: The body or robot.
            wrench: Expressed in the map.
            at: Where the force acts [m]; None for the centre of mass.
            link: The robot's link.

        Raises:
            UnknownName: There is no such body, robot or link.
        """

    # ------------------------------------------------------------------ pictures

    def prepare_rendering(self) -> None:
        """Starts what renders, so that the first view does not wait for it; returns at once."""

    def intrinsics(self, view: View) -> CameraIntrinsics:
        """Returns the exact pinhole model of the images of a view."""

    def render(self, view: View, finish: Callable[[Rendering], T], *, latency: float = 0.0) -> Pending[T]:
        """Renders the current moment, however long that takes.

        Args:
            view: What to render.
            finish: Picklable; called with the rendering, away from the calling thread, as what renders is.
            latency: Declared time until the answer may be used [s].

        Returns:
            What ``finish`` returned.
        """

    def look_at(self, target: Vector, distance: float) -> None:
        """Turns the window to a point, from a distance above it [m]; does nothing without a window."""

    # ------------------------------------------------------------------ state

    def state_bytes(self) -> bytes:
        """Returns the exact state of all joints and bodies, for comparing runs."""

    def save(self) -> object:
        """Returns the state of all that is in the world now, for :meth:`restore`."""

    def restore(self, state: object) -> None:
        """Goes back to a saved state; the same bodies and robots must be there.

        Raises:
            DeviceError: Others are there.
        """

    def close(self) -> None:
        """Ends the engine and its processes; may be called twice."""


class EngineFactory(Protocol):
    """Builds an engine; an entry point of ``skiros.engines`` names one."""

    def __call__(self, *, period: float, gui: bool) -> Engine:
        """Builds an engine with an empty world.

        Args:
            period: Length of one step [s].
            gui: Open a window.

        Raises:
            UsageError: A window is wanted where there is none to be had.
            DeviceError: The engine does not work here.
        """


@runtime_checkable
class SimulatedHolder(Protocol):
    """A simulated device that holds what all its fingers touch.

    Attributes:
        fingers: Links of the fingers.
    """

    fingers: tuple[str, ...]

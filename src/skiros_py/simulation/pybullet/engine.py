"""PyBullet as a physics engine of the simulation port."""

from __future__ import annotations

import itertools
import struct
import weakref
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from skiros_py.errors import DeviceError, UnknownName, UsageError
from skiros_py.geometry import Array, Pose, Solid
from skiros_py.ports.simulation import FLOOR, Colour, Contact, RayHit, Surface, Twist, Vector, Wrench
from skiros_py.simulation.pybullet.client import Body, Client, Poses, build_solid, centre_of_mass
from skiros_py.simulation.pybullet.robot import PyBulletRobot, surface_options
from skiros_py.simulation.renderer import RenderedWorld

_GRAVITY = 9.81  # [m/s²]
_ATTACHMENT_FORCE = 1e5  # [N]
_AS_THE_ENGINE_HAS_IT = Surface()
_ORIGIN = Pose()


@dataclass(frozen=True)
class _State:
    """A saved state: the bodies that were there, and its number in the client, which keeps it as long as this lives."""

    bodies: tuple[str, ...]
    number: int


class PyBulletEngine(RenderedWorld[Body, PyBulletRobot]):
    """A :class:`skiros_py.ports.simulation.Engine`.

    Args:
        period: Length of one step [s].
        gui: Open a window.

    Attributes:
        client: The physics client; for tests of this adapter.
        period: Length of one step [s].

    Raises:
        UsageError: A window is wanted where there is no display.
        DeviceError: PyBullet does not work here.
    """

    name = "pybullet"

    def __init__(self, *, period: float, gui: bool = False) -> None:
        super().__init__()
        self.client = Client(gui=gui)
        self.period = period
        client = self.client
        client.setGravity(0.0, 0.0, -_GRAVITY)
        client.setTimeStep(period)
        client.setPhysicsEngineParameter(
            numSolverIterations=50,
            # Contact points kept over a longer distance keep their direction while the robot turns: held parts then
            # stick to a finger that opens.
            contactBreakingThreshold=0.001,
            deterministicOverlappingPairs=1,
        )
        self._floor: int = client.createMultiBody(0, client.createCollisionShape(client.GEOM_PLANE))

    def step(self) -> None:
        """Simulates one period."""
        for action in self._before_step:
            action()
        for robot in self.robots.values():
            robot.share_softness()
        self.client.stepSimulation()
        self._forget_readings()

    # ------------------------------------------------------------------ what is in the world

    def add_robot(self, name: str, urdf: Path, pose: Pose = _ORIGIN) -> PyBulletRobot:
        """Loads a robot with its root link fixed at a pose."""
        self._require_free(name)
        self.robots[name] = PyBulletRobot(self, name, urdf, pose)
        return self.robots[name]

    def add_body(
        self,
        name: str,
        solid: Solid,
        pose: Pose,
        *,
        mass: float = 0.0,
        colour: Colour,
        surface: Surface = _AS_THE_ENGINE_HAS_IT,
    ) -> None:
        """Builds a rigid body of even density, at rest."""
        self._require_free(name)
        centre = centre_of_mass(solid) if mass > 0.0 else (0.0, 0.0, 0.0)
        index = build_solid(self.client, solid, pose, mass=mass, centre=centre, colour=colour)
        if options := surface_options(surface):
            for link in range(-1, self.client.getNumJoints(index)):
                self.client.changeDynamics(index, link, **options)
        self.bodies[name] = Body(index, solid, mass, centre, colour)

    def remove_body(self, name: str) -> None:
        """Removes a body, and its attachment to a link."""
        body = self._body(name)
        if body.constraint is not None:
            self.client.removeConstraint(body.constraint)
        self.client.removeBody(body.index)
        del self.bodies[name]

    def move_body(self, name: str, pose: Pose) -> None:
        """Puts a body to a pose, at rest."""
        body = self._body(name)
        at = pose @ Pose(body.centre)
        self.client.resetBasePositionAndOrientation(body.index, at.position, at.orientation)
        self.client.resetBaseVelocity(body.index, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))

    def attach(self, body: str, robot: str, link: str) -> None:
        """Fixes a body with mass to a link, where it is now; it no longer collides with that link."""
        attached, model, client = self._body(body), self._robot(robot).model, self.client
        number = model.link(link)
        if attached.mass <= 0.0 or attached.constraint is not None:
            raise UsageError(f"'{body}' has no mass, or is attached already: it cannot be attached to '{link}'")
        # The constraint's frames are relative to the centres of mass of both.
        mounted = self._link_centre(model.body, number).inverse() @ self._link_centre(attached.index, -1)
        frames = (mounted.position, (0.0, 0.0, 0.0), mounted.orientation, (0.0, 0.0, 0.0, 1.0))
        attached.constraint = client.createConstraint(
            model.body, number, attached.index, -1, client.JOINT_FIXED, (0.0, 0.0, 0.0), *frames
        )
        client.changeConstraint(attached.constraint, maxForce=_ATTACHMENT_FORCE)
        client.setCollisionFilterPair(model.body, attached.index, number, -1, 0)

    def detach(self, body: str) -> None:
        """Releases an attached body."""
        attached = self._body(body)
        if attached.constraint is None:
            raise UnknownName("attached body", body, [n for n, b in self.bodies.items() if b.constraint is not None])
        self.client.removeConstraint(attached.constraint)
        attached.constraint = None
        for robot in self.robots.values():
            for number in robot.model.links.values():
                self.client.setCollisionFilterPair(robot.model.body, attached.index, number, -1, 1)

    # ------------------------------------------------------------------ what physics says

    def pose(self, body: str) -> Pose:
        """Returns the pose of a body's solid frame."""
        found = self._body(body)
        x, y, z = found.centre
        return self._link_centre(found.index, -1) @ Pose((-x, -y, -z))

    def poses(self) -> Poses:
        """Returns the current poses of all bodies."""
        return Poses(self.bodies, self.client)

    def twist(self, body: str) -> Twist:
        """Returns the velocity of a body's centre of mass."""
        linear, angular = self.client.getBaseVelocity(self._body(body).index)
        return Twist(tuple(linear), tuple(angular))

    def contacts(self, name: str, link: str | None = None) -> tuple[Contact, ...]:
        """Returns the contacts of a body or robot after the last step."""
        if name in self.bodies and not link:
            points = self.client.getContactPoints(self.bodies[name].index)
        else:
            model = self._robot(name).model
            narrowed = {} if link is None else {"linkIndexA": model.link(link)}
            points = self.client.getContactPoints(model.body, **narrowed)
        named = self._naming()
        return tuple(
            Contact(*named(point[1], point[3]), *named(point[2], point[4]), point[5], point[7], -point[8], point[9])
            for point in points
        )

    def cast_rays(self, starts: Array, ends: Array) -> tuple[RayHit | None, ...]:
        """Returns what each ray meets first."""
        found: list[RayHit | None] = []
        most, named = self.client.MAX_RAY_INTERSECTION_BATCH_SIZE, self._naming()
        for first in range(0, len(starts), most):
            batch = slice(first, first + most)
            for index, number, fraction, point, normal in self.client.rayTestBatch(
                np.asarray(starts[batch]).tolist(), np.asarray(ends[batch]).tolist()
            ):
                found.append(None if index < 0 else RayHit(*named(index, number), fraction, point, normal))
        return tuple(found)

    def _naming(self) -> Callable[[int, int], tuple[str, str]]:
        """Returns what gives the names of a body or robot and of its link by PyBullet's numbers."""
        names = {body.index: name for name, body in self.bodies.items()} | {self._floor: FLOOR}
        robots = {robot.model.body: robot for robot in self.robots.values()}

        def named(index: int, number: int) -> tuple[str, str]:
            robot = robots.get(index)
            return (names[index], "") if robot is None else (robot.name, robot.model.link_names[number])

        return cache(named)

    def apply_wrench(self, name: str, wrench: Wrench, *, at: Vector | None = None, link: str = "") -> None:
        """Applies a wrench during the next step."""
        if name in self.bodies and not link:
            index, number = self.bodies[name].index, -1
        else:
            model = self._robot(name).model
            index, number = model.body, model.link(link)
        centre = self._link_centre(index, number)
        world = self.client.WORLD_FRAME
        self.client.applyExternalForce(index, number, wrench.force, at or centre.position, world)
        self.client.applyExternalTorque(index, number, wrench.torque, world)

    def look_at(self, target: Vector, distance: float) -> None:
        """Turns the window to a point."""
        self.client.look_at(target, distance)

    # ------------------------------------------------------------------ state

    def state_bytes(self) -> bytes:
        """Returns the exact state of all joints and bodies."""
        values = list(itertools.chain.from_iterable(robot.motion() for robot in self.robots.values()))
        for body in self.bodies.values():
            values.extend(itertools.chain(*self.client.getBasePositionAndOrientation(body.index)))
            values.extend(itertools.chain(*self.client.getBaseVelocity(body.index)))
        return struct.pack(f"<{len(values)}d", *values)

    def save(self) -> object:
        """Returns the state of all that is in the world now."""
        number = self.client.saveState()
        state = _State(tuple(self.bodies), number)
        weakref.finalize(state, self._forget, number).atexit = False
        return state

    def _forget_readings(self) -> None:
        for robot in self.robots.values():
            robot.model.readings = None

    def _forget(self, number: int) -> None:
        with suppress(DeviceError):  # the client is closed
            self.client.removeState(number)

    def restore(self, state: object) -> None:
        """Goes back to a saved state; the same bodies and robots must be there."""
        match state:
            case _State(bodies, number) if bodies == tuple(self.bodies):
                self.client.restoreState(number)
                self._forget_readings()
            case _:
                raise DeviceError("this state was saved with other bodies in the world")

    def close(self) -> None:
        """Ends the renderer's process and the physics client; may be called twice."""
        super().close()
        self.client.close()

    def _link_centre(self, index: int, number: int) -> Pose:
        if number < 0:
            position, orientation = self.client.getBasePositionAndOrientation(index)
            return Pose(tuple(position), tuple(orientation))
        state = self.client.getLinkState(index, number, computeForwardKinematics=True)
        return Pose(state[0], state[1])

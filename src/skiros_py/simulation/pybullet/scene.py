"""Everything in the physics client: floor, bodies, compartments, robots."""

from __future__ import annotations

import itertools
import struct
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from skiros_py.errors import UnknownName, UsageError
from skiros_py.geometry import Pose
from skiros_py.ports.cell import BodySpec, CellSpec
from skiros_py.simulation.pybullet.appearance import Palette
from skiros_py.simulation.pybullet.bodies import Body, build_solid, centre_of_mass
from skiros_py.simulation.pybullet.client import Client
from skiros_py.simulation.pybullet.picture import Look, SceneState
from skiros_py.simulation.pybullet.robot import Robot
from skiros_py.simulation.pybullet.spawn import start_poses

__all__ = ["Scene"]

_GRAVITY = 9.81  # [m/s²]
_CARRIED_MASS = 2.0  # [kg] of a body without mass that rides on a robot and so cannot be part of the ground
_BOLT_FORCE = 1e5  # [N]
_LOCALISER_STREAM = 1


class Scene:
    """The simulated world behind a cell.

    Args:
        client: The physics client.
        spec: What stands in it.
        urdfs: Model of each robot, by the robot's id.
        seed: The run's seed.
        period: Control period, which is also the physics step [s].

    Attributes:
        client: The physics client.
        bodies: Bodies by id.
        compartments: Compartments by id, each with its pose in the frame of the body it belongs to.
        robots: The robots.
        floor: PyBullet's id of the floor.
    """

    def __init__(self, client: Client, spec: CellSpec, urdfs: Mapping[str, Path], *, seed: int, period: float) -> None:
        self.client = client
        _set_up(client, period)
        self.floor: int = client.createMultiBody(0, client.createCollisionShape(client.GEOM_PLANE))
        self._palette = Palette()
        self.bodies: dict[str, Body] = {}
        poses = start_poses(spec, seed)
        self.robots = [
            Robot(client, robot, urdfs[robot.id], np.random.default_rng([seed, _LOCALISER_STREAM, number]), period)
            for number, robot in enumerate(spec.robots)
        ]
        self.compartments = {
            body.id: (body, poses[body.place].inverse() @ poses[body.id])
            for body in spec.bodies
            if body.compartment and body.place is not None
        }
        for body in spec.bodies:
            if not body.compartment:
                self.add(body, poses[body.id])

    def add(self, spec: BodySpec, pose: Pose) -> None:
        """Builds a body at a pose in the map.

        Raises:
            UsageError: There is a body of that id, or it is a compartment.
        """
        if spec.id in self.bodies or spec.compartment:
            raise UsageError(f"'{spec.id}' is a compartment or is in the cell already")
        mass = spec.mass if spec.carrier is None else spec.mass or _CARRIED_MASS
        colour = self._palette.colour(spec)
        centre = centre_of_mass(spec.solid) if mass > 0.0 else (0.0, 0.0, 0.0)
        index = build_solid(self.client, spec.solid, pose, mass=mass, centre=centre, colour=colour)
        body = Body(spec, index, centre, colour)
        self.bodies[spec.id] = self._bolted(body, pose) if spec.carrier is not None else body

    def fit(self, compartment: BodySpec, relative: Pose) -> None:
        """Says where in the body that it belongs to a compartment is."""
        self.compartments[compartment.id] = (compartment, relative)

    def standing(self) -> list[tuple[BodySpec, Pose]]:
        """Returns all bodies and compartments, with where they really are in the map."""
        compartments = [spec for spec, _ in self.compartments.values() if spec.place in self.bodies]
        return [(spec, self.pose(spec.id)) for spec in (*[b.spec for b in self.bodies.values()], *compartments)]

    def remove(self, body_id: str) -> None:
        """Takes a body away.

        Raises:
            UnknownName: There is no such body.
        """
        body = self.body(body_id)
        if body.constraint is not None:
            self.client.removeConstraint(body.constraint)
        self.client.removeBody(body.index)
        del self.bodies[body_id]

    def move(self, body_id: str, pose: Pose) -> None:
        """Puts a body somewhere else in the map, at rest.

        Raises:
            UnknownName: There is no such body.
            UsageError: The body is bolted to a robot.
        """
        body = self.body(body_id)
        if body.constraint is not None:
            raise UsageError(f"'{body_id}' is bolted to '{body.spec.carrier}' and moves with it only")
        body.place(self.client, pose)

    def body(self, body_id: str) -> Body:
        """Returns a body.

        Raises:
            UnknownName: There is no such body.
        """
        if body_id not in self.bodies:
            raise UnknownName("body", body_id, self.bodies)
        return self.bodies[body_id]

    def pose(self, body_id: str) -> Pose:
        """Returns where a body or compartment really is in the map.

        Raises:
            UnknownName: There is no such body.
        """
        if body_id in self.compartments:
            compartment, relative = self.compartments[body_id]
            return self.pose(str(compartment.place)) @ relative
        return self.body(body_id).pose(self.client)

    def state(self) -> SceneState:
        """Returns what a renderer needs to show this very moment."""
        looks = tuple(
            Look(body_id, body.spec.solid, body.colour, body.pose(self.client)) for body_id, body in self.bodies.items()
        )
        return SceneState(looks, {robot.spec.id: robot.posture() for robot in self.robots})

    def state_bytes(self) -> bytes:
        """Returns the exact state of all joints and bodies."""
        values = list(itertools.chain.from_iterable(robot.motion() for robot in self.robots))
        for body in self.bodies.values():
            values.extend(itertools.chain(*self.client.getBasePositionAndOrientation(body.index)))
            values.extend(itertools.chain(*self.client.getBaseVelocity(body.index)))
        return struct.pack(f"<{len(values)}d", *values)

    def _bolted(self, body: Body, pose: Pose) -> Body:
        """Fixes a body to the base that carries it, and lets the two pass through each other."""
        robot = next(robot for robot in self.robots if robot.base.spec.id == body.spec.carrier)
        link = robot.joints.link("base_link")
        client = self.client
        # The constraint's frames are relative to the centres of mass of both.
        platform = client.getLinkState(robot.body, link, computeForwardKinematics=True)
        mounted = Pose(platform[0], platform[1]).inverse() @ pose @ Pose(body.centre)
        frames = (mounted.position, (0.0, 0.0, 0.0), mounted.orientation, (0.0, 0.0, 0.0, 1.0))
        bolt = client.createConstraint(robot.body, link, body.index, -1, client.JOINT_FIXED, (0.0, 0.0, 0.0), *frames)
        client.changeConstraint(bolt, maxForce=_BOLT_FORCE)
        client.setCollisionFilterPair(robot.body, body.index, link, -1, 0)
        return replace(body, constraint=bolt)


def _set_up(client: Client, period: float) -> None:
    client.setGravity(0.0, 0.0, -_GRAVITY)
    client.setTimeStep(period)
    client.setPhysicsEngineParameter(
        numSolverIterations=50,
        # Contact points kept over a longer distance keep their direction while the robot turns: held parts then stick
        # to a finger that opens.
        contactBreakingThreshold=0.001,
        deterministicOverlappingPairs=1,
    )

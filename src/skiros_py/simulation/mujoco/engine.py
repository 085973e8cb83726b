"""MuJoCo as a physics engine of the simulation port."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from skiros_py.errors import DescriptionError, DeviceError, UnknownName, UsageError
from skiros_py.geometry import Array, Pose, Solid
from skiros_py.ports.simulation import FLOOR, Colour, Contact, RayHit, Surface, Twist, Vector, Wrench
from skiros_py.simulation.models import add_solid, pose_of, quaternion
from skiros_py.simulation.mujoco.motors import Motors
from skiros_py.simulation.mujoco.robot import MujocoRobot, vector
from skiros_py.simulation.renderer import RenderedWorld

_GRAVITY = 9.81  # [m/s²]
_LONGEST_STEP = 0.0025  # [s]; with longer ones a part creeps out of the gripper that swings it
_BODIES = 1  # collision group of bodies and floor; each robot has one of its own
_GROUPS = 30
_FRICTION, _SPINNING, _ROLLING = 0.5, 0.005, 1e-4
_AS_THE_ENGINE_HAS_IT = Surface()
_ORIGIN = Pose()
_STATE = mujoco.mjtState.mjSTATE_INTEGRATION
_SHOWN = mujoco.mjtState.mjSTATE_QPOS | mujoco.mjtState.mjSTATE_QVEL | mujoco.mjtState.mjSTATE_MOCAP_POS


@dataclass(slots=True)
class Body:
    """A body in the world.

    Attributes:
        solid: Its shape.
        mass: [kg].
        colour: For pictures.
        link: The link, by its name in the model, that it is attached to; empty where it is free.
    """

    solid: Solid
    mass: float
    colour: Colour
    link: str = ""


@dataclass(frozen=True)
class _State:
    """A saved state: the bodies that were there, MuJoCo's state, and that of the motors."""

    bodies: tuple[str, ...]
    values: Array
    motors: tuple[Array, ...]


class MujocoEngine(RenderedWorld[Body, MujocoRobot]):
    """A :class:`skiros_py.ports.simulation.Engine`.

    Bodies without mass are MuJoCo's mocap bodies: they stay where they are put, and collide with what moves only.
    Adding and removing compiles the model again, which changes all numbers in it; names stay.

    Args:
        period: Length of one step [s].
        gui: Open a window: there is none.

    Attributes:
        period: Length of one step [s].
        spec: The model as it is described; changes count from :meth:`recompile` on.
        model: The compiled model.
        data: Its state.
        motors: The motors of all joints.

    Raises:
        UsageError: A window is wanted.
    """

    name = "mujoco"

    def __init__(self, *, period: float, gui: bool = False) -> None:
        super().__init__()
        if gui:
            raise UsageError(
                "the simulation with MuJoCo has no window; watch it in the web pages or in recorded pictures, "
                "or simulate with another engine"
            )
        self.period = period
        self._substeps = max(1, math.ceil(period / _LONGEST_STEP - 1e-9))
        self.motors = Motors(period, self._substeps)
        self.spec = mujoco.MjSpec()
        option = self.spec.option
        option.timestep = period / self._substeps
        option.gravity = (0.0, 0.0, -_GRAVITY)
        option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        # Contacts that hold by friction: the cone as it is, and iterations that take out what is left of slipping.
        option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        option.impratio = 10.0
        option.noslip_iterations = 10
        floor = self.spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0.0, 0.0, 1.0])
        floor.contype, floor.conaffinity = _BODIES, 0x7FFFFFFF
        self.set_contact(floor, _AS_THE_ENGINE_HAS_IT)
        self._owners: dict[str, tuple[str, str]] = {"world": (FLOOR, "")}
        self._watched: dict[str, None] = {}  # links whose reactions are measured
        self.model = self.spec.compile()
        self.data = mujoco.MjData(self.model)
        self._look_up()

    def step(self) -> None:
        """Simulates one period."""
        for action in self._before_step:
            action()
        for substep in range(self._substeps):
            self.motors.drive(self.model, self.data, substep)
            for robot in self.robots.values():
                robot.share_softness()
            mujoco.mj_step(self.model, self.data)
        self.motors.end_step(self.data)
        self.data.xfrc_applied[:] = 0.0
        self.refresh()

    def refresh(self) -> None:
        """Computes what belongs to the state: MuJoCo leaves poses, velocities and inertias from before its step."""
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_comVel(self.model, self.data)
        mujoco.mj_makeM(self.model, self.data)
        mujoco.mj_rne(self.model, self.data, 0, self.data.qfrc_bias)

    def recompile(self) -> None:
        """Lets changes of the description count; the state is kept.

        Raises:
            DescriptionError: Something in it cannot be.
        """
        try:
            self.model, self.data = self.spec.recompile(self.model, self.data)
        except ValueError as error:
            raise DescriptionError(f"MuJoCo: {error}") from error
        self._look_up()
        mujoco.mj_forward(self.model, self.data)  # contacts are as they were

    def _look_up(self) -> None:
        """Finds everything in a model that has been compiled again."""
        model = self.model
        self._numbers = {model.body(number).name: number for number in range(model.nbody)}
        owners = [self._owners[name] for name in self._numbers]
        self._of_geom: list[tuple[str, str]] = [owners[body] for body in model.geom_bodyid]
        self.motors.look_up(model)

    # ------------------------------------------------------------------ what is in the world

    def add_robot(self, name: str, urdf: Path, pose: Pose = _ORIGIN) -> MujocoRobot:
        """Loads a robot with its root link fixed at a pose."""
        self._require_free(name)
        robot = MujocoRobot(self, name, urdf, pose, 2 << len(self.robots) % _GROUPS)
        self.robots[name] = robot
        self.motors.add([f"{name}/{joint}" for joint in robot.joint_names])
        self._owners |= {robot.body_name(link): (name, link) for link in robot.link_names}
        self.recompile()
        return robot

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
        moves = mass > 0.0
        body = self.spec.worldbody.add_body(name=name, pos=pose.position, quat=quaternion(pose), mocap=not moves)
        if moves:
            body.add_freejoint()
        add_solid(body, solid, mass=mass, contype=_BODIES, conaffinity=0x7FFFFFFF)
        for geom in body.geoms:
            self.set_contact(geom, surface)
        self.bodies[name] = Body(solid, mass, colour)
        self._owners[name] = (name, "")
        self.recompile()

    def set_contact(self, geom: Any, surface: Surface) -> None:
        """Describes how a geom touches others; of two, the greater friction counts. Stiff enough not to creep."""
        stated = (surface.lateral, surface.spinning, surface.rolling)
        geom.friction = [
            standard if value is None else value
            for value, standard in zip(stated, (_FRICTION, _SPINNING, _ROLLING), strict=True)
        ]
        geom.condim = 6 if surface.rolling else 4
        geom.solref = (2.0 * self.spec.option.timestep, 1.0)

    def remove_body(self, name: str) -> None:
        """Removes a body, and its attachment to a link."""
        if self._body(name).link:
            self._loosen(name)
        self.spec.delete(self.spec.body(name))
        del self.bodies[name], self._owners[name]
        self.recompile()

    def move_body(self, name: str, pose: Pose) -> None:
        """Puts a body to a pose, at rest."""
        self._body(name)
        body, data = self.model.body(name), self.data
        if body.mocapid[0] >= 0:
            data.mocap_pos[body.mocapid[0]], data.mocap_quat[body.mocapid[0]] = pose.position, quaternion(pose)
        else:
            first, speed = self.model.jnt_qposadr[body.jntadr[0]], body.dofadr[0]
            data.qpos[first : first + 7] = (*pose.position, *quaternion(pose))
            data.qvel[speed : speed + 6] = 0.0
        self.refresh()

    def attach(self, body: str, robot: str, link: str) -> None:
        """Fixes a body with mass to a link, where it is now; it no longer collides with that link."""
        attached, to = self._body(body), self._robot(robot).body_name(link)
        if attached.mass <= 0.0 or attached.link:
            raise UsageError(f"'{body}' has no mass, or is attached already: it cannot be attached to '{link}'")
        mounted = self.body_pose(to).inverse() @ self.body_pose(body)
        weld = self.spec.add_equality(
            name=_attachment(body),
            type=mujoco.mjtEq.mjEQ_WELD,
            objtype=mujoco.mjtObj.mjOBJ_BODY,
            name1=to,
            name2=body,
            solref=(2.0 * self.spec.option.timestep, 1.0),
        )
        weld.data[:11] = (0.0, 0.0, 0.0, *mounted.position, *quaternion(mounted), 1.0)
        self.spec.add_exclude(name=_attachment(body), bodyname1=to, bodyname2=body)
        attached.link = to
        self.recompile()

    def detach(self, body: str) -> None:
        """Releases an attached body."""
        if not self._body(body).link:
            raise UnknownName("attached body", body, [name for name, one in self.bodies.items() if one.link])
        self._loosen(body)
        self.recompile()

    def _loosen(self, body: str) -> None:
        self.spec.delete(self.spec.equality(_attachment(body)))
        self.spec.delete(self.spec.exclude(_attachment(body)))
        self.bodies[body].link = ""

    def couple(self, first: str, second: str, ratio: float) -> None:
        """Couples two joints, by their names in the model: the second moves by ``ratio`` times what the first does."""
        coupling = self.spec.add_equality(
            type=mujoco.mjtEq.mjEQ_JOINT,
            objtype=mujoco.mjtObj.mjOBJ_JOINT,
            name1=second,
            name2=first,
            solref=(2.0 * self.spec.option.timestep, 1.0),
        )
        first_at, second_at = self.data.joint(first).qpos[0], self.data.joint(second).qpos[0]
        coupling.data[:2] = (second_at - ratio * first_at, ratio)
        self.recompile()

    # ------------------------------------------------------------------ what physics says

    def pose(self, body: str) -> Pose:
        """Returns the pose of a body's solid frame."""
        self._body(body)
        return self.body_pose(body)

    def poses(self) -> Mapping[str, Pose]:
        """Returns the current poses of all bodies."""
        return {name: self.body_pose(name) for name in self.bodies}

    def body_pose(self, name: str) -> Pose:
        """Returns the pose of a body or link, by its name in the model."""
        number = self._numbers[name]
        return pose_of(self.data.xpos[number].tolist(), self.data.xquat[number].tolist())

    def twist(self, body: str) -> Twist:
        """Returns the velocity of a body's centre of mass."""
        self._body(body)
        return self.velocity(body, mujoco.mjtObj.mjOBJ_BODY)

    def velocity(self, name: str, frame: Any) -> Twist:
        """Returns the velocity of a frame (mjOBJ_BODY: the centre of mass) of a body or link of the model."""
        both = np.zeros(6)
        mujoco.mj_objectVelocity(self.model, self.data, frame, self._numbers[name], both, 0)
        return Twist(vector(both[3:]), vector(both[:3]))

    def contacts(self, name: str, link: str | None = None) -> tuple[Contact, ...]:
        """Returns the contacts of a body or robot after the last step."""
        wanted = (name, "") if name in self.bodies and not link else (self._robot(name).name, link)
        if link is not None and wanted[1]:
            self.robots[name].body_name(link)
        touching, found = self.data.contact, []
        force = np.zeros(6)
        for number, pair in enumerate(touching.geom.tolist()):
            for first, second, sign in ((*pair, -1.0), (*reversed(pair), 1.0)):  # MuJoCo's normal is towards the second
                own, other = self._of_geom[first], self._of_geom[second]
                if own == wanted or (wanted[1] is None and own[0] == name):
                    mujoco.mj_contactForce(self.model, self.data, number, force)
                    point, normal = vector(touching.pos[number]), vector(sign * touching.frame[number, :3])
                    depth = -float(touching.dist[number])
                    found.append(Contact(own[0], own[1], other[0], other[1], point, normal, depth, float(force[0])))
        return tuple(found)

    def cast_rays(self, starts: Array, ends: Array) -> tuple[RayHit | None, ...]:
        """Returns what each ray meets first."""
        starts, ways = np.asarray(starts, float), np.subtract(ends, starts)
        lengths = np.linalg.norm(ways, axis=1)
        rays = np.ascontiguousarray(ways / np.maximum(lengths, 1e-12)[:, None])
        geoms, distances, normals = np.full(len(rays), -1, np.int32), np.zeros(len(rays)), np.zeros(rays.shape)
        same = bool((starts == starts[:1]).all())
        for batch in [slice(None)] if same else [slice(n, n + 1) for n in range(len(rays))]:
            if len(rays):
                self._cast(starts[batch][0], rays[batch], geoms[batch], distances[batch], normals[batch], lengths.max())
        fractions = distances / np.maximum(lengths, 1e-12)
        points = starts + fractions[:, None] * ways
        return tuple(
            RayHit(*self._of_geom[geom], fraction, vector(point), vector(normal))
            if geom >= 0 and fraction <= 1.0
            else None
            for geom, fraction, point, normal in zip(geoms.tolist(), fractions.tolist(), points, normals, strict=True)
        )

    def _cast(
        self, start: Array, rays: Array, geoms: NDArray[np.int32], distances: Array, normals: Array, reach: float
    ) -> None:
        out = geoms, distances, normals.reshape(-1), len(rays), float(reach)
        mujoco.mj_multiRay(self.model, self.data, start, rays.reshape(-1), None, True, -1, *out)

    def apply_wrench(self, name: str, wrench: Wrench, *, at: Vector | None = None, link: str = "") -> None:
        """Applies a wrench during the next step."""
        body = name if name in self.bodies and not link else self._robot(name).body_name(link)
        number = self._numbers[body]
        arm = np.zeros(3) if at is None else np.subtract(at, self.data.xipos[number])
        self.data.xfrc_applied[number, :3] += wrench.force
        self.data.xfrc_applied[number, 3:] += np.add(wrench.torque, np.cross(arm, wrench.force))

    def reaction(self, name: str) -> Wrench:
        """Returns what a link, by its name in the model, gets through its joint; zeros at the first call."""
        if name not in self._watched:
            self._watched[name] = None
            self.spec.body(name).add_site(name=name)
            for kind in (mujoco.mjtSensor.mjSENS_FORCE, mujoco.mjtSensor.mjSENS_TORQUE):
                self.spec.add_sensor(
                    name=f"{name} {kind.name}", type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=name
                )
            self.recompile()
            return Wrench()
        force, torque = (
            vector(self.data.sensor(f"{name} {kind.name}").data)
            for kind in (mujoco.mjtSensor.mjSENS_FORCE, mujoco.mjtSensor.mjSENS_TORQUE)
        )
        return Wrench(force, torque)

    def look_at(self, target: Vector, distance: float) -> None:
        """Does nothing: there is no window."""

    # ------------------------------------------------------------------ state

    def state_bytes(self) -> bytes:
        """Returns the exact state of all joints and bodies."""
        return self._state(_SHOWN).tobytes()

    def save(self) -> object:
        """Returns the state of all that is in the world now."""
        return _State(tuple(self.bodies), self._state(_STATE), self.motors.save())

    def _state(self, parts: int) -> Array:
        values = np.empty(mujoco.mj_stateSize(self.model, parts))
        mujoco.mj_getState(self.model, self.data, values, parts)
        return values

    def restore(self, state: object) -> None:
        """Goes back to a saved state; the same bodies and robots must be there."""
        match state:
            case _State(bodies, values, motors) if bodies == tuple(self.bodies):
                mujoco.mj_setState(self.model, self.data, values, _STATE)
                mujoco.mj_forward(self.model, self.data)  # contacts are those of this state, too
                mujoco.mj_setState(self.model, self.data, values, _STATE)
                self.motors.restore(motors)
            case _:
                raise DeviceError("this state was saved with other bodies in the world")


def _attachment(body: str) -> str:
    return f"attachment of {body}"

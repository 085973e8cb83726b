"""A small kitting cell, and an inverse kinematics of its own, so that these tests need no motion planner."""

import dataclasses
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pybullet
import pytest

from skiros_py.devices.arm import ArmSpec
from skiros_py.devices.camera import CameraSpec
from skiros_py.devices.gripper import GripperSpec
from skiros_py.devices.localiser import LocaliserSpec
from skiros_py.devices.mobile_base import BaseSpec
from skiros_py.geometry import Array, Pose, Primitive, Solid
from skiros_py.ports.cell import BodySpec, CellSpec, RobotSpec
from skiros_py.ports.kinematics import write_robot_urdf
from skiros_py.simulation.cell import SimulatedCell

EDGE = 0.48  # where the table begins ahead of a docked robot's base frame [m]
TOP = 0.5
ORIGIN = Pose()
HOME = (-1.5708, -0.6, 0.0, -2.4, 0.0, 1.9, 0.7854)
INNER, WALL, WALL_HEIGHT = 0.140, 0.006, 0.033


def _box(x: float, y: float, z: float, at: tuple[float, float, float]) -> Primitive:
    return Primitive("box", (x, y, z), Pose(at))


def _lying(radius: float, length: float, at: tuple[float, float, float]) -> Primitive:
    return Primitive("cylinder", (radius, length), Pose.of(*at, pitch=math.pi / 2))


STARTER = Solid(
    (
        _box(0.118, 0.030, 0.020, (0.0, 0.0, 0.010)),
        _lying(0.0245, 0.118, (0.0, 0.0, 0.030)),
        _lying(0.013, 0.022, (0.046, 0.0, 0.056)),
    )
)
ALTERNATOR = Solid(
    (
        Primitive("cylinder", (0.030, 0.060), Pose((0.0, 0.0, 0.030))),
        Primitive("cylinder", (0.014, 0.012), Pose((0.0, 0.0, 0.066))),
    )
)
COMPRESSOR = Solid((_box(0.098, 0.049, 0.052, (0.0, 0.0, 0.026)), _box(0.042, 0.049, 0.022, (0.028, 0.0, 0.063))))
RELAY_BOX = Solid.box(0.059, 0.040, 0.054)


@dataclasses.dataclass(frozen=True)
class PartType:
    """A type of part: shape, mass [kg], height at which it is grasped [m], width there [m]."""

    name: str
    solid: Solid
    mass: float
    grasp_height: float
    width: float

    def body(self, pose: Pose | None, place: str | None = None, body_id: str = "part") -> BodySpec:
        return BodySpec(body_id, self.name, self.solid, self.mass, pose, place)


PARTS = {
    part.name: part
    for part in (
        PartType("Starter", STARTER, 0.8, 0.032, 0.049),
        PartType("Alternator", ALTERNATOR, 0.9, 0.045, 0.060),
        PartType("Compressor", COMPRESSOR, 0.7, 0.045, 0.049),
        PartType("RelayBox", RELAY_BOX, 0.25, 0.032, 0.040),
    )
}


def tray() -> Solid:
    outer = 2 * INNER + 3 * WALL
    blocks = [_box(outer, outer, WALL, (0.0, 0.0, WALL / 2))]
    for step in (-1, 0, 1):
        at, height = step * (INNER + WALL), WALL + WALL_HEIGHT / 2
        blocks.append(_box(WALL, outer, WALL_HEIGHT, (at, 0.0, height)))
        blocks.append(_box(outer, WALL, WALL_HEIGHT, (0.0, at, height)))
    return Solid(tuple(blocks))


def kit(pose: Pose, *, place: str | None = None, carrier: str | None = None) -> tuple[BodySpec, ...]:
    """A kit with compartments kit_0 (back right) to kit_3 (front left)."""
    half = (INNER + WALL) / 2
    room = Solid.box(INNER, INNER, WALL_HEIGHT)
    regions = [
        BodySpec(f"kit_{n}", "Compartment", room, pose=pose @ Pose((x, y, WALL)), place="kit", compartment=True)
        for n, (x, y) in enumerate([(-half, -half), (-half, half), (half, -half), (half, half)])
    ]
    return (BodySpec("kit", "Kit", tray(), pose=pose, place=place, carrier=carrier), *regions)


def table(body_id: str, pose: Pose) -> BodySpec:
    top = _box(0.60, 0.80, 0.03, (0.0, 0.0, TOP - 0.015))
    leg = TOP - 0.03
    legs = [_box(0.05, 0.05, leg, (x, y, leg / 2)) for x in (-0.27, 0.27) for y in (-0.37, 0.37)]
    return BodySpec(body_id, "Table", Solid((top, *legs)), pose=pose, support=(0.28, 0.38), support_height=TOP)


def robot(start: Pose = ORIGIN) -> RobotSpec:
    outline = ((-0.525, -0.305), (0.345, -0.305), (0.345, 0.305), (-0.525, 0.305))
    fov = math.radians(56.0)
    return RobotSpec(
        "robot",
        "mobile_panda",
        (
            BaseSpec("base", start, outline, 0.8, 1.2, 0.8, 1.6),
            LocaliserSpec("localiser"),
            ArmSpec("arm", tuple(f"panda_joint{n}" for n in range(1, 8)), "tcp", HOME),
            GripperSpec("gripper", ("panda_finger_joint1", "panda_finger_joint2"), "arm", 0.08, 70.0),
            CameraSpec("camera", "camera_optical", 320, 240, fov, 0.05, 2.0, 0.001, 0.1),
        ),
    )


def cell_spec(*bodies: BodySpec, start: Pose = ORIGIN) -> CellSpec:
    """A table in front of the robot, and what else is given."""
    return CellSpec((table("table", Pose((EDGE + 0.30, 0.0, 0.0))), *bodies), (robot(start),))


@pytest.fixture(scope="session")
def kitting() -> SimpleNamespace:
    return SimpleNamespace(
        EDGE=EDGE, TOP=TOP, HOME=HOME, PARTS=PARTS, WALL=WALL, kit=kit, table=table, robot=robot, cell_spec=cell_spec
    )


@pytest.fixture
def make_cell() -> Iterator[Callable[..., SimulatedCell]]:
    cells = []

    def make(spec: CellSpec, seed: int = 1, *, cameras: bool = False, **options: Any) -> SimulatedCell:
        if not cameras:
            blind = (tuple(d for d in r.devices if not isinstance(d, CameraSpec)) for r in spec.robots)
            robots = (dataclasses.replace(r, devices=devices) for r, devices in zip(spec.robots, blind, strict=True))
            spec = dataclasses.replace(spec, robots=tuple(robots))
        cells.append(SimulatedCell(spec, seed=seed, **options))
        return cells[-1]

    yield make
    for cell in cells:
        cell.close()


class ArmIk:
    """Damped least squares on the same model file, from the robot's base frame."""

    def __init__(self, directory: Path) -> None:
        self._client = pybullet.connect(pybullet.DIRECT)
        urdf = str(write_robot_urdf("mobile_panda", directory))
        self._robot = pybullet.loadURDF(urdf, useFixedBase=True, physicsClientId=self._client)
        count = pybullet.getNumJoints(self._robot, physicsClientId=self._client)
        infos = [pybullet.getJointInfo(self._robot, n, physicsClientId=self._client) for n in range(count)]
        self._arm = [info[0] for info in infos if info[1].decode().startswith("panda_joint") and info[2] == 0]
        self._movable = [info[0] for info in infos if info[2] != pybullet.JOINT_FIXED]
        self._columns = [self._movable.index(joint) for joint in self._arm]
        self._links = {info[12].decode(): info[0] for info in infos}
        self._lower = np.array([infos[joint][8] for joint in self._arm]) + 0.01
        self._upper = np.array([infos[joint][9] for joint in self._arm]) - 0.01

    def close(self) -> None:
        pybullet.disconnect(self._client)

    def pose(self, positions: Array, link: str = "tcp") -> Pose:
        for joint, position in zip(self._arm, positions, strict=True):
            pybullet.resetJointState(self._robot, joint, position, physicsClientId=self._client)
        state = pybullet.getLinkState(
            self._robot, self._links[link], computeForwardKinematics=True, physicsClientId=self._client
        )
        return Pose(state[4], state[5])

    def solve(self, goal: Pose, start: Array) -> Array:
        """The joint angles of a pose of the tool; starts anew near ``start`` a few times."""
        rng = np.random.default_rng(0)
        q = np.asarray(start, dtype=float)
        for _ in range(20):
            for _ in range(200):
                error = self._error(goal, q)
                if np.linalg.norm(error) < 2e-4:
                    return q
                q = np.clip(q + np.clip(self._step(q, error), -0.2, 0.2), self._lower, self._upper)
            q = np.clip(start + rng.normal(size=7) * 0.5, self._lower, self._upper)
        raise AssertionError(f"the test asks for a pose that cannot be reached: {goal}")

    def _error(self, goal: Pose, q: Array) -> Array:
        now, then = self.pose(q).matrix(), goal.matrix()
        turn = sum(np.cross(now[:3, axis], then[:3, axis]) for axis in range(3)) / 2
        return np.concatenate([then[:3, 3] - now[:3, 3], turn])

    def _step(self, q: Array, error: Array) -> Array:
        joints = [pybullet.getJointState(self._robot, n, physicsClientId=self._client)[0] for n in self._movable]
        zeros = [0.0] * len(joints)
        blocks = pybullet.calculateJacobian(
            self._robot, self._links["tcp"], [0.0] * 3, joints, zeros, zeros, physicsClientId=self._client
        )
        jacobian = np.vstack([np.array(block)[:, self._columns] for block in blocks])
        return jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + 1e-4 * np.eye(6), error)


@pytest.fixture(scope="session")
def ik(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ArmIk]:
    solver = ArmIk(tmp_path_factory.mktemp("ik"))
    yield solver
    solver.close()

"""A robot, tables, kits and parts as the motion planners meet them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from skiros_py.devices.arm import ArmSpec
from skiros_py.devices.gripper import GripperSpec
from skiros_py.devices.mobile_base import BaseSpec
from skiros_py.geometry import Pose, Primitive, Solid
from skiros_py.motion.pinocchio.arm_motion import ArmMotion
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.motion import Held, JointMove, LineMove, MotionPlan, MotionRequest, Obstacle, PoseMove, Route

FOOTPRINT = ((-0.525, -0.305), (0.345, -0.305), (0.345, 0.305), (-0.525, 0.305))
HOME = (-1.5708, -0.6, 0.0, -2.4, 0.0, 1.9, 0.7854)
EDGE = 0.22 + 0.26  # x of the near edge of a docked table in the base frame [m]


@dataclass(frozen=True)
class Part:
    solid: Solid
    grasp_height: float
    width: float


def _lying(radius: float, length: float, x: float, z: float) -> Primitive:
    return Primitive("cylinder", (radius, length), Pose.of(x, 0.0, z, pitch=math.pi / 2))


def _box(x: float, y: float, z: float, at: tuple[float, float, float]) -> Primitive:
    return Primitive("box", (x, y, z), Pose(at))


PARTS = {
    "starter": Part(
        Solid(
            (_box(0.118, 0.03, 0.02, (0, 0, 0.01)), _lying(0.0245, 0.118, 0, 0.03), _lying(0.013, 0.022, 0.046, 0.056))
        ),
        0.032,
        0.049,
    ),
    "alternator": Part(
        Solid(
            (
                Primitive("cylinder", (0.03, 0.06), Pose((0, 0, 0.03))),
                Primitive("cylinder", (0.014, 0.012), Pose((0, 0, 0.066))),
            )
        ),
        0.045,
        0.060,
    ),
    "compressor": Part(
        Solid((_box(0.098, 0.049, 0.052, (0, 0, 0.026)), _box(0.042, 0.049, 0.022, (0.028, 0, 0.063)))), 0.045, 0.049
    ),
    "relay": Part(Solid.box(0.059, 0.040, 0.054), 0.032, 0.040),
}


def table(height: float, name: str = "table", pose: Pose | None = None) -> Obstacle:
    legs = [_box(0.04, 0.04, height - 0.04, (x, y, (height - 0.04) / 2)) for x in (-0.27, 0.27) for y in (-0.37, 0.37)]
    solid = Solid((_box(0.6, 0.8, 0.04, (0, 0, height - 0.02)), *legs))
    return Obstacle(name, solid, pose or Pose((EDGE + 0.3, 0.0, 0.0)))


def kit(pose: Pose) -> Obstacle:
    outer = 2 * 0.140 + 3 * 0.006
    walls = [
        _box(*size, (*at, 0.006 + 0.0165))
        for k in (-0.146, 0.0, 0.146)
        for size, at in (((0.006, outer, 0.033), (k, 0.0)), ((outer, 0.006, 0.033), (0.0, k)))
    ]
    return Obstacle("kit", Solid((_box(outer, outer, 0.006, (0, 0, 0.003)), *walls)), pose)


def compartments(pose: Pose) -> list[Pose]:
    return [pose @ Pose((x, y, 0.006)) for x in (-0.073, 0.073) for y in (-0.073, 0.073)]


def down(x: float, y: float, z: float, yaw: float) -> Pose:
    return Pose.of(x, y, z, roll=math.pi, yaw=yaw)


def grasp(part: Pose, height: float, yaw: float, touching: frozenset[str], approach: float = 0.12) -> Route:
    above, at = part @ down(0, 0, height + approach, yaw), part @ down(0, 0, height, yaw)
    return PoseMove(above), LineMove(at, 0.15, touching), LineMove(above, 0.25, touching)


def pick(
    part: str, pose: Pose, height: float, *, yaws: tuple[float, ...] = (0.0, math.pi), seed: int = 0
) -> MotionRequest:
    model = PARTS[part]
    routes = tuple(grasp(pose, model.grasp_height, yaw, frozenset({"part", "table"})) for yaw in yaws)
    obstacles = (table(height), Obstacle("part", model.solid, pose))
    return MotionRequest("arm", HOME, Pose(), routes, obstacles, seed=seed)


def place(part: str, compartment: Pose, obstacles: tuple[Obstacle, ...], seed: int = 0) -> MotionRequest:
    model = PARTS[part]
    target, ids = compartment @ Pose((0, 0, 0.004)), frozenset({"kit", "table"})
    yaws = (0.0, math.pi)
    routes = tuple((*grasp(target, model.grasp_height, yaw, ids), JointMove(HOME)) for yaw in yaws)
    held = Held(model.solid, Pose.of(0, 0, model.grasp_height, roll=math.pi))
    return MotionRequest("arm", HOME, Pose(), routes, obstacles, held, model.width, seed=seed)


def seconds(plan: MotionPlan) -> float:
    return sum(len(leg.positions) - 1 for leg in plan.legs) / 200.0


def random_part(rng: np.random.Generator, height: float) -> Pose:
    x, y, yaw = rng.uniform((EDGE + 0.10, -0.20, -math.pi), (EDGE + 0.36, 0.20, math.pi))
    return Pose.of(x, y, height, yaw=yaw)


@pytest.fixture(scope="session")
def robot() -> RobotSpec:
    arm = ArmSpec("arm", tuple(f"panda_joint{i}" for i in range(1, 8)), "tcp", HOME)
    gripper = GripperSpec("gripper", ("panda_finger_joint1", "panda_finger_joint2"), "arm", 0.08, 70.0)
    base = BaseSpec("base", Pose(), FOOTPRINT, 0.8, 1.2, 0.6, 1.5)
    return RobotSpec("robot", "mobile_panda", (base, arm, gripper))


@pytest.fixture(scope="session")
def motion(robot: RobotSpec) -> ArmMotion:
    return ArmMotion(robot)


@pytest.fixture(scope="session")
def bench() -> SimpleNamespace:
    """The bodies and requests above, for test modules (which cannot import a conftest)."""
    names = (
        "EDGE",
        "FOOTPRINT",
        "HOME",
        "PARTS",
        "compartments",
        "down",
        "grasp",
        "kit",
        "pick",
        "place",
        "random_part",
    )
    return SimpleNamespace(**{name: globals()[name] for name in (*names, "seconds", "table")})

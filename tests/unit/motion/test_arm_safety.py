"""What the planner calls clear is clear in the eyes of a physics engine, at every sample."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import coal
import numpy as np
import pinocchio as pin
import pybullet
import pytest

from skiros_py.devices.arm import ArmSpec
from skiros_py.devices.gripper import GripperSpec
from skiros_py.geometry import Array, Pose, Solid
from skiros_py.motion.pinocchio.arm_model import ArmModel
from skiros_py.motion.pinocchio.arm_motion import ArmMotion
from skiros_py.motion.pinocchio.collision import CollisionScene, self_collision_pairs
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.kinematics import write_robot_urdf
from skiros_py.ports.motion import Held, MotionPlan, MotionRequest, Obstacle


class BulletJudge:
    """Measures distances between the robot and obstacles with PyBullet."""

    def __init__(self, urdf: Path) -> None:
        self._bodies: list[tuple[int, str]] = []
        self.client = pybullet.connect(pybullet.DIRECT)
        self._robot = pybullet.loadURDF(str(urdf), useFixedBase=True, physicsClientId=self.client)
        count = pybullet.getNumJoints(self._robot, physicsClientId=self.client)
        info = [pybullet.getJointInfo(self._robot, i, physicsClientId=self.client) for i in range(count)]
        self._joints = {entry[1].decode(): entry[0] for entry in info}
        self._links = {entry[0]: entry[12].decode() for entry in info}

    def add(self, obstacle: Obstacle) -> None:
        for block in obstacle.solid.primitives:
            if block.kind == "box":
                shape = {"shapeType": pybullet.GEOM_BOX, "halfExtents": [length / 2 for length in block.size]}
            else:
                shape = {"shapeType": pybullet.GEOM_CYLINDER, "radius": block.size[0], "height": block.size[1]}
            pose = obstacle.pose @ block.pose
            shape_id = pybullet.createCollisionShape(**shape, physicsClientId=self.client)
            body = pybullet.createMultiBody(
                0, shape_id, -1, pose.position, pose.orientation, physicsClientId=self.client
            )
            self._bodies.append((body, obstacle.id))

    def pose(self, q: Array, gap: float) -> None:
        values = {f"panda_joint{i + 1}": angle for i, angle in enumerate(q)}
        values |= {"panda_finger_joint1": gap / 2, "panda_finger_joint2": gap / 2}
        for name, value in values.items():
            pybullet.resetJointState(self._robot, self._joints[name], float(value), physicsClientId=self.client)

    def touched(self) -> set[tuple[str, str]]:
        """Returns pairs of robot link and obstacle that overlap, the base left out."""
        pairs = set()
        for body, name in self._bodies:
            for point in pybullet.getClosestPoints(self._robot, body, 0.0, physicsClientId=self.client):
                link = self._links.get(point[3], "")
                if link.startswith("panda") and link != "panda_link0" and point[8] < 0.0:
                    pairs.add((link, name))
        return pairs


@pytest.fixture
def judge(robot: RobotSpec, tmp_path: Path) -> Iterator[BulletJudge]:
    judge = BulletJudge(write_robot_urdf(robot.model, tmp_path))
    yield judge
    pybullet.disconnect(judge.client)


def contacts(judge: BulletJudge, request: MotionRequest, plan: MotionPlan) -> list[tuple[int, tuple[str, str]]]:
    """Returns what is touched though the move does not allow it: (move, (link, obstacle))."""
    for obstacle in request.obstacles:
        judge.add(obstacle)
    seen = []
    for number, (move, leg) in enumerate(zip(request.routes[plan.route], plan.legs, strict=True)):
        for q in leg.positions[::2]:
            judge.pose(q, request.gap)
            allowed = getattr(move, "touching", frozenset())
            for link, obstacle in judge.touched():
                gripper = link in {"panda_hand", "panda_leftfinger", "panda_rightfinger"}
                if not (gripper and obstacle in allowed):
                    seen.append((number, (link, obstacle)))
    return seen


def test_nothing_is_touched_while_picking_between_posts(
    motion: ArmMotion, bench: SimpleNamespace, judge: BulletJudge
) -> None:
    request = bench.pick("compressor", Pose.of(0.72, 0.12, 0.5, yaw=0.6), 0.5, seed=4)
    posts = tuple(Obstacle(f"post{y}", Solid.box(0.05, 0.05, 1.2), Pose((0.42, y, 0.0))) for y in (-0.35, 0.35))
    request = MotionRequest("arm", bench.HOME, Pose(), request.routes, (*request.obstacles, *posts), seed=4)

    plan = motion.plan(request)

    assert isinstance(plan, MotionPlan)
    assert contacts(judge, request, plan) == []


def test_nothing_is_touched_on_the_way_to_the_deck_and_back(
    motion: ArmMotion, bench: SimpleNamespace, judge: BulletJudge
) -> None:
    at = Pose((-0.27, 0.0, 0.35))
    rack = Obstacle("rack", Solid.box(0.4, 0.4, 1.2), Pose((0.2, 0.8, 0.0)))
    request = bench.place("starter", bench.compartments(at)[0], (bench.kit(at), bench.table(0.5), rack), seed=2)

    plan = motion.plan(request)

    assert isinstance(plan, MotionPlan)
    assert contacts(judge, request, plan) == []


def test_the_contact_check_detects_contacts(motion: ArmMotion, bench: SimpleNamespace, judge: BulletJudge) -> None:
    request = bench.pick("relay", Pose.of(0.7, 0.0, 0.5), 0.5)
    plan = motion.plan(request)
    assert isinstance(plan, MotionPlan)
    higher = MotionRequest("arm", bench.HOME, Pose(), request.routes, (bench.table(0.60, name="other"),))

    assert any(name == "other" for _, (_, name) in contacts(judge, higher, plan))


def test_planner_and_physics_engine_agree_on_random_postures(
    motion: ArmMotion, bench: SimpleNamespace, judge: BulletJudge, robot: RobotSpec, tmp_path: Path
) -> None:
    arm = ArmModel(write_robot_urdf(robot.model, tmp_path), robot.of(ArmSpec)[0], robot.of(GripperSpec))
    obstacles = (bench.table(0.5), bench.kit(Pose((-0.27, 0.0, 0.35))))
    checker = CollisionScene(arm, (), Pose(), obstacles, None, 0.06).checker(0.0)
    for obstacle in obstacles:
        judge.add(obstacle)
    rng, differ, touching = np.random.default_rng(2), 0, 0

    for _ in range(500):
        q = rng.uniform(arm.lower, arm.upper)
        judge.pose(q, 0.06)
        differ += checker.clear(q) == bool(judge.touched())
        touching += bool(judge.touched())

    assert touching >= 20
    assert differ <= 3  # hulls of the physics engine have a margin of about a millimetre


def test_the_hull_of_each_link_reaches_as_far_as_its_mesh_to_all_sides(robot: RobotSpec, tmp_path: Path) -> None:
    urdf = write_robot_urdf(robot.model, tmp_path)
    arm = ArmModel(urdf, robot.of(ArmSpec)[0], robot.of(GripperSpec))
    full = pin.buildModelFromUrdf(str(urdf))
    meshes = pin.buildGeomFromUrdf(full, str(urdf), pin.GeometryType.COLLISION, package_dirs=[str(urdf.parent)])
    hulls = {hull.name: hull.geometry for hull in arm.collision_shapes(0.0).geometryObjects}
    sides = np.random.default_rng(1).normal(size=(50, 3))
    off, there = {}, coal.Transform3s()

    for mesh in meshes.geometryObjects:
        if hasattr(mesh.geometry, "vertices"):
            points = np.asarray(mesh.geometry.vertices())
            for side in sides / np.linalg.norm(sides, axis=1)[:, None]:
                wall, found = coal.Halfspace(side, -1.0), coal.DistanceResult()
                coal.distance(hulls[mesh.name], there, wall, there, coal.DistanceRequest(), found)
                error = abs(found.min_distance - float((points @ side).min() + 1.0))
                off[mesh.name] = max(off.get(mesh.name, 0.0), error)

    assert len(off) >= 10
    assert {name: error for name, error in off.items() if error > 1e-4} == {}


def test_the_same_scene_checks_the_same_pairs_every_time(
    bench: SimpleNamespace, robot: RobotSpec, tmp_path: Path
) -> None:
    arm = ArmModel(write_robot_urdf(robot.model, tmp_path), robot.of(ArmSpec)[0], robot.of(GripperSpec))
    pairs = self_collision_pairs(arm)
    obstacles = (bench.table(0.5), bench.kit(Pose((-0.27, 0.0, 0.35))))
    held = Held(Solid.box(0.05, 0.04, 0.05), Pose())

    seen = []
    for _ in range(20):
        contacts = CollisionScene(arm, pairs, Pose(), obstacles, held, 0.06).contacts
        seen.append([(contact.link, contact.other) for contact in contacts])

    moving = [f"panda_link{i}" for i in range(1, 8)] + ["panda_hand", "panda_leftfinger", "panda_rightfinger"]
    boxes = sum(len(obstacle.solid.primitives) for obstacle in obstacles)
    assert len([pair for pair in seen[0] if pair[1] in {"table", "kit"}]) == boxes * (len(moving) + 1)
    assert {link for link, other in seen[0] if other == "kit"} == {*moving, "what it holds"}
    assert all(pairs == seen[0] for pairs in seen)

"""RRT-Connect of roboplan, in one scene that is kept: only what has changed in it is put in and out.

roboplan knows no margins, so what stands there is made thicker; and it collides meshes where the checks of the platform
collide their hulls, so what it finds is judged by those, too. What it cannot do is searched in Python: constraints, and
starts that are too near to something.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations, pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from xml.sax.saxutils import quoteattr

import numpy as np
from roboplan.core import Box, Cylinder, JointConfiguration, Scene, loadUrdfSceneDescription
from roboplan.rrt import RRT, RRTOptions

from skiros_py.devices.arm import ArmSpec
from skiros_py.devices.gripper import GripperSpec
from skiros_py.geometry import Array, Pose, Primitive
from skiros_py.motion.pinocchio.arm_model import arm_model
from skiros_py.motion.pinocchio.collision import self_collision_pairs
from skiros_py.motion.sampling import RrtConnect
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.kinematics import write_robot_urdf
from skiros_py.ports.motion import SearchTask

_GROUP = "arm"
_STEP = 0.03  # [rad] between two postures that it checks
_BRANCH = 3.0  # [rad] greatest length of one branch
_TRIES = ((0.0, 1.0), (0.0, 1.0), (0.005, 0.5))
"""For each try, with a seed of its own: how much thicker things are than by the margin [m], the share of the step."""
_COLOUR = np.ones(4)

Placed = tuple[str, Primitive, Pose]
"""On which frame a block is, which one, and where."""


class RoboplanRrt:
    """A :class:`~skiros_py.ports.motion.SamplingPlanner`.

    Args:
        robot: The robot.
        arm: Its arm.
    """

    name = "rrt-connect"

    def __init__(self, robot: RobotSpec, arm: ArmSpec) -> None:
        model = arm_model(robot, arm)
        self._arm = arm
        self._fallback = RrtConnect()
        fingers = [joint for one in robot.of(GripperSpec) if one.arm == arm.id for joint in one.joints]
        with TemporaryDirectory(prefix="skiros-roboplan-") as directory:
            urdf = write_robot_urdf(robot.model, Path(directory))
            bare = Path(directory) / "arm.urdf"
            _without_other_joints(urdf, {*arm.joints, *fingers}).write(bare)
            self._scene = Scene(_GROUP, loadUrdfSceneDescription(bare, [urdf.parent]))
        shapes = model.collision_shapes(0.0).geometryObjects
        frames = {str(one.name): str(model.model.frames[one.parentFrame].name) for one in shapes}
        checked = {frozenset((frames[one], frames[other])) for one, other in self_collision_pairs(model)}
        self._links = sorted(set(frames.values()))
        self._standing = sorted({frames[str(one.name)] for one in shapes if one.parentJoint == 0})
        self._on_tip = sorted({frames[str(one.name)] for one in shapes if one.parentJoint == model.model.njoints - 1})
        unchecked = [pair for pair in combinations(self._links, 2) if frozenset(pair) not in checked]
        self._scene.importSrdf(_srdf(_GROUP, arm.joints, unchecked))
        self._fingers = [joint for joint in fingers if joint in self._scene.getJointNames()]
        self._there: dict[str, Placed] = {}

    def search(self, task: SearchTask) -> Sequence[Array] | None:
        """Returns way points from start to goal, or None."""
        if not task.constrained:
            for number, (thicker, share) in enumerate(_TRIES):
                path = self.first_path(replace(task, seed=task.seed + number), thicker, share)
                if path is None:
                    break
                if all(task.straight(one, other) for one, other in pairwise(path)):
                    return path
        return self._fallback.search(task)

    def first_path(self, task: SearchTask, thicker: float = 0.0, share: float = 1.0) -> list[Array] | None:
        """Returns what roboplan finds, not judged yet; None for nothing.

        Args:
            task: The task.
            thicker: How much thicker than by the margin things are made [m].
            share: Share of the usual step.
        """
        self._furnish(task, task.margin + thicker)
        options = RRTOptions(
            group_name=_GROUP,
            max_nodes=task.iterations,
            max_connection_distance=_BRANCH,
            collision_check_step_size=_STEP * share,
            max_planning_time=0.0,
            rrt_connect=True,
        )
        search = RRT(self._scene, options)
        search.setRngSeed(task.seed % 2**31)
        joints = list(self._arm.joints)
        try:
            path = search.plan(JointConfiguration(joints, task.start), JointConfiguration(joints, task.goal))
        except RuntimeError:  # an end in collision, or no path within so many nodes
            return None
        return None if path is None else [np.array(posture) for posture in path.positions]

    def _furnish(self, task: SearchTask, margin: float) -> None:
        """Makes the scene what a task says."""
        wanted = {
            f"{one.id}#{number}#{margin}": ("universe", block, one.pose @ block.pose)
            for one in task.obstacles
            for number, block in enumerate(one.solid.primitives)
        }
        held = task.held.solid.primitives if task.held else ()
        for number, block in enumerate(held):
            assert task.held is not None
            wanted[f"held#{number}#{margin}"] = self._arm.tip, block, task.held.pose @ block.pose
        for name in [name for name, placed in self._there.items() if wanted.get(name) != placed]:
            self._scene.removeGeometry(name)
            del self._there[name]
        for name, placed in wanted.items():
            if name not in self._there:
                self._add(name, placed, margin)
        positions = self._scene.getCurrentJointPositions().copy()
        if self._fingers:
            positions[self._scene.getJointPositionIndices(self._fingers)] = task.gap / 2.0
        self._scene.setJointPositions(positions)

    def _add(self, name: str, placed: Placed, margin: float) -> None:
        frame, block, pose = placed
        if block.kind == "box":
            box = Box(*(length + 2.0 * margin for length in block.size))
            self._scene.addBoxGeometry(name, frame, box, pose.matrix(), _COLOUR)
        else:
            cylinder = Cylinder(block.size[0] + margin, block.size[1] + 2.0 * margin)
            self._scene.addCylinderGeometry(name, frame, cylinder, pose.matrix(), _COLOUR)
        rigid = self._on_tip if frame == self._arm.tip else self._standing
        for other in (*rigid, *(known for known, (on, _, _) in self._there.items() if on == frame)):
            self._scene.setCollisions(name, other, False)
        self._there[name] = placed


def _without_other_joints(urdf: Path, kept: set[str]) -> ET.ElementTree[ET.Element]:
    """Returns a description in which all joints but some are fixed."""
    tree = ET.parse(urdf)  # noqa: S314 - a robot model that is installed
    for joint in tree.getroot().findall("joint"):
        if joint.get("name") not in kept:
            joint.set("type", "fixed")
    return tree


def _srdf(group: str, joints: Sequence[str], unchecked: Sequence[tuple[str, str]]) -> str:
    """Returns the group of joints to plan for, and the pairs of links that are not checked."""
    members = "".join(f"<joint name={quoteattr(joint)}/>" for joint in joints)
    pairs = "".join(
        f'<disable_collisions link1={quoteattr(one)} link2={quoteattr(other)} reason="Never"/>'
        for one, other in unchecked
    )
    return f'<robot name="robot"><group name={quoteattr(group)}>{members}</group>{pairs}</robot>'

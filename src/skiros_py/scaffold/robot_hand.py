"""The hand of a robot from a URDF: two fingers that slide, the tool point between them, a camera beside them."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from skiros_py.errors import UsageError
from skiros_py.geometry import Array, Pose
from skiros_py.scaffold.robot_model import Gripper, Joint, RobotDescription
from skiros_py.scaffold.urdf_elements import add_box, add_frame, add_shape, join, numbers

TOOL, CAMERA = "tcp", "camera_optical"
"""Names of the links of the tool point and the camera."""
_BEYOND = 0.01
"""How far the fingers reach beyond the tip [m]."""
_PAD = 0.04
"""Length of the fingers from their ends that counts as pads [m]."""
_LEAST_GAP = 0.01
_THICKEST = 0.05
"""What a finger counts as thick at most [m]: the rest is its linkage."""
_LEANING, _THIN = sorted(range(-75, 76, 5), key=abs), 1.1
"""Angles by which fingers that turn are straightened [°], and how much thicker than the thinnest they may stay.

Open ones lean outwards: as thick as they are wide apart they would fit into nothing."""
_FORCE = 40.0
"""Assumed finger force [N]."""
_LEAST_FORCE, _MOST_FORCE = 5.0, 500.0
"""A model that states less or more means no finger force [N]."""
_CAMERA_AWAY, _CAMERA_BEHIND = 0.035, 0.09
"""Distance of the camera from what is widest beside the tool point, and from its height [m]."""


@dataclass(frozen=True, slots=True)
class Hand:
    """The gripper as its platform describes it.

    Attributes:
        joints: Its joints.
        max_gap: [m].
        max_force: [N].
        size: Width, thickness and reach beyond the tip of its fingers [m].
        notes: What was assumed.
    """

    joints: tuple[str, ...]
    max_gap: float
    max_force: float
    size: tuple[float, float, float]
    notes: list[str] = field(default_factory=list)


def add_hand(
    urdf: ET.Element,
    model: RobotDescription,
    gripper: Gripper,
    last: Joint,
    points: Mapping[str, Array],
    called: Callable[[str], str],
) -> Hand:
    """Adds what a gripper lacks: the joints of its fingers, shapes that end at their pads, tool point and camera.

    Args:
        urdf: The robot, with the links of the model.
        model: What the manufacturer's files say.
        gripper: The gripper there.
        last: The last joint of the arm.
        points: Points around the shapes of each link of the model, in its frame [m].
        called: Gives the name of a link of the model in the robot.

    Raises:
        UsageError: The fingers are none.
    """
    if not gripper.fingers:
        return _plain_gripper(urdf, model, last, points, called)
    palm, names = gripper.palm, gripper.fingers
    stand = _Stand(model, gripper, points)
    gap, across = stand.gap, stand.across
    if gap < _LEAST_GAP:
        raise UsageError(f"{' and '.join(names)} open only {gap * 1000.0:.0f} mm: choose others by --gripper")
    if not gripper.sliding:
        leaning = [_Stand(model, gripper, points, math.radians(angle)) for angle in _LEANING]
        thinnest = min(one.thickness for one in leaning)
        stand = next(one for one in leaning if one.thickness <= _THIN * thinnest)
    tool = stand.tool
    for link, pose, group, sign in zip(names, stand.poses, stand.groups, (1.0, -1.0), strict=True):
        closed = pose.copy()
        closed[:3, 3] -= sign * stand.gap / 2.0 * across
        joint = join(urdf, model.above[link].name, "prismatic", called(palm), called(link), closed)
        _slide(joint, pose[:3, :3].T @ (sign * across), gap / 2.0)
        for below in model.subtree(link):
            other = _link(urdf, called(below))
            for one in other.findall("collision"):
                other.remove(one)
        to_link = np.linalg.inv(pose) @ tool
        for low, high in _finger_boxes((group - tool[:3, 3]) @ tool[:3, :3], stand.gap / 2.0, sign):
            at = to_link @ Pose.of(*(low + high) / 2.0).matrix()
            add_shape(_link(urdf, called(link)), "collision", at, "box", {"size": numbers(high - low)})
    force, notes = _force(model, gripper)
    if not gripper.sliding:
        notes.append(
            "the fingers turn or stand still in the model: they slide here, straightened, and the links that move"
            f" them stand still (gap {gap * 1000.0:.0f} mm)"
        )
    around = np.concatenate([*stand.groups, points[palm], np.zeros((1, 3))])
    notes.append(_add_frames(urdf, called(palm), tool, around))
    joints = tuple(model.above[link].name for link in names)
    return Hand(joints, gap, force, (stand.width, min(stand.thickness, _THICKEST), _BEYOND), notes)


class _Stand:
    """Two fingers in the frame of the palm [m], as they stand when open, or each turned inwards by an angle [rad]."""

    def __init__(
        self, model: RobotDescription, gripper: Gripper, points: Mapping[str, Array], lean: float = 0.0
    ) -> None:
        names, positions = gripper.fingers, gripper.positions
        self.poses = [model.pose(link, positions, gripper.palm) for link in names]
        self.groups = [_rigid(model, points, link, at, positions) for link, at in zip(names, self.poses, strict=True)]
        lacking = [link for link, group in zip(names, self.groups, strict=True) if not len(group)]
        if lacking:
            raise UsageError(f"the fingers {', '.join(lacking)} have no shape: choose others by --gripper")
        ahead, self.across = _axes(*self.groups)
        for pose, group, sign in zip(self.poses, self.groups, (1.0, -1.0), strict=True):
            turn = Pose.turn(*(sign * lean * np.cross(self.across, ahead))).matrix()[:3, :3]
            group[:] = (group - pose[:3, 3]) @ turn.T + pose[:3, 3]
            pose[:3, :3] = turn @ pose[:3, :3]
        end = max(float((group @ ahead).max()) for group in self.groups)
        pads = [group[group @ ahead > end - _PAD] for group in self.groups]
        if not all(map(len, pads)):
            raise UsageError("of the fingers one is much shorter than the other: choose others by --gripper")
        inner = float((pads[0] @ self.across).min()), float((pads[1] @ self.across).max())
        self.gap = inner[0] - inner[1]
        side = np.cross(self.across, ahead)
        along = np.concatenate(pads) @ side
        self.thickness, self.width = (max(float(np.ptp(pad @ axis)) for pad in pads) for axis in (self.across, side))
        self.tool = np.eye(4)
        self.tool[:3, :3] = np.column_stack([side, self.across, ahead])
        self.tool[:3, 3] = self.tool[:3, :3] @ [(along.min() + along.max()) / 2.0, sum(inner) / 2.0, end - _BEYOND]


def _axes(first: Array, second: Array) -> tuple[Array, Array]:
    """Returns where fingers point and in which direction they open, the nearest axes of their palm."""
    both = np.concatenate([first, second])
    middle = (both.max(axis=0) + both.min(axis=0)) / 2.0
    across = _nearest_axis(first.mean(axis=0) - second.mean(axis=0))
    return _nearest_axis(middle * (across == 0.0)), across


def _nearest_axis(vector: Array) -> Array:
    axis = int(np.argmax(np.abs(vector)))
    return np.asarray(np.eye(3)[axis] * (1.0 if vector[axis] >= 0.0 else -1.0))


def _rigid(
    model: RobotDescription, points: Mapping[str, Array], link: str, pose: Array, positions: Mapping[str, float]
) -> Array:
    """Returns points of a link and of all that it carries [m], at a pose of the link."""
    found = [points[link] @ pose[:3, :3].T + pose[:3, 3]]
    for joint in model.below[link]:
        below = pose @ joint.transform(model.position(joint, positions))
        found.append(_rigid(model, points, joint.child, below, positions))
    return np.concatenate(found)


def _finger_boxes(points: Array, half_gap: float, sign: float) -> list[tuple[Array, Array]]:
    """Returns two boxes around a finger, its pad and what is behind: their corners in the frame of the tool [m]."""
    above = _BEYOND - _PAD
    found = []
    for part, floor, top in ((points[:, 2] > above, above, math.inf), (points[:, 2] <= above, -math.inf, above)):
        if not part.any():
            continue
        low, high = points[part].min(axis=0), points[part].max(axis=0)
        low[2], high[2] = max(low[2], floor), min(high[2], top)
        inner, edge = low if sign > 0.0 else high, sign * half_gap
        inner[1] = edge if top == math.inf else sign * max(sign * inner[1], half_gap)
        if (high - low).min() >= 0.001:
            found.append((low, high))
    return found


def _force(model: RobotDescription, gripper: Gripper) -> tuple[float, list[str]]:
    for joint in (model.joints[name] for name in gripper.joints):
        limit = joint.element.find("limit")
        stated = 0.0 if limit is None else float(limit.get("effort", "0"))
        if joint.type == "prismatic" and _LEAST_FORCE < stated < _MOST_FORCE:
            return stated, []
    return _FORCE, [f"no finger force is stated, assumed {_FORCE:.0f} N"]


def _plain_gripper(
    urdf: ET.Element, model: RobotDescription, last: Joint, points: Mapping[str, Array], called: Callable[[str], str]
) -> Hand:
    """Mounts two sliding boxes on a palm at the end of the arm."""
    behind = np.concatenate([_rigid(model, points, last.child, np.eye(4), {}), np.zeros((1, 3))])
    ahead = _outward(behind, last)
    side = np.eye(3)[int(np.argmin(np.abs(ahead)))]
    side -= (side @ ahead) * ahead
    side /= np.linalg.norm(side)
    mount = np.eye(4)
    mount[:3, :3] = np.column_stack([side, np.cross(ahead, side), ahead])
    mount[:3, 3] = ahead * float((behind @ ahead).max())
    palm, names = "gripper_palm", []
    add_box(urdf, palm, 0.6, (0.06, 0.14, 0.06), (0.0, 0.0, 0.03))
    join(urdf, "gripper_mount", "fixed", called(last.child), palm, mount)
    for name, sign in (("left", 1.0), ("right", -1.0)):
        finger = f"gripper_{name}_finger"
        names.append(f"{finger}_joint")
        add_box(urdf, finger, 0.08, (0.022, 0.014, 0.08), (0.0, sign * 0.007, 0.04))
        joint = join(urdf, names[-1], "prismatic", palm, finger, Pose.of(0.0, 0.0, 0.06).matrix())
        _slide(joint, (0.0, sign, 0.0), 0.05)
    tool = Pose.of(0.0, 0.0, 0.14 - _BEYOND).matrix()
    notes = ["a plain parallel gripper of its own, opening 100 mm, is mounted at the end of the arm"]
    notes.append(_add_frames(urdf, palm, tool, np.array([[-0.03, -0.07, 0.0], [0.03, 0.07, 0.06]])))
    return Hand(tuple(names), 0.1, 60.0, (0.022, 0.014, _BEYOND), notes)


def _slide(joint: ET.Element, axis: Array | tuple[float, ...], travel: float) -> None:
    ET.SubElement(joint, "axis", xyz=numbers(axis))
    ET.SubElement(joint, "limit", lower="0", upper=f"{travel:.6g}", effort="120", velocity="0.2")


def _outward(points: Array, last: Joint) -> Array:
    """Returns the axis of the flange along which tools are mounted: that of the last joint, away from the arm."""
    axis = last.axis
    low, high = float((points @ axis).min()), float((points @ axis).max())
    if abs(high + low) > 0.2 * (high - low):
        return axis if high > -low else -axis
    behind = float(-(last.origin[:3, :3] @ axis) @ last.origin[:3, 3])
    return -axis if behind > 0.0 else axis


def _add_frames(urdf: ET.Element, palm: str, tool: Array, points: Array) -> str:
    """Adds the tool point, and a camera beside the fingers that looks past them; says where it is."""
    for name in (TOOL, CAMERA):
        add_frame(urdf, name)
    join(urdf, "tcp_joint", "fixed", palm, TOOL, tool)
    here = (points - tool[:3, 3]) @ tool[:3, :3]
    beside = here[here[:, 2] > -_CAMERA_BEHIND - 0.03]
    out = float((beside if len(beside) else here)[:, 0].max()) + _CAMERA_AWAY
    camera = Pose.of(out, 0.0, -_CAMERA_BEHIND, yaw=math.pi / 2.0).matrix()
    join(urdf, "camera_joint", "fixed", palm, CAMERA, tool @ camera)
    where = f"{out * 1000.0:.0f} mm beside the tool point, {_CAMERA_BEHIND * 1000.0:.0f} mm behind it"
    return f"a camera is proposed {where}, looking ahead"


def _link(urdf: ET.Element, name: str) -> ET.Element:
    return next(one for one in urdf.findall("link") if one.get("name") == name)

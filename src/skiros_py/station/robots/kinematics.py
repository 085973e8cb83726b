"""Where the tools of a robot are, and how far its joints go: read from the robot's model, quick enough for any thread.

Planners have libraries of their own for this; here it is for those who look on, whichever cell runs.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from skiros_py.devices.arm import ArmSpec
from skiros_py.errors import SkirosError
from skiros_py.geometry import Pose
from skiros_py.ports.models import write_robot_urdf

_BASE = "base_link"
_Quaternion = tuple[float, float, float, float]
_TURNS = ("revolute", "continuous")


@dataclass(frozen=True, slots=True)
class Joint:
    """One joint of a model.

    Attributes:
        name: Its name.
        kind: As URDF says it: "revolute", "prismatic", "fixed", ….
        parent: The link that it is on.
        origin: Where it is in the frame of that.
        axis: About or along which it moves.
        lower, upper: Its range [rad or m]; None where it has none.
        velocity: Greatest speed [rad/s or m/s]; None where nobody says.
    """

    name: str
    kind: str
    parent: str
    origin: Pose
    axis: tuple[float, float, float]
    lower: float | None
    upper: float | None
    velocity: float | None

    def pose(self, position: float) -> Pose:
        """Returns where what it moves is, in the frame of its parent [rad or m]."""
        if self.kind in _TURNS:
            half = position / 2.0
            x, y, z = (math.sin(half) * component for component in self.axis)
            return Pose(self.origin.position, _product(self.origin.orientation, (x, y, z, math.cos(half))))
        if self.kind == "prismatic":
            a, b, c, d = self.origin.orientation
            x, y, z = (position * component for component in self.axis)
            along = _product(_product((a, b, c, d), (x, y, z, 0.0)), (-a, -b, -c, d))
            x, y, z = (start + step for start, step in zip(self.origin.position, along[:3], strict=True))
            return Pose((x, y, z), self.origin.orientation)
        return self.origin


class RobotModel:
    """The joints of a robot.

    Args:
        joints: By the link that each moves.
    """

    def __init__(self, joints: Mapping[str, Joint]) -> None:
        self._joints = joints
        self._by_name = {joint.name: joint for joint in joints.values()}

    def joint(self, name: str) -> Joint | None:
        """Returns a joint; None where the model has none of that name."""
        return self._by_name.get(name)

    def below(self, link: str) -> tuple[tuple[str, Joint], ...]:
        """Returns the links that hang on a link, directly or not, each with the joint that moves it."""
        found: dict[str, Joint] = {}
        for child in self._joints:
            way = [child]
            while way[-1] != link and way[-1] in self._joints:
                way.append(self._joints[way[-1]].parent)
            if way[-1] == link:
                found |= {name: self._joints[name] for name in reversed(way[:-1])}
        return tuple(found.items())

    def tool(self, arm: ArmSpec, positions: Sequence[float]) -> Pose | None:
        """Returns where an arm's tip is in the frame of the robot's base; None where they are not connected.

        Args:
            arm: The arm.
            positions: Its joint angles [rad].
        """
        at, pose, link = dict(zip(arm.joints, positions, strict=True)), Pose(), arm.tip
        while link != _BASE:
            joint = self._joints.get(link)
            if joint is None:
                return None
            pose, link = joint.pose(at.get(joint.name, 0.0)) @ pose, joint.parent
        return pose


@cache
def robot_model(name: str) -> RobotModel:
    """Reads a robot model.

    Raises:
        UnknownName: Nobody knows how to build it.
        SkirosError: A part of it is not installed.
    """
    with TemporaryDirectory(prefix="skiros-model-") as folder:
        root = ET.parse(write_robot_urdf(name, Path(folder))).getroot()  # noqa: S314 - written just now
    return RobotModel({_named(joint, "child", "link"): _joint(joint) for joint in root.iter("joint")})


@cache
def known_model(name: str) -> RobotModel | None:
    """Reads a robot model; None where it cannot be read: cells of plug-ins may have robots of their own."""
    try:
        return robot_model(name)
    except SkirosError:
        return None


def _joint(joint: ET.Element) -> Joint:
    limit = joint.find("limit")
    x, y, z = _triple(joint.find("axis"), "xyz", "1 0 0")
    length = math.hypot(x, y, z) or 1.0
    kind = joint.get("type", "")
    ranged = limit is not None and kind in ("revolute", "prismatic")
    return Joint(
        joint.get("name", ""),
        kind,
        _named(joint, "parent", "link"),
        _origin(joint.find("origin")),
        (x / length, y / length, z / length),
        _number(limit, "lower") if ranged else None,
        _number(limit, "upper") if ranged else None,
        _number(limit, "velocity"),
    )


def _product(one: _Quaternion, other: _Quaternion) -> _Quaternion:
    """Returns the rotation that does the other first; fifty times as quick as a library that takes whole arrays."""
    a, b, c, d = one
    x, y, z, w = other
    return (
        d * x + a * w + b * z - c * y,
        d * y - a * z + b * w + c * x,
        d * z + a * y - b * x + c * w,
        d * w - a * x - b * y - c * z,
    )


def _origin(element: ET.Element | None) -> Pose:
    roll, pitch, yaw = _triple(element, "rpy", "0 0 0")
    return Pose.of(*_triple(element, "xyz", "0 0 0"), roll=roll, pitch=pitch, yaw=yaw)


def _triple(element: ET.Element | None, key: str, default: str) -> tuple[float, float, float]:
    text = default if element is None else element.get(key, default)
    x, y, z = (float(word) for word in text.split())
    return x, y, z


def _number(element: ET.Element | None, key: str) -> float | None:
    text = None if element is None else element.get(key)
    return None if text is None else float(text)


def _named(joint: ET.Element, child: str, key: str) -> str:
    found = joint.find(child)
    return "" if found is None else found.get(key, "")

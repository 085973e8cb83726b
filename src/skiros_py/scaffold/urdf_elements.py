"""Elements of URDF files: what is written, and what is read of inertias."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Sequence

import numpy as np

from skiros_py.geometry import Array
from skiros_py.scaffold.robot_model import origin_of

_MOMENTS = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}


def add_shape(parent: ET.Element, tag: str, pose: Array, kind: str, size: dict[str, str]) -> None:
    """Adds a shape to a link: its tag ("collision" or "visual"), its pose there, its geometry and what that states."""
    shape = ET.SubElement(parent, tag)
    set_origin(shape, pose)
    ET.SubElement(ET.SubElement(shape, "geometry"), kind, size)


def add_frame(urdf: ET.Element, name: str) -> None:
    """Adds a link that is a frame and no body: engines want a mass of everything."""
    set_inertia(ET.SubElement(urdf, "link", name=name), 0.001, np.eye(3) * 1e-6, np.zeros(3))


def add_box(urdf: ET.Element, name: str, mass: float, size: Sequence[float], centre: Sequence[float]) -> None:
    """Adds a link that is a box, of a mass [kg] and a size [m] around a centre in its frame [m]."""
    link, pose = ET.SubElement(urdf, "link", name=name), np.eye(4)
    pose[:3, 3] = centre
    set_inertia(link, mass, box_inertia(mass, size), pose[:3, 3])
    for tag in ("collision", "visual"):
        add_shape(link, tag, pose, "box", {"size": numbers(size)})


def box_inertia(mass: float, size: Sequence[float] | Array) -> Array:
    """Returns the tensor of a box about its centre [kg m²]."""
    squares = np.square(size)
    return np.diag(mass / 12.0 * (squares.sum() - squares))


def inertia_of(link: ET.Element) -> tuple[float, Array, Array] | None:
    """Returns mass [kg], tensor [kg m²] and centre [m] as a link states them; None where it states none."""
    inertial = link.find("inertial")
    if inertial is None:
        return None
    mass, stated = inertial.find("mass"), inertial.find("inertia")
    tensor = np.zeros((3, 3))
    for key, (row, column) in _MOMENTS.items():
        tensor[row, column] = tensor[column, row] = float("0" if stated is None else stated.get(key, "0"))
    return 0.0 if mass is None else float(mass.get("value", "0")), tensor, origin_of(inertial)[:3, 3]


def is_absurd(mass: float, tensor: Array, centre: Array, points: Array) -> bool:
    """Returns whether no body of about that shape has such an inertia."""
    moments = np.linalg.eigvalsh(tensor)
    if mass <= 0.0 or moments[0] <= 0.0 or moments[2] > moments[0] + moments[1]:
        return True
    if not len(points):
        return False
    low, high = points.min(axis=0), points.max(axis=0)
    radius = float(np.linalg.norm(high - low))
    outside = (centre < low - radius) | (centre > high + radius)
    return bool(moments[2] > 2.0 * mass * radius**2 or outside.any())


def set_inertia(link: ET.Element, mass: float, tensor: Array, centre: Array) -> None:
    """States the inertia of a link: mass [kg], tensor about the centre [kg m²], centre in its frame [m]."""
    for old in link.findall("inertial"):
        link.remove(old)
    inertial = ET.Element("inertial")
    ET.SubElement(inertial, "origin", xyz=numbers(centre))
    ET.SubElement(inertial, "mass", value=f"{mass:.5g}")
    ET.SubElement(inertial, "inertia", {key: f"{float(tensor[at]):.5g}" for key, at in _MOMENTS.items()})
    link.insert(0, inertial)


def join(urdf: ET.Element, name: str, kind: str, parent: str, child: str, pose: Array) -> ET.Element:
    """Adds a joint, at a pose in its parent link."""
    joint = ET.SubElement(urdf, "joint", name=name, type=kind)
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    set_origin(joint, pose)
    return joint


def set_origin(element: ET.Element, pose: Array) -> None:
    """States the pose of an element that states none yet."""
    turn = pose[:3, :3]
    level = math.hypot(turn[0, 0], turn[1, 0])
    roll, yaw = math.atan2(turn[2, 1], turn[2, 2]), math.atan2(turn[1, 0], turn[0, 0])
    if level < 1e-7:  # roll and yaw turn about one axis
        roll, yaw = math.atan2(-turn[1, 2], turn[1, 1]), 0.0
    angles = (roll, math.atan2(-turn[2, 0], level), yaw)
    ET.SubElement(element, "origin", xyz=numbers(pose[:3, 3]), rpy=numbers(angles))


def numbers(values: Sequence[float] | Array) -> str:
    """Returns numbers as attributes have them."""
    return " ".join(f"{float(value) + 0.0:.9g}" for value in values)

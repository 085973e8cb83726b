"""Robot models that the adapters know how to build, written as URDF files.

A model is composed here and nowhere else, so that the simulation, the kinematics and the collision checker load the
same file. Meshes stay in the installed package they come from: the file refers to them by absolute path, therefore it
is written anew for each run into a directory of that run and never stored.

The model "mobile_panda"::

    map ─base_x─base_y─base_yaw─ base_link ─┬─ wheel_left, wheel_right
                                            └─ panda_link0 … panda_hand ─┬─ panda_leftfinger, panda_rightfinger
                                                                         ├─ tcp
                                                                         └─ camera_optical

``base_link`` is the footprint frame: on the floor, x forward, in the middle between the wheels.
"""

from __future__ import annotations

import importlib.util
import math
import xml.etree.ElementTree as ET
from collections.abc import Callable, Sequence
from pathlib import Path

from skiros_py.errors import DeviceError, FileError, UnknownName

__all__ = ["BASE_JOINTS", "BASE_LINK", "WHEEL_RADIUS", "WHEEL_TRACK", "write_robot_urdf"]

BASE_LINK = "base_link"
"""Footprint frame of a mobile base: on the floor, x forward, in the middle between the wheels."""

BASE_JOINTS = ("base_x", "base_y", "base_yaw")
"""Joints of a mobile base: where it is in the map [m, m, rad]."""

WHEEL_RADIUS = 0.10
"""Radius of the driving wheels of a mobile base [m]."""

WHEEL_TRACK = 0.52
"""Distance between the middles of the driving wheels of a mobile base [m]."""

_PLATFORM_HEIGHT = 0.35
_ARM_MOUNT = (0.22, 0.0, 0.40)
_TCP_OFFSET = 0.1034  # middle of the finger pads, from panda_hand along its z
_CAMERA_OFFSET = (0.07, 0.0, 0.03)
_FINGER_EFFORT = "70"  # continuous force of the Franka hand; the file's 20 is less than the hand is used with here

_GREY = (0.32, 0.35, 0.38)
_BLUE = (0.16, 0.36, 0.56)
_DARK = (0.12, 0.12, 0.13)
_YELLOW = (0.95, 0.75, 0.15)

Triple = tuple[float, float, float]


def write_robot_urdf(model: str, directory: Path) -> Path:
    """Composes a robot model and writes it as one URDF file.

    Args:
        model: Name of the model ("mobile_panda").
        directory: Where to write; it must exist and should belong to the run alone.

    Returns:
        Path of the file, ``directory / f"{model}.urdf"``.

    Raises:
        UnknownName: Nobody knows how to build that model.
        DeviceError: The package that holds the arm's description is not installed.
        FileError: The arm's description is not where its package should hold it.
    """
    if model not in _MODELS:
        raise UnknownName("robot model", model, _MODELS)
    robot = _MODELS[model]()
    ET.indent(robot)
    path = directory / f"{model}.urdf"
    ET.ElementTree(robot).write(path, encoding="utf-8", xml_declaration=True)
    return path


def _mobile_panda() -> ET.Element:
    robot = ET.Element("robot", name="mobile_panda")
    _add_base(robot)
    _add_panda(robot)
    _joint(robot, "panda_mount", "fixed", "base_link", "panda_link0", _ARM_MOUNT, rpy=(0.0, 0.0, math.pi / 2))
    _light_link(robot, "tcp")
    _joint(robot, "tcp_joint", "fixed", "panda_hand", "tcp", (0.0, 0.0, _TCP_OFFSET))
    _add_camera(robot)
    return robot


_MODELS: dict[str, Callable[[], ET.Element]] = {"mobile_panda": _mobile_panda}


def _add_base(robot: ET.Element) -> None:
    _link(robot, "map", 1.0, (0.01, 0.01, 0.01))
    along_x, along_y, about_z = BASE_JOINTS
    for name, parent, child, axis in (
        (along_x, "map", "base_x_carriage", (1.0, 0.0, 0.0)),
        (along_y, "base_x_carriage", "base_y_carriage", (0.0, 1.0, 0.0)),
    ):
        _link(robot, child, 1.0, (0.01, 0.01, 0.01))
        joint = _joint(robot, name, "prismatic", parent, child, axis=axis)
        ET.SubElement(joint, "limit", lower="-100", upper="100", effort="2000", velocity="2")
    _add_platform(robot)
    _joint(robot, about_z, "continuous", "base_y_carriage", "base_link", axis=(0.0, 0.0, 1.0))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        _add_wheel(robot, side, sign)


def _add_platform(robot: ET.Element) -> None:
    """Adds the platform: for collisions its whole outline, for the eye a body, a deck and the arm's socket."""
    link = _link(robot, "base_link", 80.0, (2.9, 5.3, 7.0), centre=(-0.09, 0.0, 0.18))
    _box(link, "collision", (0.82, 0.56, 0.31), (-0.09, 0.0, _PLATFORM_HEIGHT - 0.155))
    _box(link, "collision", (0.20, 0.20, 0.05), (_ARM_MOUNT[0], 0.0, 0.375))
    _box(link, "visual", (0.82, 0.46, 0.27), (-0.09, 0.0, 0.195), _GREY)
    _box(link, "visual", (0.82, 0.56, 0.02), (-0.09, 0.0, _PLATFORM_HEIGHT - 0.01), _BLUE)
    _box(link, "visual", (0.20, 0.20, 0.05), (_ARM_MOUNT[0], 0.0, 0.375), _DARK)


def _add_wheel(robot: ET.Element, side: str, sign: float) -> None:
    """Adds a wheel that turns for the eye: it has no collision shape, a spoke shows the turning."""
    link = _link(robot, f"wheel_{side}_link", 1.0, (0.005, 0.005, 0.005))
    visual = _shape(link, "visual", (0.0, 0.0, 0.0), _DARK, rpy=(math.pi / 2, 0.0, 0.0))
    ET.SubElement(visual, "cylinder", radius=str(WHEEL_RADIUS), length="0.04")
    _box(link, "visual", (0.15, 0.004, 0.03), (0.0, sign * 0.02, 0.0), _YELLOW)
    at = (0.0, sign * WHEEL_TRACK / 2, WHEEL_RADIUS)
    _joint(robot, f"wheel_{side}", "continuous", "base_link", f"wheel_{side}_link", at, axis=(0.0, 1.0, 0.0))


def _add_camera(robot: ET.Element) -> None:
    """Adds the camera's optical frame with a housing behind it, for the eye only."""
    link = _light_link(robot, "camera_optical")
    _box(link, "visual", (0.09, 0.025, 0.02), (0.0, 0.0, -0.012), _DARK)
    # x right and y down in the image: the image's upper edge is on the hand's +x side.
    _joint(robot, "camera_joint", "fixed", "panda_hand", "camera_optical", _CAMERA_OFFSET, rpy=(0.0, 0.0, math.pi / 2))


def _add_panda(robot: ET.Element) -> None:
    """Adds the Franka Panda of the pybullet_data package, its description mended for physics."""
    source = _panda_urdf()
    arm = ET.parse(source).getroot()  # noqa: S314 - a file of an installed package
    for element in arm:
        if "grasptarget" not in element.get("name", ""):  # a massless link; "tcp" replaces it
            _mend(element, source.parent)
            robot.append(element)


def _panda_urdf() -> Path:
    package = importlib.util.find_spec("pybullet_data")
    if package is None or package.origin is None:
        raise DeviceError("the model 'mobile_panda' needs the package pybullet_data: pip install pybullet")
    path = Path(package.origin).parent / "franka_panda" / "panda.urdf"
    if not path.is_file():
        raise FileError(path, "the installed pybullet_data does not hold the Panda's description; reinstall pybullet")
    return path


def _mend(element: ET.Element, folder: Path) -> None:
    """Mends one link or joint of the Panda's file in place.

    The file gives every link an inertia of 0.1 kg m², which makes light links and fingers sluggish, leaves one link
    without mass, and makes the fingertips soft, in which a held part turns.
    """
    for mesh in element.iter("mesh"):
        mesh.set("filename", str(folder / mesh.get("filename", "").removeprefix("package://")))
    finger = "finger" in element.get("name", "")
    for inertia in element.iter("inertia"):
        for axis in ("ixx", "iyy", "izz"):
            inertia.set(axis, "0.0001" if finger else "0.02")
    for mass in element.iter("mass"):
        mass.set("value", mass.get("value", "0") if float(mass.get("value", "0")) > 0.0 else "0.01")
    for part in [child for child in element if child.tag in ("contact", "mimic")]:
        element.remove(part)
    if finger:
        for limit in element.iter("limit"):
            limit.set("effort", _FINGER_EFFORT)


def _link(
    robot: ET.Element, name: str, mass: float, inertia: Triple, *, centre: Triple = (0.0, 0.0, 0.0)
) -> ET.Element:
    link = ET.SubElement(robot, "link", name=name)
    inertial = ET.SubElement(link, "inertial")
    ET.SubElement(inertial, "origin", xyz=_text(centre), rpy="0 0 0")
    ET.SubElement(inertial, "mass", value=str(mass))
    ixx, iyy, izz = map(str, inertia)
    ET.SubElement(inertial, "inertia", ixx=ixx, ixy="0", ixz="0", iyy=iyy, iyz="0", izz=izz)
    return link


def _light_link(robot: ET.Element, name: str) -> ET.Element:
    """Adds a link that only names a frame; physics engines dislike links without mass."""
    return _link(robot, name, 0.001, (1e-6, 1e-6, 1e-6))


def _joint(
    robot: ET.Element,
    name: str,
    kind: str,
    parent: str,
    child: str,
    at: Triple = (0.0, 0.0, 0.0),
    *,
    rpy: Triple = (0.0, 0.0, 0.0),
    axis: Triple | None = None,
) -> ET.Element:
    joint = ET.SubElement(robot, "joint", name=name, type=kind)
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    ET.SubElement(joint, "origin", xyz=_text(at), rpy=_text(rpy))
    if axis is not None:
        ET.SubElement(joint, "axis", xyz=_text(axis))
    return joint


def _box(link: ET.Element, use: str, size: Triple, at: Triple, colour: Triple | None = None) -> None:
    ET.SubElement(_shape(link, use, at, colour), "box", size=_text(size))


def _shape(
    link: ET.Element, use: str, at: Triple, colour: Triple | None, *, rpy: Triple = (0.0, 0.0, 0.0)
) -> ET.Element:
    shape = ET.SubElement(link, use)
    ET.SubElement(shape, "origin", xyz=_text(at), rpy=_text(rpy))
    geometry = ET.SubElement(shape, "geometry")
    if colour is not None:
        material = ET.SubElement(shape, "material", name="rgb_" + "_".join(f"{c:.2f}" for c in colour))
        ET.SubElement(material, "color", rgba=_text((*colour, 1.0)))
    return geometry


def _text(values: Sequence[float]) -> str:
    return " ".join(repr(value) for value in values)

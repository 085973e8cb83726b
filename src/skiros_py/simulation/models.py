"""Robot models and solids in MuJoCo's words: for its engine, and for the pictures of every engine."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import mujoco

from skiros_py.errors import DescriptionError
from skiros_py.geometry import Pose, Primitive, Solid
from skiros_py.ports.simulation import Colour

_VISUAL = 1  # group of what URDF files have for the eye
_UNSTATED = (0.5, 0.5, 0.5, 1.0)  # MuJoCo's colour of what has none
_SHAPES = {
    mujoco.mjtGeom.mjGEOM_BOX: "box",
    mujoco.mjtGeom.mjGEOM_CYLINDER: "cylinder",
    mujoco.mjtGeom.mjGEOM_SPHERE: "sphere",
}
_COMPILER = {
    "fusestatic": "false",
    "strippath": "false",
    "balanceinertia": "true",
    "boundmass": "0.001",
    "boundinertia": "0.000001",
}


@dataclass(frozen=True, slots=True)
class Visual:
    """What a link of a robot has for the eye.

    Attributes:
        link: The link.
        pose: Pose of the shape in the link's frame.
        kind: "box", "cylinder", "sphere" or "mesh".
        size: Sides of a box, radius and length of a cylinder, radius of a sphere [m]; factors of a mesh along its axes.
        file: The file of a mesh.
        colour: None where the model states none.
    """

    link: str
    pose: Pose
    kind: str
    size: tuple[float, ...]
    file: Path | None
    colour: Colour | None


def visuals_of(urdf: Path) -> Iterator[Visual]:
    """Yields what a robot model has for the eye.

    Raises:
        DescriptionError: It cannot be read, or a mesh is not there.
    """
    spec = robot_spec(urdf, visuals=True)
    meshes = {mesh.name: mesh for mesh in spec.meshes}
    for body in spec.bodies:
        for geom in body.geoms:
            if geom.group != _VISUAL:
                continue
            red, green, blue, opacity = map(float, geom.rgba)
            colour = (red, green, blue, opacity)
            kind, mesh, size = _SHAPES.get(geom.type, "mesh"), meshes.get(geom.meshname), geom.size
            sizes = {"box": 2.0 * size, "cylinder": (size[0], 2.0 * size[1]), "sphere": size[:1]}
            yield Visual(
                body.name,
                pose_of(geom.pos, geom.quat),
                kind,
                tuple(map(float, sizes[kind] if mesh is None else mesh.scale)),
                None if mesh is None else Path(mesh.file),
                None if colour == _UNSTATED else colour,
            )


def read_urdf(urdf: Path) -> ET.Element:
    """Reads a robot model; its meshes then have absolute paths.

    Raises:
        DescriptionError: It cannot be read, or a mesh is not there.
    """
    try:
        robot = ET.parse(urdf).getroot()  # noqa: S314 - an installed model
    except (OSError, ET.ParseError) as error:
        raise DescriptionError(f"{urdf}: the model cannot be read: {error}") from error
    gone = set()
    for mesh in robot.iter("mesh"):
        name = mesh.get("filename", "")
        file = urdf.parent / name.removeprefix("package://")
        if not file.is_file():
            gone.add(name)
        mesh.set("filename", str(file))
    if gone:
        raise DescriptionError(f"{urdf}: there is no mesh {', '.join(sorted(gone))} beside the model")
    return robot


class Softness(NamedTuple):
    """How a link gives way where something presses on it, however many points of it are touched.

    Attributes:
        stiffness: Force per depth [N/m].
        damping: Force per speed [N s/m].
    """

    stiffness: float
    damping: float


def soft_links(robot: ET.Element) -> dict[str, Softness]:
    """Returns how the links of a robot model give way that have a ``contact`` with stiffness and damping."""
    found = {}
    for link in robot.iter("link"):
        stated = [link.find(f"contact/{name}") for name in ("stiffness", "damping")]
        values = [float(one.get("value", "0")) for one in stated if one is not None]
        if len(values) == len(stated):
            found[link.get("name", "")] = Softness(*values)
    return found


def robot_spec(urdf: Path, *, visuals: bool) -> mujoco.MjSpec:
    """Returns a robot as a MuJoCo model of its own: every link is a body, also a fixed one.

    Args:
        urdf: The file.
        visuals: Keep what is meant for the eye, in the group :data:`VISUAL`.

    Raises:
        DescriptionError: It cannot be read, or a mesh is not there.
    """
    robot = read_urdf(urdf)
    for joint in robot.iter("joint"):
        for mimic in joint.findall("mimic"):  # joints are coupled by who drives them
            joint.remove(mimic)
    for extension in robot.findall("mujoco"):
        robot.remove(extension)
    compiler = {**_COMPILER, "discardvisual": str(not visuals).lower()}
    ET.SubElement(ET.SubElement(robot, "mujoco"), "compiler", compiler)
    try:
        return mujoco.MjSpec.from_string(ET.tostring(robot, encoding="unicode"))
    except ValueError as error:
        raise DescriptionError(f"{urdf}: {error}") from error


def attach_robot(spec: mujoco.MjSpec, robot: mujoco.MjSpec, name: str, pose: Pose) -> None:
    """Adds a robot to a model, its root link fixed at a pose in the map; all its names begin with its own and a "/"."""
    frame = spec.worldbody.add_frame(pos=pose.position, quat=quaternion(pose))
    spec.attach(robot, prefix=f"{name}/", frame=frame)


def add_solid(body: Any, solid: Solid, *, mass: float = 0.0, **options: Any) -> None:
    """Adds the primitives of a solid to a body of a model.

    Args:
        body: MuJoCo's specification of the body.
        solid: The shape.
        mass: Mass of all primitives together [kg], spread evenly over their volumes; overlaps count twice.
        **options: What MuJoCo is to know of each geom besides.
    """
    whole = sum(map(_volume, solid.primitives))
    for block in solid.primitives:
        box = block.kind == "box"
        size = [side / 2.0 for side in block.size] if box else [block.size[0], block.size[1] / 2.0, 0.0]
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX if box else mujoco.mjtGeom.mjGEOM_CYLINDER,
            size=size,
            pos=block.pose.position,
            quat=quaternion(block.pose),
            mass=mass * _volume(block) / whole,
            **options,
        )


def quaternion(pose: Pose) -> tuple[float, float, float, float]:
    """Returns an orientation as MuJoCo has it: w first."""
    x, y, z, w = pose.orientation
    return w, x, y, z


def pose_of(position: Any, orientation: Any) -> Pose:
    """Returns the pose of a position and an orientation with w first."""
    w, x, y, z = map(float, orientation)
    px, py, pz = map(float, position)
    return Pose((px, py, pz), (x, y, z, w))


def _volume(block: Primitive) -> float:
    if block.kind == "box":
        return math.prod(block.size)
    radius, length = block.size
    return math.pi * radius**2 * length

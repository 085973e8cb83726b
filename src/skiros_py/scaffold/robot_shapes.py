"""Shapes of a robot model: meshes are found and read, and those for collisions become simple."""

from __future__ import annotations

import copy
import math
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from skiros_py.errors import MissingExtra, UsageError
from skiros_py.geometry import Array, Pose
from skiros_py.ports.robot_files import installed_name
from skiros_py.scaffold.robot_model import RobotDescription, find_mesh, origin_of
from skiros_py.scaffold.urdf_elements import add_shape, numbers

_TIGHT = 1.05
"""A box or cylinder replaces a mesh if its volume is at most so many times that of the hull."""
_CORNERS = 60
"""Greatest number of corners of a hull."""
_THIN = 0.002
"""Least side of a box that replaces a flat mesh [m]."""
_SHOWN = 6
"""Number of missing meshes that are named."""
_READ_BY_ALL = (".stl", ".obj")
"""Formats that all engines read."""


class Shapes:
    """The shapes of a model.

    Args:
        model: The model.

    Attributes:
        points: Points around the shapes of each link, in its frame [m], shape (n, 3).
        notes: What was missing.
        texts: Meshes that are to be written, by file name.
        copied: Meshes that are to be copied, by file name.

    Raises:
        UsageError: None of its meshes are there.
        FileError: A mesh cannot be read.
        MissingExtra: The extra "physics", which reads meshes, is not installed.
    """

    def __init__(self, model: RobotDescription) -> None:
        self._model = model
        self._meshes: dict[Path, tuple[Array, Array]] = {}
        self._names: dict[tuple[str, Path, str], str] = {}
        self._gone: dict[str, None] = {}
        self.texts: dict[str, str] = {}
        self.copied: dict[str, Path] = {}
        self.notes: list[str] = []
        self.points = {
            link: np.concatenate([np.zeros((0, 3)), *map(self._corners, model.shapes(link))]) for link in model.links
        }
        for mesh in model.xml.iterfind("link/*/geometry/mesh"):
            self._file(mesh)
        if self._gone:
            more = len(self._gone) - _SHOWN
            names = ", ".join(list(self._gone)[:_SHOWN]) + (f" and {more} more" if more > 0 else "")
            if not any(map(len, self.points.values())):
                raise UsageError(f"{model.file}: none of its meshes are there, beside it or above: {names}")
            self.notes.append(f"missing meshes, left out: {names}")
        bare = [link for link in model.links if len(self.points[link]) and not model.links[link].findall("collision")]
        if bare:
            self.notes.append(f"links without shapes for collisions: visual ones serve for {', '.join(bare)}")

    def of(self, link: str) -> list[ET.Element]:
        """Returns a link's simple shapes for collisions, and its visual ones."""
        made = ET.Element("link")
        for one in self._model.shapes(link):
            self._add_collision(made, one)
        collisions = list(made)
        return [*collisions, *(one for v in self._model.links[link].findall("visual") for one in self._visual(v, made))]

    def _file(self, mesh: ET.Element) -> Path | None:
        name = mesh.get("filename", "")
        file = find_mesh(self._model.file, name)
        if file is None:
            self._gone[name] = None
        return file

    def _read(self, file: Path) -> tuple[Array, Array]:
        if file not in self._meshes:
            try:
                from skiros_py.motion.pinocchio.meshes import read_mesh
            except ImportError:
                raise MissingExtra("physics", "a robot from a URDF") from None
            self._meshes[file] = read_mesh(file)
        return self._meshes[file]

    def _corners(self, element: ET.Element) -> Array:
        """Returns points around a shape in the frame of its link; none of a mesh that is not there."""
        shape = element.find("geometry/*")
        if shape is None:
            return np.zeros((0, 3))
        if shape.tag == "mesh":
            file = self._file(shape)
            points = np.zeros((0, 3)) if file is None else self._read(file)[0] * _scale(shape)
        else:
            radius, length = (float(shape.get(key, "0")) for key in ("radius", "length"))
            sides = {"box": shape.get("size", "0 0 0").split(), "sphere": [2.0 * radius] * 3}
            half = np.array(sides.get(shape.tag, [2.0 * radius, 2.0 * radius, length]), dtype=float) / 2.0
            points = np.array(list(np.ndindex(2, 2, 2))) * 2.0 * half - half
        pose = origin_of(element)
        return np.asarray(points @ pose[:3, :3].T + pose[:3, 3])

    def _add_collision(self, link: ET.Element, element: ET.Element) -> None:
        mesh, origin = element.find("geometry/mesh"), origin_of(element)
        if mesh is None:
            plain = ET.SubElement(link, "collision")
            plain.extend(copy.deepcopy(one) for one in element if one.tag in ("origin", "geometry"))
            return
        file = self._file(mesh)
        if file is None:
            return
        points = self._read(file)[0] * _scale(mesh)
        if (shape := simple_shape(points)) is not None:
            pose, kind, size = shape
            add_shape(link, "collision", origin @ pose, kind, size)
            return
        name = self._written(f"{file.stem}_hull", file, mesh, lambda: _hull(points))
        add_shape(link, "collision", origin, "mesh", {"filename": name})

    def _visual(self, element: ET.Element, collisions: ET.Element) -> list[ET.Element]:
        visual = copy.deepcopy(element)
        mesh = visual.find("geometry/mesh")
        if mesh is None:
            return [visual]
        file = self._file(mesh)
        if file is None:
            instead = copy.deepcopy(collisions)
            for one in instead:
                one.tag = "visual"
            return list(instead)
        if file.suffix.lower() not in _READ_BY_ALL:
            points, triangles = self._read(file)
            scale = _scale(mesh)
            name = self._written(f"{file.stem}_visual", file, mesh, lambda: (points * scale, triangles))
            mesh.attrib.clear()
        elif (name := installed_name(file) or "") == "":
            name = file.name if self.copied.get(file.name, file) == file else f"{file.parent.name}_{file.name}"
            self.copied[name] = file
        mesh.set("filename", name)
        return [visual]

    def _written(self, stem: str, file: Path, mesh: ET.Element, make: Callable[[], tuple[Array, Array]]) -> str:
        """Returns the name under which a mesh is written that is made of a file at a scale."""
        key = stem, file, mesh.get("scale", "")
        if key not in self._names:
            same = sum(other[0] == stem for other in self._names)
            self._names[key] = f"{stem}{same or ''}.obj"
            self.texts[self._names[key]] = _obj(*make())
        return self._names[key]


def simple_shape(points: Array) -> tuple[Array, str, dict[str, str]] | None:
    """Returns a box or cylinder around points that is hardly larger than their hull: pose, kind, size; else None."""
    low, high = points.min(axis=0), points.max(axis=0)
    size, middle, volume = high - low, (low + high) / 2.0, hull_volume(points)
    pose = Pose.of(*middle).matrix()
    if volume <= 0.0:
        return pose, "box", {"size": numbers(np.maximum(size, _THIN))}
    found = [(float(size.prod()), pose, "box", {"size": numbers(size)})]
    for axis, turn in enumerate((Pose.of(0, 0, 0, pitch=math.pi / 2), Pose.of(0, 0, 0, roll=math.pi / 2), Pose())):
        radius = float(np.linalg.norm(np.delete(points - middle, axis, axis=1), axis=1).max())
        values = {"radius": f"{radius:.5g}", "length": f"{float(size[axis]):.5g}"}
        found.append((math.pi * radius**2 * float(size[axis]), pose @ turn.matrix(), "cylinder", values))
    least = min(found, key=lambda one: one[0])
    return least[1:] if least[0] <= _TIGHT * volume else None


def hull_volume(points: Array) -> float:
    """Returns the volume of the convex hull of points [m³]; 0 for what is flat."""
    try:
        return float(ConvexHull(points).volume)
    except (QhullError, ValueError):
        return 0.0


def _hull(points: Array) -> tuple[Array, Array]:
    """Returns the hull of points with few corners: those that lie farthest out in evenly spread directions."""
    number = np.arange(_CORNERS) + 0.5
    height, turn = 1.0 - 2.0 * number / _CORNERS, math.pi * (1.0 + math.sqrt(5.0)) * number
    ring = np.sqrt(1.0 - height**2)
    directions = np.column_stack([ring * np.cos(turn), ring * np.sin(turn), height])
    corners = points[np.unique(np.argmax(points @ directions.T, axis=0))]
    corners = corners[ConvexHull(corners).vertices]
    hull = ConvexHull(corners)
    a, b, c = np.moveaxis(corners[hull.simplices], 1, 0)
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
    return corners, np.where(inward[:, None], hull.simplices[:, ::-1], hull.simplices)


def _obj(points: Array, triangles: Array) -> str:
    lines = [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in points.tolist()]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles.tolist()]
    return "\n".join(lines) + "\n"


def _scale(mesh: ET.Element) -> Array:
    return np.array((mesh.get("scale") or "1 1 1").split(), dtype=float)

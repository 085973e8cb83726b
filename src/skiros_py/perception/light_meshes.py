"""Meshes that are light to draw: models of robots have more triangles than a picture of the whole robot shows."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from skiros_py.open3d import pybind as o3d

_SAME = 1e-6
"""Corners so near to each other are one [m]: files repeat them for each of their normals."""

_Colour = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class MeshPiece:
    """The part of a mesh with one colour, as a file of its own.

    Attributes:
        file: Name of the binary STL file; the hash of its content is in it.
        colour: Red, green, blue, opacity, each from 0 to 1.
        triangles: How many it has.
    """

    file: str
    colour: tuple[float, float, float, float]
    triangles: int


class MeshLightener:
    """Makes meshes with fewer triangles; for a worker process, since it holds the interpreter for a second."""

    def light(self, sources: Sequence[Path], folder: Path, most: int) -> dict[Path, tuple[MeshPiece, ...]]:
        """Writes light versions of meshes: the largest lose triangles first.

        Args:
            sources: Files of meshes, of any format that Open3D reads; one that is drawn twice is named twice.
            folder: Where the new files go; it exists.
            most: Approximate maximum number of triangles of all meshes together; with fewer they are not simplified.

        Returns:
            The pieces of each mesh; none where it cannot be read.
        """
        with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
            read = {source: _by_colour(source) for source in dict.fromkeys(sources)}
            limit = _limit([len(mesh.triangles) for source in sources for mesh in read[source].values()], most)
            return {
                source: tuple(_written(mesh, colour, limit, source.stem, folder) for colour, mesh in pieces.items())
                for source, pieces in read.items()
            }


def _by_colour(source: Path) -> Mapping[_Colour, Any]:
    model = o3d.io.read_triangle_model(str(source))
    found: dict[_Colour, Any] = {}
    for part in model.meshes:
        red, green, blue, opacity = map(float, model.materials[part.material_idx].base_color)
        colour = red, green, blue, opacity
        found[colour] = found[colour] + part.mesh if colour in found else part.mesh
    return {colour: mesh for colour, mesh in found.items() if mesh.triangles}


def _limit(counts: Sequence[int], most: int) -> float:
    """Returns the limit of triangles per piece at which all pieces together reach the total limit."""
    left = most
    for done, count in enumerate(sorted(counts)):
        share = left / (len(counts) - done)
        if count > share:
            return share
        left -= count
    return math.inf


def _written(mesh: Any, colour: _Colour, limit: float, stem: str, folder: Path) -> MeshPiece:
    if len(mesh.triangles) > limit:
        mesh = mesh.merge_close_vertices(_SAME).simplify_quadric_decimation(round(limit))
    mesh.compute_triangle_normals()  # required in such a file
    with TemporaryDirectory(dir=folder) as place:
        path = Path(place) / "mesh.stl"
        o3d.io.write_triangle_mesh(str(path), mesh)
        name = f"{stem}-{hashlib.sha256(path.read_bytes()).hexdigest()[:16]}.stl"
        path.rename(folder / name)
    return MeshPiece(name, colour, len(mesh.triangles))

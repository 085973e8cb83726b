"""Meshes of robot models."""

from __future__ import annotations

from pathlib import Path

import coal
import numpy as np

from skiros_py.errors import FileError
from skiros_py.geometry import Array


def read_mesh(file: Path) -> tuple[Array, Array]:
    """Reads a mesh in any format that Assimp reads.

    Returns:
        Its points [m, as the file has them], shape (n, 3), and its triangles as indices of them, shape (m, 3).

    Raises:
        FileError: It cannot be read.
    """
    try:
        mesh = coal.MeshLoader().load(str(file), np.ones(3))
    except ValueError as error:
        raise FileError(file, f"no mesh that can be read: {str(error).splitlines()[-1]}") from error
    triangles = [[int(face[i]) for i in range(3)] for face in map(mesh.tri_indices, range(mesh.num_tris))]
    return np.array(mesh.vertices()), np.array(triangles, dtype=int).reshape(-1, 3)

"""Meshes of robot models: their points, and which links of a model touch each other."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin

from skiros_py.devices.arm import ArmSpec
from skiros_py.errors import FileError
from skiros_py.geometry import Array
from skiros_py.motion.pinocchio.arm_model import ArmModel
from skiros_py.motion.pinocchio.collision import self_collision_pairs

_MARGIN = 0.003
"""Distance below which two links count as touching [m]."""


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


def self_contacts(urdf: Path, joints: Sequence[str], tip: str, posture: Array) -> list[tuple[str, str]]:
    """Returns pairs of shapes of a robot that touch in a posture, but not in most others."""
    spec = ArmSpec("arm", tuple(joints), tip, tuple(map(float, posture)))
    # Pairs that overlap at home are never checked, so home is a posture that no arm has.
    neutral = ArmModel(urdf, ArmSpec("arm", tuple(joints), tip, _middle(urdf, spec)))
    shapes = neutral.collision_shapes(0.0)
    for first, second in self_collision_pairs(neutral):
        shapes.addCollisionPair(pin.CollisionPair(shapes.getGeometryId(first), shapes.getGeometryId(second)))
    data = shapes.createData()
    for request in data.collisionRequests:
        request.security_margin = _MARGIN
    pin.computeCollisions(neutral.model, neutral.model.createData(), shapes, data, np.asarray(posture), False)
    names = [shape.name for shape in shapes.geometryObjects]
    return [
        (names[pair.first], names[pair.second])
        for pair, result in zip(shapes.collisionPairs, data.collisionResults, strict=True)
        if result.isCollision()
    ]


def _middle(urdf: Path, spec: ArmSpec) -> tuple[float, ...]:
    model = ArmModel(urdf, spec)
    return tuple(map(float, (np.maximum(model.lower, -np.pi) + np.minimum(model.upper, np.pi)) / 2.0))

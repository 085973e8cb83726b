"""Solids as PyBullet bodies: one body per solid, its primitives as one compound shape."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from skiros_py.geometry import Array, Pose, Primitive, Solid
from skiros_py.ports.simulation import Colour, Vector
from skiros_py.simulation.pybullet.client import Client


@dataclass(slots=True)
class Body:
    """A body in the physics client.

    Attributes:
        index: PyBullet's id.
        solid: Its shape.
        mass: [kg].
        centre: Its centre of mass in the solid's frame [m]; PyBullet states poses of the centre of mass only.
        colour: For pictures.
        constraint: PyBullet's id of the attachment to a link, or None.
    """

    index: int
    solid: Solid
    mass: float
    centre: Vector
    colour: Colour
    constraint: int | None = None


class Poses(Mapping[str, Pose]):
    """The poses of bodies at one moment, each computed when it is first read.

    Args:
        bodies: By name.
        client: The physics client.
    """

    def __init__(self, bodies: Mapping[str, Body], client: Client) -> None:
        locate = client.getBasePositionAndOrientation
        self._raw = {name: (body.centre, *locate(body.index)) for name, body in bodies.items()}
        self._poses: dict[str, Pose] = {}

    def __getitem__(self, name: str) -> Pose:
        if name not in self._poses:
            (x, y, z), position, orientation = self._raw[name]
            self._poses[name] = Pose(tuple(position), tuple(orientation)) @ Pose((-x, -y, -z))
        return self._poses[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._raw)

    def __len__(self) -> int:
        return len(self._raw)


def build_solid(
    client: Client,
    solid: Solid,
    pose: Pose,
    *,
    mass: float = 0.0,
    centre: Vector = (0.0, 0.0, 0.0),
    colour: Colour,
    collides: bool = True,
) -> int:
    """Builds one body.

    Args:
        client: Where.
        solid: Its shape.
        pose: Pose of the solid's frame in the map.
        mass: [kg]; 0 for a body that never moves.
        centre: Centre of mass in the solid's frame [m].
        colour: For pictures.
        collides: False for a body that is only looked at.

    Returns:
        PyBullet's id of the body.
    """
    shapes = _shapes(client, solid.primitives)
    collision = client.createCollisionShapeArray(**_frames(solid.primitives, centre, "collision"), **shapes)
    frames = _frames(solid.primitives, centre, "visual")
    visual = client.createVisualShapeArray(**frames, **shapes, rgbaColors=[colour] * len(solid.primitives))
    at = pose @ Pose(centre)
    index: int = client.createMultiBody(mass, collision if collides else -1, visual, at.position, at.orientation)
    return index


def centre_of_mass(solid: Solid) -> Vector:
    """Returns the centre of mass of a solid of even density in its frame [m]; overlaps of primitives count twice."""
    volumes = np.array([_volume(block) for block in solid.primitives])
    centres: Array = np.array([block.pose.position for block in solid.primitives])
    x, y, z = (volumes @ centres / volumes.sum()).tolist()
    return x, y, z


def _volume(block: Primitive) -> float:
    if block.kind == "box":
        return float(np.prod(block.size))
    radius, length = block.size
    return float(np.pi * radius**2 * length)


def _shapes(client: Client, blocks: Sequence[Primitive]) -> dict[str, Any]:
    """Describes primitives to PyBullet, whose lists want every length of every primitive, sensible or not."""
    boxes = [block.kind == "box" for block in blocks]
    return {
        "shapeTypes": [client.GEOM_BOX if box else client.GEOM_CYLINDER for box in boxes],
        "halfExtents": [[s / 2.0 for s in b.size] if box else [0.0] * 3 for b, box in zip(blocks, boxes, strict=True)],
        "radii": [0.0 if box else b.size[0] for b, box in zip(blocks, boxes, strict=True)],
        "lengths": [0.0 if box else b.size[1] for b, box in zip(blocks, boxes, strict=True)],
    }


def _frames(blocks: Sequence[Primitive], centre: Sequence[float], use: str) -> dict[str, Any]:
    positions = [[p - c for p, c in zip(block.pose.position, centre, strict=True)] for block in blocks]
    return {
        f"{use}FramePositions": positions,
        f"{use}FrameOrientations": [list(block.pose.orientation) for block in blocks],
    }

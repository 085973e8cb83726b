"""Solids as PyBullet bodies: one body per solid, its primitives as one compound shape."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from skiros_py.geometry import Array, Pose, Primitive, Solid
from skiros_py.ports.cell import BodySpec
from skiros_py.simulation.pybullet.client import Client

__all__ = ["Body", "Colour", "build_solid", "centre_of_mass"]

Colour = tuple[float, float, float, float]

# Friction of parts, furniture and kits. With fingers of 1.0 a part of 0.9 kg is held at 30 N per finger; at 0.3 parts
# begin to slip. The two small ones stop parts from spinning between the finger pads and from rolling away for ever.
_LATERAL_FRICTION = 0.8
_SPINNING_FRICTION = 0.01
_ROLLING_FRICTION = 1e-4


@dataclass(frozen=True, slots=True)
class Body:
    """A body in the physics client.

    Attributes:
        spec: What it was built from.
        index: PyBullet's id of it.
        centre: Its centre of mass in the solid's frame [m]; PyBullet speaks of poses of the centre of mass only.
        colour: For the eye.
        constraint: PyBullet's id of the bolt to the robot that carries it, or None.
    """

    spec: BodySpec
    index: int
    centre: tuple[float, float, float]
    colour: Colour
    constraint: int | None = None

    def pose(self, client: Client) -> Pose:
        """Returns the pose of the solid's frame in the map."""
        return self.pose_at(self.centre_pose(client))

    def centre_pose(self, client: Client) -> Pose:
        """Returns where its centre of mass is in the map, which is all that PyBullet says."""
        position, orientation = client.getBasePositionAndOrientation(self.index)
        return Pose(tuple(position), tuple(orientation))

    def pose_at(self, centre: Pose) -> Pose:
        """Returns the pose of the solid's frame where the centre of mass is at a pose."""
        return centre @ Pose(tuple(-c for c in self.centre))  # type: ignore[arg-type]

    def place(self, client: Client, pose: Pose) -> None:
        """Puts the body somewhere in the map, at rest."""
        at = pose @ Pose(self.centre)
        client.resetBasePositionAndOrientation(self.index, at.position, at.orientation)
        client.resetBaseVelocity(self.index, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def build_solid(
    client: Client,
    solid: Solid,
    pose: Pose,
    *,
    mass: float = 0.0,
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0),
    colour: Colour | None = None,
    collides: bool = True,
) -> int:
    """Builds one body.

    Args:
        client: Where.
        solid: Its shape.
        pose: Pose of the solid's frame in the map.
        mass: [kg]; 0 for what never moves.
        centre: Centre of mass in the solid's frame [m].
        colour: Visible in this colour; None: not visible.
        collides: False for a body that is only looked at.

    Returns:
        PyBullet's id of the body.
    """
    shapes = _shapes(client, solid.primitives)
    collision = client.createCollisionShapeArray(**_frames(solid.primitives, centre, "collision"), **shapes)
    visual = -1
    if colour is not None:
        frames = _frames(solid.primitives, centre, "visual")
        visual = client.createVisualShapeArray(**frames, **shapes, rgbaColors=[colour] * len(solid.primitives))
    at = pose @ Pose(centre)
    index: int = client.createMultiBody(mass, collision if collides else -1, visual, at.position, at.orientation)
    client.changeDynamics(
        index,
        -1,
        lateralFriction=_LATERAL_FRICTION,
        spinningFriction=_SPINNING_FRICTION,
        rollingFriction=_ROLLING_FRICTION,
    )
    return index


def centre_of_mass(solid: Solid) -> tuple[float, float, float]:
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

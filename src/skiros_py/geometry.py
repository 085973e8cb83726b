"""Poses and solids: the only spatial vocabulary that crosses package borders.

Lengths are in metres, angles in radians, quaternions are (x, y, z, w) with unit norm, frames are right-handed with
z up. ``T_a_b`` names the pose of frame b in frame a, so that ``T_a_b @ T_b_c`` is ``T_a_c``.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]


def wrap_angle(angle: float) -> float:
    """Returns the same direction in (-pi, pi] [rad]."""
    wrapped = math.pi - (math.pi - angle) % (2.0 * math.pi)
    return wrapped if wrapped > -math.pi else math.pi  # the remainder may round up to a whole turn


@dataclass(frozen=True, slots=True)
class Pose:
    """A rigid transform: where a frame is, seen from another.

    Attributes:
        position: (x, y, z) [m].
        orientation: Unit quaternion (x, y, z, w).
    """

    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    orientation: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)

    @classmethod
    def of(cls, x: float, y: float, z: float, *, roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0) -> Pose:
        """Makes a pose from a position [m] and fixed-axis roll, pitch, yaw [rad]."""
        return cls((float(x), float(y), float(z)), _from_roll_pitch_yaw(float(roll), float(pitch), float(yaw)))

    @classmethod
    def from_matrix(cls, matrix: Array) -> Pose:
        """Makes a pose from a 4x4 homogeneous transform."""
        quaternion = Rotation.from_matrix(matrix[:3, :3]).as_quat()
        return cls(_triple(matrix[:3, 3]), _quaternion(quaternion))

    def matrix(self) -> Array:
        """Returns the 4x4 homogeneous transform."""
        matrix = np.eye(4)
        matrix[:3, :3] = Rotation.from_quat(self.orientation).as_matrix()
        matrix[:3, 3] = self.position
        return matrix

    def inverse(self) -> Pose:
        """Returns the pose of the reference frame seen from this one."""
        rotation = Rotation.from_quat(self.orientation).inv()
        return Pose(_triple(-rotation.apply(self.position)), _quaternion(rotation.as_quat()))

    def __matmul__(self, other: Pose) -> Pose:
        rotation = Rotation.from_quat(self.orientation)
        position = rotation.apply(other.position) + np.asarray(self.position)
        quaternion = (rotation * Rotation.from_quat(other.orientation)).as_quat()
        return Pose(_triple(position), _quaternion(quaternion))

    def apply(self, points: Array) -> Array:
        """Transforms points of shape (3,) or (n, 3) from this frame into the reference frame [m]."""
        return np.asarray(Rotation.from_quat(self.orientation).apply(points) + np.asarray(self.position))

    @property
    def yaw(self) -> float:
        """Heading of the x axis in the reference frame's xy plane [rad]."""
        x, y, z, w = self.orientation
        return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))

    def distance(self, other: Pose) -> float:
        """Returns the distance between the two origins [m]."""
        return math.dist(self.position, other.position)


def _triple(values: Array) -> tuple[float, float, float]:
    return float(values[0]), float(values[1]), float(values[2])


def _from_roll_pitch_yaw(roll: float, pitch: float, yaw: float) -> tuple[float, float, float, float]:
    """The product of turns about z, y and x; ten times faster than by scipy, which gives the same to the last bit."""
    (sr, cr), (sp, cp), (sy, cy) = _half_turn(roll), _half_turn(pitch), _half_turn(yaw)
    x, y, z, w = cp * sr, sp * cr, -(sp * sr), cp * cr
    return cy * x - sy * y, cy * y + sy * x, cy * z + sy * w, cy * w - sy * z


def _half_turn(angle: float) -> tuple[float, float]:
    """Sine and cosine of half an angle; not a number where it is infinite."""
    return (math.sin(angle / 2.0), math.cos(angle / 2.0)) if math.isfinite(angle) else (math.nan, math.nan)


def _quaternion(values: Array) -> tuple[float, float, float, float]:
    return float(values[0]), float(values[1]), float(values[2]), float(values[3])


@dataclass(frozen=True, slots=True)
class Primitive:
    """A convex building block.

    Attributes:
        kind: "box" or "cylinder".
        size: Box: full lengths along x, y, z [m]. Cylinder: (radius, length) with the axis along z [m].
        pose: Pose of the block's centre in the solid's frame.
    """

    kind: Literal["box", "cylinder"]
    size: tuple[float, ...]
    pose: Pose = field(default_factory=Pose)

    def __post_init__(self) -> None:
        expected = {"box": 3, "cylinder": 2}.get(self.kind)
        if expected is None:
            raise ValueError(f"a primitive is a 'box' or a 'cylinder', not '{self.kind}'")
        if len(self.size) != expected or not all(math.isfinite(s) and s > 0.0 for s in self.size):
            raise ValueError(f"a {self.kind} needs {expected} positive lengths, got {self.size}")


@dataclass(frozen=True, slots=True)
class Solid:
    """A rigid shape as a union of primitives; its frame lies on the support plane, z up, under its middle.

    Attributes:
        primitives: The building blocks, in the solid's frame.
    """

    primitives: tuple[Primitive, ...]

    @classmethod
    def box(cls, x: float, y: float, z: float) -> Solid:
        """Makes a box that stands on the origin with full lengths x, y, z [m]."""
        return cls((Primitive("box", (x, y, z), Pose((0.0, 0.0, z / 2.0))),))

    @classmethod
    def from_json(cls, text: str) -> Solid:
        """Reads ``[{"kind": "box", "size": [x, y, z], "at": [x, y, z], "rpy": [r, p, y]}, ...]``.

        Raises:
            ValueError: The text is not of that form; the message says what is wrong.
        """
        try:
            blocks: list[dict[str, Any]] = json.loads(text)
            solid = cls(tuple(_primitive(block) for block in blocks))
        except (TypeError, KeyError, AttributeError) as error:
            raise ValueError(f"not a list of primitives with 'kind', 'size', 'at' and 'rpy': {error}") from error
        if not solid.primitives:
            raise ValueError("a solid needs at least one primitive")
        return solid

    def bounds(self) -> tuple[Array, Array]:
        """Returns the lowest and highest corner of the axis-aligned bounding box in the solid's frame [m]."""
        corners = np.vstack([_extent(block) for block in self.primitives])
        return corners.min(axis=0), corners.max(axis=0)


def _primitive(block: dict[str, Any]) -> Primitive:
    at = _three_numbers(block.get("at", (0.0, 0.0, 0.0)), "at")
    roll, pitch, yaw = _three_numbers(block.get("rpy", (0.0, 0.0, 0.0)), "rpy")
    size = tuple(float(length) for length in block["size"])
    return Primitive(block["kind"], size, Pose.of(*at, roll=roll, pitch=pitch, yaw=yaw))


def _three_numbers(values: Sequence[float], name: str) -> tuple[float, float, float]:
    numbers = [float(value) for value in values]
    if len(numbers) != 3 or not all(map(math.isfinite, numbers)):
        raise ValueError(f"'{name}' takes three finite numbers, got {list(values)}")
    return numbers[0], numbers[1], numbers[2]


def _extent(block: Primitive) -> Array:
    rotation = Rotation.from_quat(block.pose.orientation).as_matrix()
    if block.kind == "box":
        half = np.abs(rotation) @ (np.asarray(block.size) / 2.0)
    else:
        radius, length = block.size
        axis = rotation[:, 2]
        half = np.abs(axis) * length / 2.0 + radius * np.sqrt(np.maximum(0.0, 1.0 - axis**2))
    centre = np.asarray(block.pose.position)
    return np.vstack([centre - half, centre + half])

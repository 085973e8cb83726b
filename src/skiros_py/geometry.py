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

Array = NDArray[np.float64]
Quaternion = tuple[float, float, float, float]


_SMALL = 1e-4
"""Below this angle [rad], the sine is its series to the last digit."""


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
    orientation: Quaternion = (0.0, 0.0, 0.0, 1.0)

    @classmethod
    def of(cls, x: float, y: float, z: float, *, roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0) -> Pose:
        """Makes a pose from a position [m] and fixed-axis roll, pitch, yaw [rad]."""
        return cls((float(x), float(y), float(z)), _from_roll_pitch_yaw(float(roll), float(pitch), float(yaw)))

    @classmethod
    def from_matrix(cls, matrix: Array) -> Pose:
        """Makes a pose from a 4x4 homogeneous transform."""
        from scipy.spatial.transform import Rotation  # half a second of imports that most processes never need

        x, y, z, w = Rotation.from_matrix(matrix[:3, :3]).as_quat().tolist()
        return cls(_triple(matrix[:3, 3]), (x, y, z, w))

    @classmethod
    def turn(cls, x: float, y: float, z: float) -> Pose:
        """Makes a turn about the origin; the vector has the direction of the axis and the length of the angle [rad]."""
        angle = math.sqrt(x * x + y * y + z * z)
        share = math.sin(angle / 2.0) / angle if angle > _SMALL else 0.5 - angle**2 / 48.0
        return cls(orientation=(share * x, share * y, share * z, math.cos(angle / 2.0)))

    def matrix(self) -> Array:
        """Returns the 4x4 homogeneous transform."""
        matrix = np.eye(4)
        matrix[:3, :3] = rotation_matrix(self.orientation)
        matrix[:3, 3] = self.position
        return matrix

    def inverse(self) -> Pose:
        """Returns the pose of the reference frame seen from this one."""
        x, y, z, w = _unit(self.orientation)
        turned = (-x, -y, -z, w)
        return Pose(_triple(-(rotation_matrix(turned) @ np.asarray(self.position))), turned)

    def __matmul__(self, other: Pose) -> Pose:
        position = rotation_matrix(self.orientation) @ np.asarray(other.position) + np.asarray(self.position)
        return Pose(_triple(position), _product(self.orientation, other.orientation))

    def apply(self, points: Array) -> Array:
        """Transforms points of shape (3,) or (n, 3) from this frame into the reference frame [m]."""
        return np.asarray(points @ rotation_matrix(self.orientation).T + np.asarray(self.position))

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


def rotation_matrix(orientation: Quaternion) -> Array:
    """Returns the 3x3 matrix of a quaternion (x, y, z, w), which need not have unit norm.

    Raises:
        ValueError: The quaternion is zero.
    """
    x, y, z, w = _unit(orientation)
    xx, yy, zz, ww = x * x, y * y, z * z, w * w
    xy, xz, xw, yz, yw, zw = x * y, x * z, x * w, y * z, y * w, z * w
    return np.array(
        (
            (xx - yy - zz + ww, 2.0 * (xy - zw), 2.0 * (xz + yw)),
            (2.0 * (xy + zw), -xx + yy - zz + ww, 2.0 * (yz - xw)),
            (2.0 * (xz - yw), 2.0 * (yz + xw), -xx - yy + zz + ww),
        )
    )


# These quaternions equal scipy's to the last bit, at a tenth of the time for a single one.


def _unit(q: Quaternion) -> Quaternion:
    x, y, z, w = q
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    if norm == 0.0:
        raise ValueError("a quaternion of length zero is no orientation")
    return x / norm, y / norm, z / norm, w / norm


def _product(p: Quaternion, q: Quaternion) -> Quaternion:
    (px, py, pz, pw), (qx, qy, qz, qw) = _unit(p), _unit(q)
    return _unit(
        (
            pw * qx + qw * px + (py * qz - pz * qy),
            pw * qy + qw * py + (pz * qx - px * qz),
            pw * qz + qw * pz + (px * qy - py * qx),
            pw * qw - px * qx - py * qy - pz * qz,
        )
    )


def _from_roll_pitch_yaw(roll: float, pitch: float, yaw: float) -> Quaternion:
    """The product of turns about z, y and x."""
    (sr, cr), (sp, cp), (sy, cy) = _half_turn(roll), _half_turn(pitch), _half_turn(yaw)
    x, y, z, w = cp * sr, sp * cr, -(sp * sr), cp * cr
    return cy * x - sy * y, cy * y + sy * x, cy * z + sy * w, cy * w - sy * z


def _half_turn(angle: float) -> tuple[float, float]:
    """Sine and cosine of half an angle; not a number where it is infinite."""
    return (math.sin(angle / 2.0), math.cos(angle / 2.0)) if math.isfinite(angle) else (math.nan, math.nan)


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

    def outside(self, points: Array) -> Array:
        """Returns how far points in the solid's frame are outside of the block [m], shape (n,)."""
        local = self.pose.inverse().apply(points)
        if self.kind == "box":
            beyond = np.abs(local) - np.asarray(self.size) / 2.0
        else:
            radius, length = self.size
            beyond = np.column_stack([np.hypot(local[:, 0], local[:, 1]) - radius, np.abs(local[:, 2]) - length / 2.0])
        return np.asarray(np.linalg.norm(np.maximum(beyond, 0.0), axis=1))


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
    rotation = rotation_matrix(block.pose.orientation)
    if block.kind == "box":
        half = np.abs(rotation) @ (np.asarray(block.size) / 2.0)
    else:
        radius, length = block.size
        axis = rotation[:, 2]
        half = np.abs(axis) * length / 2.0 + radius * np.sqrt(np.maximum(0.0, 1.0 - axis**2))
    centre = np.asarray(block.pose.position)
    return np.vstack([centre - half, centre + half])

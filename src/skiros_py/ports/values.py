"""What devices say and what they are told: frozen values, stamped with the cycle they belong to.

A device is known by the id of its individual in the world model ("panda_1"), so nothing here names a robot.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skiros_py.geometry import Array, Pose

__all__ = [
    "ArmState",
    "ArmTarget",
    "BaseState",
    "BaseTwist",
    "CameraIntrinsics",
    "Commands",
    "DepthImage",
    "GripperState",
    "GripperTarget",
    "Snapshot",
]


@dataclass(frozen=True, slots=True)
class ArmState:
    """Joint sensors of one arm.

    Attributes:
        positions: Joint angles [rad], shape (n,).
        velocities: Joint speeds [rad/s], shape (n,).
        still: True when every joint is slower than the arm's standstill threshold.
    """

    positions: tuple[float, ...]
    velocities: tuple[float, ...]
    still: bool


@dataclass(frozen=True, slots=True)
class GripperState:
    """Sensors of a parallel gripper.

    Attributes:
        gap: Distance between the finger pads [m].
        force: Force with which the fingers press on what they hold, per finger [N]; about 0 when nothing is held.
        still: True when the fingers do not move.
    """

    gap: float
    force: float
    still: bool


@dataclass(frozen=True, slots=True)
class BaseState:
    """What localisation and wheel odometry say of a mobile base.

    Attributes:
        pose: *Estimated* pose of the base frame (on the floor) in the map; it carries the localiser's error.
        linear: Forward speed [m/s].
        angular: Turning speed, counter-clockwise [rad/s].
        still: True when the base stands.
    """

    pose: Pose
    linear: float
    angular: float
    still: bool


@dataclass(frozen=True, slots=True)
class Snapshot:
    """Everything all devices said in one cycle; every behaviour of the cycle sees this same value.

    Attributes:
        cycle: Number of the control cycle, from 0.
        time: Time since the start of the run [s]; simulated where the robot is.
        arms, grippers, bases: State by device id.
    """

    cycle: int
    time: float
    arms: Mapping[str, ArmState] = field(default_factory=dict)
    grippers: Mapping[str, GripperState] = field(default_factory=dict)
    bases: Mapping[str, BaseState] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ArmTarget:
    """Joint set-points for one cycle: positions [rad] and feed-forward velocities [rad/s], shape (n,)."""

    positions: tuple[float, ...]
    velocities: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class GripperTarget:
    """Move the fingers to a gap [m] pressing with at most a force per finger [N]; it stays in force until replaced."""

    gap: float
    force: float


@dataclass(frozen=True, slots=True)
class BaseTwist:
    """Speeds of a differential-drive base for one cycle: forward [m/s] and counter-clockwise [rad/s]."""

    linear: float
    angular: float


@dataclass(frozen=True, slots=True)
class Commands:
    """What is wanted of each device in one cycle, by device id.

    A device without a command does its default safe task: an arm and a base brake within their limits and hold, a
    gripper keeps its last target (so that it never lets go by omission).
    """

    arms: Mapping[str, ArmTarget] = field(default_factory=lambda: MappingProxyType({}))
    grippers: Mapping[str, GripperTarget] = field(default_factory=lambda: MappingProxyType({}))
    bases: Mapping[str, BaseTwist] = field(default_factory=lambda: MappingProxyType({}))


@dataclass(frozen=True, slots=True)
class CameraIntrinsics:
    """A pinhole camera: image size [px], focal lengths and principal point [px], usable range of depth [m].

    The optical frame looks along +z, with x to the right and y down in the image.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    near: float
    far: float


@dataclass(frozen=True, slots=True, eq=False)
class DepthImage:
    """One shot of a depth camera. It knows nothing of objects.

    Attributes:
        cycle: The cycle in which it was taken.
        depth: Distance along the optical axis [m], float32, shape (height, width); 0 where nothing was measured.
        colour: RGB, uint8, shape (height, width, 3).
        intrinsics: The camera's model.
        arms: Joint positions [rad] by arm id when it was taken: forward kinematics gives the camera's pose.
        bases: *Estimated* base poses by base id when it was taken.
    """

    cycle: int
    depth: NDArray[np.float32]
    colour: NDArray[np.uint8]
    intrinsics: CameraIntrinsics
    arms: Mapping[str, tuple[float, ...]]
    bases: Mapping[str, Pose]

    def points(self) -> Array:
        """Returns the measured points in the optical frame [m], shape (n, 3)."""
        v, u = np.nonzero(self.depth > 0.0)
        z = self.depth[v, u].astype(np.float64)
        k = self.intrinsics
        return np.column_stack([(u - k.cx) / k.fx * z, (v - k.cy) / k.fy * z, z])

    def __reduce__(self) -> Any:
        fields = (self.cycle, self.depth, self.colour, self.intrinsics, dict(self.arms), dict(self.bases))
        return DepthImage, fields

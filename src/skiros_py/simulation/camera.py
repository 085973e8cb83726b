"""Simulated cameras: exact renderings made into what a depth camera delivers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skiros_py.devices.camera import CameraSpec
from skiros_py.geometry import Pose
from skiros_py.ports.cell import RobotSpec
from skiros_py.ports.simulation import Rendering, Vector, View
from skiros_py.ports.values import CameraIntrinsics, DepthImage, Snapshot

_OUTSIDE_FOV = 0.8726646259971648  # vertical, 50 degrees [rad]
_OUTSIDE_RANGE = (0.1, 30.0)  # [m]


@dataclass(frozen=True, slots=True)
class DepthShot:
    """Makes the image of a depth camera from a rendering: adds noise, and keeps what is in range.

    Attributes:
        snapshot: What the devices said in the cycle of the shot.
        noise: Standard deviation of depth noise [m].
        seed: Seed of this shot's noise.
        intrinsics: The camera's model.
    """

    snapshot: Snapshot
    noise: float
    seed: tuple[int, ...]
    intrinsics: CameraIntrinsics

    def __call__(self, rendering: Rendering) -> DepthImage:
        """Returns the image."""
        rng = np.random.default_rng(self.seed)
        depth = rendering.depth + rng.normal(scale=self.noise, size=rendering.depth.shape)
        depth[(depth > self.intrinsics.far) | (depth < self.intrinsics.near)] = 0.0
        return DepthImage(self.snapshot, depth.astype(np.float32), rendering.colour, self.intrinsics)


def colour_of(rendering: Rendering) -> NDArray[np.uint8]:
    """Returns the colours of a rendering."""
    return rendering.colour


def view_of(camera: CameraSpec, robot: RobotSpec) -> View:
    """Returns what a camera sees: on a link of its robot, or fixed where it stands by itself."""
    size = (camera.width, camera.height)
    at: dict[str, Any] = {"robot": robot.id, "link": camera.frame} if robot.model else {"pose": robot.place}
    return View(*size, camera.vertical_fov, camera.near, camera.far, **at)


def outside_view(eye: Vector, target: Vector, width: int, height: int) -> View:
    """Returns a view for people: from a point in the map towards another that is not straight above or below [m]."""
    forward = np.subtract(target, eye)
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    right = right / np.linalg.norm(right)
    axes = np.eye(4)
    axes[:3, :3] = np.column_stack([right, np.cross(forward, right), forward])
    axes[:3, 3] = eye
    return View(width, height, _OUTSIDE_FOV, *_OUTSIDE_RANGE, pose=Pose.from_matrix(axes))

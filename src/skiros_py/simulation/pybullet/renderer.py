"""Pictures of the scene, made in a process of its own: a software renderer holds the interpreter for tens of ms.

The renderer has a client without physics that it brings into the state of the wanted moment before each picture.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from skiros_py.geometry import Pose, Solid
from skiros_py.ports.values import CameraIntrinsics, DepthImage
from skiros_py.simulation.pybullet.appearance import FLOOR
from skiros_py.simulation.pybullet.bodies import build_solid
from skiros_py.simulation.pybullet.client import Client
from skiros_py.simulation.pybullet.joints import Joints
from skiros_py.simulation.pybullet.picture import Look, SceneState, Shot
from skiros_py.simulation.pybullet.robot import load_model

__all__ = ["Renderer", "intrinsics_of"]

_FLOOR = Solid.box(40.0, 40.0, 0.1)
_LIGHT = (1.5, -2.0, 4.0)
_PICTURE_FOV = 50.0  # vertical [deg]
_PICTURE_RANGE = (0.1, 30.0)  # [m]


def intrinsics_of(width: int, height: int, vertical_fov: float, near: float, far: float) -> CameraIntrinsics:
    """Returns the pinhole model of this renderer's images; lengths in [px], angle [rad], range [m].

    The renderer samples pixel (u, v) at the ray through (u - w/2, v - h/2 + 1), measured to 1e-3 px.
    """
    focal = height / 2.0 / math.tan(vertical_fov / 2.0)
    return CameraIntrinsics(width, height, focal, focal, width / 2.0, height / 2.0 - 1.0, near, far)


class Renderer:
    """Makes pictures of scene states.

    Args:
        urdfs: Model of each robot, by the robot's id.
    """

    def __init__(self, urdfs: Mapping[str, Path]) -> None:
        self._client = Client()
        self._robots = {robot: Joints(self._client, load_model(self._client, urdf)) for robot, urdf in urdfs.items()}
        self._bodies: dict[str, tuple[Look, int]] = {}
        build_solid(self._client, _FLOOR, Pose((0.0, 0.0, -0.1)), colour=FLOOR, collides=False)

    def shoot(self, state: SceneState, shot: Shot) -> DepthImage:
        """Takes a picture with a robot's camera."""
        self._show(state)
        k = shot.intrinsics
        projection = self._client.computeProjectionMatrixFOV(
            math.degrees(shot.camera.vertical_fov), k.width / k.height, k.near, k.far
        )
        colour, buffer = self._render(k.width, k.height, self._camera_view(shot), projection)
        depth = _metres(buffer, k.near, k.far)
        rng = np.random.default_rng(shot.noise_seed)
        depth += rng.normal(scale=shot.camera.noise, size=depth.shape)
        depth[(buffer >= 1.0) | (depth > k.far) | (depth < k.near)] = 0.0
        return DepthImage(shot.cycle, depth.astype(np.float32), colour, k, shot.arms, shot.bases)

    def picture(
        self, state: SceneState, eye: Sequence[float], target: Sequence[float], width: int, height: int
    ) -> NDArray[np.uint8]:
        """Makes a picture for people, seen from a point in the map towards another [m]; RGB, (height, width, 3)."""
        self._show(state)
        view = self._client.computeViewMatrix(eye, target, (0.0, 0.0, 1.0))
        projection = self._client.computeProjectionMatrixFOV(_PICTURE_FOV, width / height, *_PICTURE_RANGE)
        return self._render(width, height, view, projection)[0]

    def _render(
        self, width: int, height: int, view: Sequence[float], projection: Sequence[float]
    ) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
        client = self._client
        _, _, colour, depth, _ = client.getCameraImage(
            width,
            height,
            view,
            projection,
            renderer=client.ER_TINY_RENDERER,
            shadow=0,
            lightDirection=_LIGHT,
            flags=client.ER_NO_SEGMENTATION_MASK,
        )
        rgb = np.ascontiguousarray(np.asarray(colour, dtype=np.uint8).reshape(height, width, 4)[:, :, :3])
        return rgb, np.asarray(depth, dtype=np.float64).reshape(height, width)

    def _camera_view(self, shot: Shot) -> Sequence[float]:
        joints = self._robots[shot.robot]
        link = self._client.getLinkState(joints.body, joints.link(shot.camera.frame), computeForwardKinematics=True)
        axes = Pose(link[4], link[5]).matrix()
        eye, down, forward = axes[:3, 3], axes[:3, 1], axes[:3, 2]
        view: Sequence[float] = self._client.computeViewMatrix(eye, eye + forward, -down)
        return view

    def _show(self, state: SceneState) -> None:
        for robot, posture in state.robots.items():
            joints = self._robots[robot]
            for index, position in zip(joints.movable, posture, strict=True):
                self._client.resetJointState(joints.body, index, position)
        wanted = {look.id: look for look in state.bodies}
        for body_id in [known for known in self._bodies if known not in wanted]:
            self._forget(body_id)
        for look in state.bodies:
            self._show_body(look)

    def _show_body(self, look: Look) -> None:
        known = self._bodies.get(look.id)
        if known is not None and (known[0].solid, known[0].colour) != (look.solid, look.colour):
            self._forget(look.id)
            known = None
        if known is None:
            index = build_solid(self._client, look.solid, look.pose, colour=look.colour, collides=False)
            self._bodies[look.id] = (look, index)
        else:
            self._client.resetBasePositionAndOrientation(known[1], look.pose.position, look.pose.orientation)

    def _forget(self, body_id: str) -> None:
        self._client.removeBody(self._bodies.pop(body_id)[1])


def _metres(buffer: NDArray[np.float64], near: float, far: float) -> NDArray[np.float64]:
    """Turns a depth buffer (0 near, 1 far, uneven in between) into distances along the optical axis [m]."""
    return far * near / (far - (far - near) * buffer)

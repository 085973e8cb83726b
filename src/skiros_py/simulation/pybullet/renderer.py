"""Renders in a process of its own: a software renderer holds the interpreter for tens of ms.

The renderer has a client without physics that it brings into the state of the wanted moment before each picture.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np

from skiros_py.geometry import Array, Pose, Solid
from skiros_py.ports.simulation import Colour, Rendering, View
from skiros_py.ports.values import CameraIntrinsics
from skiros_py.simulation.pybullet.client import Client, build_solid
from skiros_py.simulation.pybullet.robot import RobotModel

T = TypeVar("T")

_FLOOR = Solid.box(40.0, 40.0, 0.1)
_FLOOR_COLOUR: Colour = (0.80, 0.81, 0.80, 1.0)
_NOTHING = 1.0 - 1e-6  # the buffer where nothing is in range, but for its rounding
_LIGHT = (1.5, -2.0, 4.0)


@dataclass(frozen=True, slots=True)
class BodyAppearance:
    """Shape, colour and pose in the map of a body."""

    solid: Solid
    colour: Colour
    pose: Pose


@dataclass(frozen=True, slots=True)
class RobotAppearance:
    """Model, pose of the root link and positions of all movable joints of a robot."""

    urdf: Path
    root: Pose
    positions: tuple[float, ...]


def intrinsics_of(view: View) -> CameraIntrinsics:
    """Returns the pinhole model of this renderer's images.

    The renderer samples pixel (u, v) at the ray through (u - w/2, v - h/2 + 1), measured to 1e-3 px.
    """
    focal = view.height / 2.0 / math.tan(view.vertical_fov / 2.0)
    cx, cy = view.width / 2.0, view.height / 2.0 - 1.0
    return CameraIntrinsics(view.width, view.height, focal, focal, cx, cy, view.near, view.far)


class Renderer:
    """Renders views of moments.

    Args:
        urdfs: Models of robots to load at once, by name; others are loaded when they are first seen.
    """

    def __init__(self, urdfs: Mapping[str, tuple[Path, Pose]]) -> None:
        self._client = Client()
        self._robots = {name: RobotModel(self._client, *model) for name, model in urdfs.items()}
        self._bodies: dict[str, tuple[BodyAppearance, int]] = {}
        build_solid(self._client, _FLOOR, Pose((0.0, 0.0, -0.1)), colour=_FLOOR_COLOUR, collides=False)

    def render(
        self,
        bodies: Mapping[str, BodyAppearance],
        robots: Mapping[str, RobotAppearance],
        view: View,
        finish: Callable[[Rendering], T],
    ) -> T:
        """Renders a view of bodies and robots, by name, and returns what ``finish`` makes of it."""
        self._show(bodies, robots)
        client = self._client
        projection = client.computeProjectionMatrixFOV(
            math.degrees(view.vertical_fov), view.width / view.height, view.near, view.far
        )
        _, _, colour, buffer, _ = client.getCameraImage(
            view.width,
            view.height,
            self._view_matrix(view),
            projection,
            renderer=client.ER_TINY_RENDERER,
            shadow=0,
            lightDirection=_LIGHT,
            flags=client.ER_NO_SEGMENTATION_MASK,
        )
        shape = (view.height, view.width)
        rgb = np.ascontiguousarray(np.asarray(colour, dtype=np.uint8).reshape(*shape, 4)[:, :, :3])
        return finish(Rendering(_metres(np.asarray(buffer, dtype=np.float64).reshape(shape), view), rgb))

    def _view_matrix(self, view: View) -> Sequence[float]:
        at = view.pose
        if view.robot is not None:
            model = self._robots[view.robot]
            link = model.link_pose(model.link(view.link))
            at = link if at == Pose() else link @ at
        axes = at.matrix()
        eye, down, forward = axes[:3, 3], axes[:3, 1], axes[:3, 2]
        matrix: Sequence[float] = self._client.computeViewMatrix(eye, eye + forward, -down)
        return matrix

    def _show(self, bodies: Mapping[str, BodyAppearance], robots: Mapping[str, RobotAppearance]) -> None:
        for name, robot in robots.items():
            if name not in self._robots:
                self._robots[name] = RobotModel(self._client, robot.urdf, robot.root)
            self._robots[name].place(robot.positions)
        for name, (old, index) in list(self._bodies.items()):
            new = bodies.get(name)
            if new is None or (old.solid, old.colour) != (new.solid, new.colour):
                self._client.removeBody(index)
                del self._bodies[name]
        for name, look in bodies.items():
            if name in self._bodies:
                at = look.pose.position, look.pose.orientation
                self._client.resetBasePositionAndOrientation(self._bodies[name][1], *at)
            else:
                index = build_solid(self._client, look.solid, look.pose, colour=look.colour, collides=False)
                self._bodies[name] = (look, index)


def _metres(buffer: Array, view: View) -> Array:
    """Turns a depth buffer (0 near, 1 far, uneven in between) into distances along the optical axis [m]."""
    near, far = view.near, view.far
    depth = far * near / (far - (far - near) * buffer)
    depth[buffer >= _NOTHING] = np.inf
    return np.asarray(depth)

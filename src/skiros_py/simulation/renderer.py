"""Pictures of the world of any engine: rays of Open3D's, cast in a process of their own.

It needs no graphics card and no OpenGL. The process is told where everything is at the wanted moment.
"""

from __future__ import annotations

import functools
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from skiros_py.errors import UnknownName, UsageError
from skiros_py.geometry import Array, Pose, Solid
from skiros_py.ports.simulation import FLOOR, Colour, Print, Rendering, View
from skiros_py.ports.values import CameraIntrinsics
from skiros_py.workers import Call, Worker

T = TypeVar("T")

_FLOOR = Solid.box(40.0, 40.0, 0.1)
_FLOOR_COLOUR: Colour = (0.80, 0.81, 0.80, 1.0)
_GREY: Colour = (0.5, 0.5, 0.5, 1.0)
_NOTHING_COLOUR = 255
_LIGHT = np.array((1.5, -2.0, 4.0)) / np.linalg.norm((1.5, -2.0, 4.0))  # where it comes from
_AMBIENT, _DIFFUSE = 0.6, 0.4
_PAPER, _INK = (0.95, 2e-4), (0.05, 4e-4)  # greys, and how far they lie on a face, so that rays meet them first [m]
_ROUND = 64  # flat sides of a cylinder or sphere

Floats = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class BodyAppearance:
    """Shape, colour and pose in the map of a body, and what is printed on it."""

    solid: Solid
    colour: Colour
    pose: Pose
    printed: Print | None = None


@dataclass(frozen=True, slots=True)
class RobotAppearance:
    """Model of a robot and the poses of its links in the map."""

    urdf: Path
    links: Mapping[str, Pose]


class _Body(Protocol):
    solid: Solid
    colour: Colour


class _Robot(Protocol):
    urdf: Path

    def link_poses(self) -> Mapping[str, Pose]: ...


B = TypeVar("B", bound=_Body)
R = TypeVar("R", bound=_Robot)


class RenderedWorld(ABC, Generic[B, R]):
    """What engines have in common: bodies and robots by name, and their pictures.

    Attributes:
        bodies: The bodies.
        robots: The robots.
        printed: What is printed on bodies, by name.
    """

    def __init__(self) -> None:
        self.bodies: dict[str, B] = {}
        self.printed: dict[str, Print] = {}
        self.robots: dict[str, R] = {}
        self._before_step: list[Callable[[], None]] = []
        self._renderer: Worker | None = None

    @abstractmethod
    def poses(self) -> Mapping[str, Pose]:
        """Returns the current poses of all bodies."""

    def before_step(self, action: Callable[[], None]) -> None:
        """Calls an action before each step from now on."""
        self._before_step.append(action)

    def prepare_rendering(self) -> None:
        """Starts the renderer's process."""
        self._worker()

    def intrinsics(self, view: View) -> CameraIntrinsics:
        """Returns the exact pinhole model of the images of a view."""
        return intrinsics_of(view)

    def render(self, view: View, finish: Callable[[Rendering], T], *, latency: float = 0.0) -> Call[T]:
        """Renders the current moment in the renderer's process, which also calls ``finish``."""
        poses = self.poses()
        bodies = [
            BodyAppearance(body.solid, body.colour, poses[name], self.printed.get(name))
            for name, body in self.bodies.items()
        ]
        robots = [RobotAppearance(robot.urdf, robot.link_poses()) for robot in self.robots.values()]
        if view.robot is not None:
            view = replace(view, pose=self._robot(view.robot).link_poses()[view.link] @ view.pose, robot=None)
        return self._worker().call("render", bodies, robots, view, finish, latency=latency)

    def close(self) -> None:
        """Ends the renderer's process; may be called twice."""
        if self._renderer is not None:
            self._renderer.close()

    def _worker(self) -> Worker:
        if self._renderer is None:
            urdfs = tuple({robot.urdf for robot in self.robots.values()})
            self._renderer = Worker("renderer", functools.partial(Renderer, urdfs))
        return self._renderer

    def _require_free(self, name: str) -> None:
        if name in self.bodies or name in self.robots or name == FLOOR:
            raise UsageError(f"there is a '{name}' in the world already")

    def _body(self, name: str) -> B:
        if name not in self.bodies:
            raise UnknownName("body", name, self.bodies)
        return self.bodies[name]

    def _robot(self, name: str) -> R:
        if name not in self.robots:
            raise UnknownName("body or robot", name, [*self.bodies, *self.robots])
        return self.robots[name]


def intrinsics_of(view: View) -> CameraIntrinsics:
    """Returns the pinhole model of this renderer's images; the optical axis is in the middle of the picture."""
    focal = view.height / 2.0 / math.tan(view.vertical_fov / 2.0)
    cx, cy = (view.width - 1) / 2.0, (view.height - 1) / 2.0
    return CameraIntrinsics(view.width, view.height, focal, focal, cx, cy, view.near, view.far)


@dataclass(frozen=True, slots=True, eq=False)
class _Piece:
    """Triangles of one colour.

    Attributes:
        link: The link that they are on; empty for a body.
        corners: [m], shape (n, 3).
        triangles: Numbers of corners, shape (m, 3).
        colour: Red, green and blue, 0 to 255.
    """

    link: str
    corners: Array
    triangles: NDArray[np.uint32]
    colour: Array


class Renderer:
    """Renders views of moments.

    Args:
        urdfs: Models of robots to load at once; others are loaded when they are first seen.
    """

    def __init__(self, urdfs: Iterable[Path] = ()) -> None:
        from skiros_py.open3d import pybind  # heavy, and only this process needs it

        self._o3d = pybind
        self._models = {urdf: self._drawn(urdf) for urdf in urdfs}
        self._solids: dict[tuple[Solid, Colour], tuple[_Piece, ...]] = {}
        self._prints: dict[Print, tuple[_Piece, ...]] = {}

    def render(
        self,
        bodies: Iterable[BodyAppearance],
        robots: Iterable[RobotAppearance],
        view: View,
        finish: Callable[[Rendering], T],
    ) -> T:
        """Renders a view, whose pose is in the map, of bodies and robots; returns what ``finish`` makes of it."""
        eye = view.pose.inverse()
        pieces = list(self._seen(bodies, robots, eye, view))
        count = np.cumsum([0, *(len(corners) for _, corners in pieces)])
        triangles = [piece.triangles + np.uint32(first) for (piece, _), first in zip(pieces, count, strict=False)]
        colours = np.repeat(
            [piece.colour for piece, _ in pieces], [len(piece.triangles) for piece, _ in pieces], axis=0
        )
        tensor, shape = self._o3d.core.Tensor.from_numpy, (view.height, view.width)
        # In the frame of the camera, so that distances do not lose digits by being far from the map's origin.
        scene = self._o3d.t.geometry.RaycastingScene(nthreads=1)
        scene.add_triangles(
            tensor(np.concatenate([corners for _, corners in pieces])), tensor(np.concatenate(triangles))
        )
        rays = _rays(intrinsics_of(view))
        answer = scene.cast_rays(tensor(rays), nthreads=1)
        depth = answer["t_hit"].numpy().astype(np.float64)
        depth[(depth > view.far) | (depth < view.near)] = np.inf
        normals = answer["primitive_normals"].numpy().reshape(-1, 3).astype(np.float64)
        light = np.asarray(Pose(orientation=eye.orientation).apply(_LIGHT))
        towards = -np.sign(np.einsum("ij,ij->i", normals, rays[:, :, 3:].reshape(-1, 3)))
        lit = _AMBIENT + _DIFFUSE * np.clip(towards * (normals @ light), 0.0, 1.0)
        which = answer["primitive_ids"].numpy().ravel()
        met = which < len(colours)
        colour = np.full((len(which), 3), _NOTHING_COLOUR, np.uint8)
        colour[met] = (colours[which[met]] * lit[met, None]).round()
        return finish(Rendering(depth, colour.reshape(*shape, 3)))

    def _seen(
        self, bodies: Iterable[BodyAppearance], robots: Iterable[RobotAppearance], eye: Pose, view: View
    ) -> Iterable[tuple[_Piece, Floats]]:
        """Yields what may be in the picture, with its corners in the frame of the camera."""
        bodies = tuple(bodies)
        shown = [(piece, Pose((0.0, 0.0, -0.1))) for piece in self._built(_FLOOR, _FLOOR_COLOUR)]
        shown += [(piece, body.pose) for body in bodies for piece in self._built(body.solid, body.colour)]
        shown += [(piece, body.pose) for body in bodies if body.printed for piece in self._inked(body.printed)]
        for robot in robots:
            if robot.urdf not in self._models:
                self._models[robot.urdf] = self._drawn(robot.urdf)
            shown += [(piece, robot.links[piece.link]) for piece in self._models[robot.urdf]]
        half = math.tan(view.vertical_fov / 2.0)
        sides = np.array((half * view.width / view.height, half))
        for number, (piece, pose) in enumerate(shown):
            corners = (eye @ pose).apply(piece.corners)
            low, high = corners.min(axis=0), corners.max(axis=0)
            beyond = np.maximum(low[:2], -high[:2]) > sides * max(
                high[2], 0.0
            )  # all of it is on one side of the picture
            if number == 0 or not (high[2] < view.near or low[2] > view.far or beyond.any()):
                yield piece, corners.astype(np.float32)

    def _inked(self, printed: Print) -> tuple[_Piece, ...]:
        if printed not in self._prints:
            rows, columns = len(printed.dark), len(printed.dark[0])
            y, x = np.nonzero(np.array(printed.dark))
            paper = _quads(np.zeros((1, 2)), np.array((columns, rows)), printed, _PAPER)
            self._prints[printed] = paper, _quads(np.column_stack([x, y]), np.ones(2), printed, _INK)
        return self._prints[printed]

    def _built(self, solid: Solid, colour: Colour) -> tuple[_Piece, ...]:
        if (solid, colour) not in self._solids:
            self._solids[solid, colour] = tuple(
                self._piece("", self._shape(block.kind, block.size), block.pose, colour) for block in solid.primitives
            )
        return self._solids[solid, colour]

    def _drawn(self, urdf: Path) -> tuple[_Piece, ...]:
        """Returns what a robot model has for the eye; meshes keep their own colours where it states none."""
        from skiros_py.simulation.models import visuals_of

        pieces: list[_Piece] = []
        for visual in visuals_of(urdf):
            if visual.file is None:
                shape = self._shape(visual.kind, visual.size)
                pieces.append(self._piece(visual.link, shape, visual.pose, visual.colour or _GREY))
                continue
            with self._o3d.utility.VerbosityContextManager(self._o3d.utility.VerbosityLevel.Error):
                model = self._o3d.io.read_triangle_model(str(visual.file))
            for part in model.meshes:
                red, green, blue, opacity = map(float, model.materials[part.material_idx].base_color)
                own = red, green, blue, opacity
                pieces.append(self._piece(visual.link, part.mesh, visual.pose, visual.colour or own, visual.size))
        return tuple(piece for piece in pieces if len(piece.triangles))

    def _shape(self, kind: str, size: tuple[float, ...]) -> Any:
        """Makes triangles of a primitive, with its frame in the middle."""
        make = self._o3d.geometry.TriangleMesh
        if kind == "cylinder":
            return make.create_cylinder(*size, resolution=_ROUND, split=1)
        if kind == "sphere":
            return make.create_sphere(*size, resolution=_ROUND // 2)
        return make.create_box(*size).translate([-side / 2.0 for side in size])

    @staticmethod
    def _piece(link: str, mesh: Any, pose: Pose, colour: Colour, scale: Iterable[float] = (1.0, 1.0, 1.0)) -> _Piece:
        corners = pose.apply(np.asarray(mesh.vertices) * np.asarray(scale))
        return _Piece(link, corners, np.asarray(mesh.triangles, np.uint32), 255.0 * np.asarray(colour[:3]))


def _quads(firsts: Array, size: Array, printed: Print, look: tuple[float, float]) -> _Piece:
    """Returns rectangles of one grey, whose first corners and size are counted in cells."""
    grey, above = look
    corners = firsts[:, None, :] + np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]) * size
    places = np.concatenate([printed.cell * corners.reshape(-1, 2), np.full((4 * len(firsts), 1), -above)], axis=1)
    triangles = (4 * np.arange(len(firsts))[:, None, None] + np.array([(0, 1, 2), (0, 2, 3)])).reshape(-1, 3)
    return _Piece("", printed.pose.apply(places), triangles.astype(np.uint32), np.full(3, 255.0 * grey))


@functools.lru_cache(maxsize=8)
def _rays(k: CameraIntrinsics) -> Floats:
    """Returns the rays of the pixels in the optical frame, shape (height, width, 6); their length is along the axis."""
    u, v = np.meshgrid(np.arange(k.width), np.arange(k.height))
    ways = [(u - k.cx) / k.fx, (v - k.cy) / k.fy, np.ones(u.shape)]
    return np.stack([*[np.zeros(u.shape)] * 3, *ways], axis=-1).astype(np.float32)

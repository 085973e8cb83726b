"""A physically simulated robot cell with its cameras, on any engine."""

from __future__ import annotations

import math
import tempfile
from collections import Counter
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from skiros_py.devices.camera import CameraSpec
from skiros_py.errors import DescriptionError, DeviceError, SkirosError, UnknownName, UsageError
from skiros_py.geometry import Pose
from skiros_py.plugins.loading import find_plugin
from skiros_py.ports.cell import BodySpec, CellSpec, RobotSpec
from skiros_py.ports.device_faults import DeviceModels
from skiros_py.ports.driver import ModelCell
from skiros_py.ports.kinematics import write_robot_urdf
from skiros_py.ports.simulation import Engine, EngineFactory, Rendering, Vector, View
from skiros_py.ports.values import CameraIntrinsics, Commands, DepthImage, Pending, Snapshot
from skiros_py.simulation.imperfections import measured_depth, mounting_error
from skiros_py.simulation.scene import Scene
from skiros_py.system import default_simulation

_OUTSIDE_FOV = 0.8726646259971648  # vertical, 50 degrees [rad]
_OUTSIDE_RANGE = (0.1, 30.0)  # [m]


def depth_image(
    snapshot: Snapshot,
    noise: float,
    seed: tuple[int, ...],
    imperfections: float,
    intrinsics: CameraIntrinsics,
    rendering: Rendering,
) -> DepthImage:
    """Makes the image of a depth camera from a rendering: with its errors, and with what is in range only.

    Args:
        snapshot: What the devices said in the cycle of the picture.
        noise: Standard deviation of a depth [m], at half a metre.
        seed: Seed of the errors.
        imperfections: Factor of what depth cameras have besides noise.
        intrinsics: The camera model.
        rendering: The view without noise.
    """
    depth = measured_depth(rendering.depth, noise, np.random.default_rng(seed), imperfections)
    depth[(depth > intrinsics.far) | (depth < intrinsics.near)] = 0.0
    return DepthImage(snapshot, depth.astype(np.float32), rendering.colour, intrinsics)


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


_LEAST_DISTANCE, _MOST_DISTANCE = 2.0, 25.0
"""From how near and how far the whole cell is shown [m]."""
_GROUP_RADIUS = 0.8
"""Radius within which a robot or a device is about its place [m]."""
_SETTLING = 100  # cycles before cycle 0
_NOISE_STREAM = 2


class SimulatedCell(ModelCell):
    """A :class:`skiros_py.ports.driver.CellDriver` on a physics engine; one physics step per exchange.

    Everything that happens in it is a function of the specification, the seed and the commands. Pictures are rendered
    elsewhere and show exactly the cycle in which they were asked for.

    Args:
        spec: What stands in the cell.
        seed: Seed of everything drawn: poses of bodies without one, errors of the localisers, noise of the cameras.
        engine: The physics engine: its name in the entry-point group ``skiros.engines``, or what builds it; empty for
            PyBullet where it is installed, and MuJoCo elsewhere.
        gui: Open a window.
        imperfections: Factor of the errors that real cells have: of measured poses, of the mounting of cameras, of
            depth images; 0 for none of them.

    Attributes:
        kind: Name of the engine.
        devices: The devices, by id.
        scene: The simulated world itself; for the truth and for tests, never for what a robot decides.

    Raises:
        UsageError: A window is wanted where there is no display.
        UnknownName: The engine, a robot's model or one of its joints does not exist.
        DescriptionError: A body has no pose and no room on its place.
        DeviceError: The engine does not work here.
    """

    coming_to_rest: ClassVar[float] = 0.25  # drives lag behind, and what stands must have been slow for 10 cycles

    def __init__(
        self,
        spec: CellSpec,
        *,
        seed: int,
        engine: str | EngineFactory = "",
        gui: bool = False,
        imperfections: float = 0.0,
    ) -> None:
        super().__init__(spec.devices)
        self._engine = _start_engine(engine or default_simulation(), period=self.period, gui=gui)
        self.kind = self._engine.name
        self._seed = seed
        self._imperfections = imperfections
        self._knocked: dict[str, Pose] = {}
        self._places = [group.start.position for group in spec.groups]
        self._cameras = {camera.id: (robot, camera) for robot in spec.groups for camera in robot.of(CameraSpec)}
        self._shots: Counter[str] = Counter()
        self._directory = tempfile.TemporaryDirectory(prefix="skiros-cell-")
        self._closed = False
        try:
            self.scene = Scene(
                self._engine,
                spec,
                _write_models(spec, Path(self._directory.name)),
                seed=seed,
                imperfections=imperfections,
            )
            models = {id_: model for robot in self.scene.robots for id_, model in robot.devices.items()}
            self._models = DeviceModels(self.devices, models)
            self._snapshot = self._models.start(self._settle)
            if gui:
                self._engine.look_at(*self.overview())
            if self._cameras:
                self._engine.prepare_rendering()  # starts while the caller does other things
        except BaseException:
            self.close()
            raise

    def capture(self, camera: str) -> Pending[DepthImage]:
        """Takes a picture now; the image arrives after the camera's latency.

        Args:
            camera: Device id of the camera.

        Raises:
            DeviceError: No such camera.
        """
        if camera not in self._cameras:
            raise DeviceError(f"no camera '{camera}'; there is {', '.join(sorted(self._cameras)) or 'none'}")
        robot, spec = self._cameras[camera]
        seen = view_of(spec, robot)
        off = mounting_error(camera, self._seed, self._imperfections) @ self._knocked.get(camera, Pose())
        view = replace(seen, pose=seen.pose @ off)
        number = self._shots[camera]
        self._shots[camera] += 1
        seed = (self._seed, _NOISE_STREAM, list(self._cameras).index(camera), number)
        shot = partial(
            depth_image, self._snapshot, spec.noise, seed, self._imperfections, self._engine.intrinsics(view)
        )
        return self._engine.render(view, shot, latency=spec.latency)

    def knock_camera(self, camera: str, to: Pose) -> None:
        """Puts a camera elsewhere than its calibration says, and tells nobody.

        Args:
            camera: Device id of the camera.
            to: Its optical frame from now on, in the frame where it was mounted.
        """
        self._knocked[camera] = to

    def picture(
        self, eye: Vector, target: Vector, *, width: int = 640, height: int = 480
    ) -> Pending[NDArray[np.uint8]]:
        """Makes a picture of the whole scene as it is now, for recordings.

        Args:
            eye: Position of the observer in the map [m].
            target: The point in the map that the observer looks at [m], not straight above or below.
            width: [px].
            height: [px].

        Returns:
            RGB, shape (height, width, 3), when it is ready.
        """
        return self._engine.render(outside_view(eye, target, width, height), colour_of)

    def overview(self) -> tuple[Vector, float]:
        """Returns the middle of everything in the cell and the distance from which all of it can be seen [m]."""
        spheres = [(place, _GROUP_RADIUS) for place in self._places]
        for name, pose in self._engine.poses().items():
            reach = max(float(np.linalg.norm(corner)) for corner in self.scene.body(name).solid.bounds())
            spheres.append((pose.position, reach))
        if not spheres:
            return (0.0, 0.0, 0.0), _LEAST_DISTANCE
        centres, radii = np.array([centre for centre, _ in spheres]), np.array([[radius] for _, radius in spheres])
        low, high = (centres - radii).min(axis=0), (centres + radii).max(axis=0)
        low[2] = max(low[2], 0.0)
        (x, y, z), radius = (low + high) / 2.0, float(np.linalg.norm(high - low)) / 2.0
        distance = radius / math.sin(_OUTSIDE_FOV / 2.0)
        return (float(x), float(y), float(z)), min(max(distance, _LEAST_DISTANCE), _MOST_DISTANCE)

    def move_body(self, body_id: str, pose: Pose) -> None:
        """Puts a body somewhere else in the map, at rest; the robot does not know.

        Raises:
            UnknownName: There is no such body.
            UsageError: The body is bolted to a robot.
        """
        self.scene.move(body_id, pose)

    def remove_body(self, body_id: str) -> None:
        """Takes a body out of the cell; the robot does not know.

        Raises:
            UnknownName: There is no such body.
        """
        self.scene.remove(body_id)

    def add_body(self, spec: BodySpec) -> None:
        """Brings a body into the cell; the robot does not know.

        Raises:
            UsageError: It has no pose, is bolted to a robot, or there is a body of that id.
        """
        if spec.pose is None or spec.carrier is not None:
            raise UsageError(f"'{spec.id}' comes into a running cell, so it needs a pose in the map and no carrier")
        self.scene.add(spec, spec.pose)

    def state_bytes(self) -> bytes:
        """Returns the exact state of all joints and bodies, for a run's hash."""
        return self._engine.state_bytes()

    def close(self) -> None:
        """Ends the engine and its processes; may be called twice."""
        if self._closed:
            return
        self._closed = True
        self._engine.close()
        self._directory.cleanup()

    def _settle(self) -> Snapshot:
        for _ in range(_SETTLING):
            self._step({})
        return Snapshot(0, 0.0, self._models.states())

    def _step(self, commands: Commands) -> None:
        super()._step(commands)
        self._engine.step()


def _start_engine(wanted: str | EngineFactory, *, period: float, gui: bool) -> Engine:
    build: EngineFactory = find_plugin("skiros.engines", wanted) if isinstance(wanted, str) else wanted
    try:
        return build(period=period, gui=gui)
    except SkirosError:
        raise
    except Exception as error:
        raise DeviceError(f"engine {wanted!r} does not start: {type(error).__name__}: {error}") from error


def _write_models(spec: CellSpec, directory: Path) -> dict[str, Path]:
    paths: dict[str, Path] = {}
    for group in spec.groups:
        if group.model and group.model not in paths:
            try:
                paths[group.model] = write_robot_urdf(group.model, directory)
            except UnknownName as error:
                raise DescriptionError(f"sk:model of {group.id}: {error}") from error
    return {group.id: paths[group.model] for group in spec.groups if group.model}

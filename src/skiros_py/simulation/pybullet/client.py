"""One PyBullet client, with its id filled in and its errors translated; solids as its bodies."""

from __future__ import annotations

import contextlib
import functools
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any, cast

import numpy as np

from skiros_py.errors import DeviceError, MissingExtra, UsageError
from skiros_py.geometry import Array, Pose, Primitive, Solid
from skiros_py.ports.simulation import Colour, Vector


class Client:
    """The functions and constants of the pybullet module, for one physics client.

    Functions get the client's id; what pybullet raises leaves here as DeviceError.

    Args:
        gui: Open a window.

    Raises:
        UsageError: A window is wanted where there is no display.
        DeviceError: PyBullet cannot be started as it is needed here.
    """

    def __init__(self, *, gui: bool = False) -> None:
        if gui:
            _require_display()
        self._library = _library()
        if not self._library.isNumpyEnabled():
            raise DeviceError("this build of pybullet lacks numpy support, without which images take seconds")
        mode = self._library.GUI if gui else self._library.DIRECT
        self._id: int = self._library.connect(mode)
        if self._id < 0:
            raise DeviceError("PyBullet did not start a physics server")
        if gui:
            self._library.configureDebugVisualizer(self._library.COV_ENABLE_GUI, 0, physicsClientId=self._id)

    def look_at(self, target: tuple[float, float, float], distance: float) -> None:
        """Turns the window's view to a point of the map, from a distance above [m]; nothing without a window."""
        self._library.resetDebugVisualizerCamera(distance, -35.0, -60.0, target, physicsClientId=self._id)

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._library, name)
        if callable(value):
            value = _translated(functools.partial(value, physicsClientId=self._id), name, self._library.error)
        setattr(self, name, value)  # the next access does not come here
        return value

    def close(self) -> None:
        """Ends the client; may be called twice."""
        if self._id >= 0:
            self._library.disconnect(self._id)
            self._id = -1


def _translated(function: Callable[..., Any], name: str, fault: type[Exception]) -> Callable[..., Any]:
    def call(*args: Any, **kwargs: Any) -> Any:
        try:
            return function(*args, **kwargs)
        except fault as error:
            raise DeviceError(f"PyBullet, {name}: {error}") from error

    return call


def _require_display() -> None:
    # PyBullet ends the whole process when it cannot open its window, so this must be known before.
    if sys.platform == "linux" and not os.environ.get("DISPLAY"):
        raise UsageError(
            "there is no display to open the simulation's window on (DISPLAY is not set); "
            "run without the window and look at recorded pictures instead"
        )


@functools.cache
def _library() -> ModuleType:
    with _quiet_stderr():
        try:
            import pybullet  # heavy, and only who simulates needs it
        except ModuleNotFoundError as error:
            raise MissingExtra("pybullet", "the simulation with PyBullet") from error
        return cast(ModuleType, pybullet)


@contextlib.contextmanager
def _quiet_stderr() -> Iterator[None]:
    """Keeps the build date, which the library prints when it is loaded, off the user's screen."""
    sys.stderr.flush()
    saved = os.dup(2)
    try:
        with open(os.devnull, "wb") as sink:  # noqa: PTH123 - a device, not a path of ours
            os.dup2(sink.fileno(), 2)
        yield
    finally:
        os.dup2(saved, 2)
        os.close(saved)


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
    pieces = [solid.primitives[n : n + _MOST] for n in range(0, len(solid.primitives), _MOST)]
    (collision, visual), *more = [_shape(client, piece, centre, colour, collides=collides) for piece in pieces]
    at, origins, still = pose @ Pose(centre), [(0.0, 0.0, 0.0)] * len(more), [(0.0, 0.0, 0.0, 1.0)] * len(more)
    index: int = client.createMultiBody(
        mass,
        collision,
        visual,
        at.position,
        at.orientation,
        linkMasses=[0.0] * len(more),
        linkCollisionShapeIndices=[collision for collision, _ in more],
        linkVisualShapeIndices=[visual for _, visual in more],
        linkPositions=origins,
        linkOrientations=still,
        linkInertialFramePositions=origins,
        linkInertialFrameOrientations=still,
        linkParentIndices=[0] * len(more),
        linkJointTypes=[client.JOINT_FIXED] * len(more),
        linkJointAxis=origins,
    )
    return index


_MOST = 16
"""PyBullet takes so many primitives for one link, and ends the process when it gets more."""


def _shape(
    client: Client, blocks: Sequence[Primitive], centre: Vector, colour: Colour, *, collides: bool
) -> tuple[int, int]:
    """Makes the shapes of one link, to collide with and to be seen; -1 for none."""
    shapes = _shapes(client, blocks)
    collision = client.createCollisionShapeArray(**_frames(blocks, centre, "collision"), **shapes) if collides else -1
    seen = client.createVisualShapeArray(
        **_frames(blocks, centre, "visual"), **shapes, rgbaColors=[colour] * len(blocks)
    )
    return collision, seen


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

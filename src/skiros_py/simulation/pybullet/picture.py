"""What goes to the renderer: a moment of the scene, and the view of it that is wanted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from skiros_py.geometry import Pose, Solid
from skiros_py.ports.cell import CameraSpec
from skiros_py.ports.values import CameraIntrinsics
from skiros_py.simulation.pybullet.bodies import Colour

__all__ = ["Look", "SceneState", "Shot"]


@dataclass(frozen=True, slots=True)
class Look:
    """How a body looks and where it is in the map."""

    id: str
    solid: Solid
    colour: Colour
    pose: Pose


@dataclass(frozen=True, slots=True)
class SceneState:
    """One moment: all bodies, and the positions of all movable joints of each robot by its id."""

    bodies: tuple[Look, ...]
    robots: Mapping[str, tuple[float, ...]]


@dataclass(frozen=True, slots=True)
class Shot:
    """A picture that a robot's camera takes.

    Attributes:
        robot: Id of the robot that carries the camera.
        camera: The camera.
        intrinsics: Its model.
        cycle: The cycle of the shot.
        arms: Joint positions [rad] by arm id.
        bases: Estimated base poses by base id.
        noise_seed: Seed of this shot's depth noise.
    """

    robot: str
    camera: CameraSpec
    intrinsics: CameraIntrinsics
    cycle: int
    arms: Mapping[str, tuple[float, ...]]
    bases: Mapping[str, Pose]
    noise_seed: tuple[int, ...]

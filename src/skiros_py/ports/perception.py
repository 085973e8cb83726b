"""Ports to perception libraries: which parts lie there, where exactly is this kit, how does it sit in a gripper."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from skiros_py.geometry import Pose, Solid
from skiros_py.ports.motion import Obstacle
from skiros_py.ports.values import DepthImage, Pending


@dataclass(frozen=True, slots=True)
class PartModel:
    """What one type of part looks like."""

    type: str
    solid: Solid


@dataclass(frozen=True, slots=True)
class Region:
    """A flat place to look at.

    Attributes:
        pose: The middle of a rectangle in the map; its frame lies on the surface.
        half_extents: Of the rectangle [m].
        exact: True where the height of the surface is known; otherwise it is a guess (± 0.08 m), and the surface found.
    """

    pose: Pose
    half_extents: tuple[float, float]
    exact: bool = False


@dataclass(frozen=True, slots=True)
class DetectionRequest:
    """One image, to be searched for parts that stand on one surface.

    Attributes:
        image: The shot.
        camera_pose: Pose of the optical frame in the map, as known from joints and localisation.
        region: Where to search; nothing outside is reported.
        models: The types that may lie there.
        seed: Seed of every random choice.
        camera: Id of the camera, for displays; empty if unknown.
    """

    image: DepthImage
    camera_pose: Pose
    region: Region
    models: tuple[PartModel, ...]
    seed: int = 0
    camera: str = ""


@dataclass(frozen=True, slots=True)
class Detection:
    """One thing seen on the surface.

    Attributes:
        type: The type whose shape fits, or None: *unknown*, no shape fits well enough.
        pose: Pose of the solid's frame in the map (for unknown things: of the middle of its box).
        cost: Mean misfit of the best type [m]; smaller is better.
        margin: Misfit of the second best type less that of the best [m].
        size: Length, width, height of the box around it [m].
    """

    type: str | None
    pose: Pose
    cost: float
    margin: float
    size: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class DetectionResult:
    """What one image shows.

    Attributes:
        surface: Height of the support surface in the map [m], or None when no surface was found.
        detections: Things on it, nearest to the region's middle first.
        visible: Share of the region (0 to 1) that the camera saw without anything in between and without being cut
            off by the image border; a look is *clear* when this is high.
    """

    surface: float | None
    detections: tuple[Detection, ...]
    visible: float


class PartDetector(Protocol):
    """Finds and tells apart parts on a flat support."""

    def detect(self, request: DetectionRequest) -> Pending[DetectionResult]:
        """Searches one image."""


@dataclass(frozen=True, slots=True)
class RegistrationRequest:
    """One image in which a known rigid body (a kit) shall be found exactly.

    Attributes:
        image: The shot.
        camera_pose: Pose of the optical frame in the map.
        solid: The body's shape.
        guess: Its believed pose in the map; it stands upright, best within 3 cm and 10 degrees of that, at most
            15 cm from it.
        seed: Seed of every random choice.
        camera: Id of the camera, for displays; empty if unknown.
        body: Id of the body, for displays; empty if unknown.
    """

    image: DepthImage
    camera_pose: Pose
    solid: Solid
    guess: Pose
    seed: int = 0
    camera: str = ""
    body: str = ""


@dataclass(frozen=True, slots=True)
class RegistrationResult:
    """Outcome of a registration.

    Attributes:
        pose: The body's pose in the map, or None when it does not fit what is seen.
        cost: Mean misfit of the points used [m].
        reason: Why there is no pose; empty when there is one.
    """

    pose: Pose | None
    cost: float
    reason: str = ""


class Registrar(Protocol):
    """Finds the exact pose of a known body near a guess."""

    def register(self, request: RegistrationRequest) -> Pending[RegistrationResult]:
        """Registers one body."""


@dataclass(frozen=True, slots=True)
class HeldRequest:
    """One image in which a part between the fingers shall be found exactly.

    Attributes:
        image: The shot, by a camera on the gripper.
        camera_pose: Pose of the optical frame in the frame of the arm's tip.
        solid: The part's shape.
        guess: Its expected pose in the frame of the tip; it may have slid along the pads, and turned between them.
        camera: Id of the camera, for displays; empty if unknown.
        body: Id of the part, for displays; empty if unknown.
        up: Unit vector upwards in the frame of the tip; by default the tip points straight down.
        around: What is known to stand around, in the frame of the tip: seen there, it is not part of what is held.
    """

    image: DepthImage
    camera_pose: Pose
    solid: Solid
    guess: Pose
    camera: str = ""
    body: str = ""
    up: tuple[float, float, float] = (0.0, 0.0, -1.0)
    around: tuple[Obstacle, ...] = ()


@dataclass(frozen=True, slots=True)
class HeldResult:
    """How a part sits in a gripper.

    Attributes:
        pose: Its pose in the frame of the tip, or None when it is not seen there.
        cost: Mean misfit of what was compared [m].
        visible: False where the camera would hardly see the part even if it sat as expected: no pose proves nothing.
        reason: Why there is no pose; empty when there is one.
    """

    pose: Pose | None
    cost: float
    visible: bool
    reason: str = ""


class HeldRegistrar(Protocol):
    """Finds how a part sits in a gripper."""

    def sits(self, request: HeldRequest) -> Pending[HeldResult]:
        """Finds one part."""

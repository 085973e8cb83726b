"""Depth cameras."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar, Self

import numpy as np

from skiros_py.geometry import Pose
from skiros_py.ports.board import DeviceHandle
from skiros_py.ports.device import DeviceSpec, FakeRobot, Individual
from skiros_py.ports.simulation import SimulatedRobot
from skiros_py.ports.values import DepthImage, Pending


@dataclass(frozen=True, slots=True)
class CameraSpec(DeviceSpec[None, None]):
    """A depth camera. It is asked for pictures, not read in each cycle.

    Attributes:
        id: Its element id.
        frame: URDF link of its optical frame; empty for a camera without a robot, whose own frame that is.
        width, height: Image size [px].
        vertical_fov: Vertical field of view [rad].
        near, far: Range of depth [m].
        noise: Standard deviation of depth noise at half a metre [m].
        latency: Time from request to image [s].
        optical: Pose of its optical frame in ``frame``, as a calibration has found it.
    """

    kind: ClassVar[str] = "camera"
    device_class: ClassVar[str] = "sk:Camera"

    frame: str
    width: int
    height: int
    vertical_fov: float
    near: float
    far: float
    noise: float
    latency: float
    optical: Pose = field(default_factory=Pose)

    @classmethod
    def read(cls, individual: Individual) -> Self:
        """Reads its frame, its image and its range."""
        return cls(
            id=individual.id,
            frame=individual.text("sk:frame", "" if individual.owner("sk:Robot") is None else None),
            width=int(individual.number("sk:width")),
            height=int(individual.number("sk:height")),
            vertical_fov=individual.number("sk:verticalFov"),
            near=individual.number("sk:minDepth"),
            far=individual.number("sk:maxDepth"),
            noise=individual.number("sk:depthNoise"),
            latency=individual.number("sk:latency"),
            optical=individual.pose("sk:mounting") or Pose(),
        )

    def fake(self, robot: FakeRobot) -> None:
        """Returns nothing: there is nothing to see without physics."""

    def simulate(self, robot: SimulatedRobot, rng: np.random.Generator) -> None:
        """Returns nothing: the cell renders what it sees when it is asked."""

    @property
    def mounting(self) -> Pose:
        """Where a calibration has found its optical frame."""
        return self.optical

    @property
    def frame_names(self) -> tuple[str, ...]:
        """Its optical frame."""
        return (self.frame,) if self.frame else ()


class Camera(DeviceHandle[CameraSpec, None, None]):
    """A camera in the hands of a primitive."""

    spec_type: ClassVar[Any] = CameraSpec

    def capture(self) -> Pending[DepthImage]:
        """Takes a picture now; it arrives after the camera's latency."""
        return self._board.capture(self.id)

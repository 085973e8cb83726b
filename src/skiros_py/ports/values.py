"""States and targets of all devices of a cell, stamped with the cycle they belong to; pictures; answers on their way.

A device is known by the id of its individual in the world model ("panda_1"), so nothing here names a robot.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from skiros_py.errors import DeviceError
from skiros_py.geometry import Array

T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)


class Pending(Protocol[T_co]):
    """A value that arrives later.

    In lockstep the simulated time between request and use is ``latency``, however long the worker really took: a run is
    a function of its seed.

    Attributes:
        latency: Declared time from request to answer [s].
    """

    @property
    def latency(self) -> float:
        """Declared time from request to answer [s]."""

    def done(self) -> bool:
        """Returns True when :meth:`result` will not block."""

    def result(self) -> T_co:
        """Waits for the answer and returns it.

        Raises:
            DeviceError: The worker died or broke.
        """


@dataclass(frozen=True, slots=True)
class Done(Generic[T]):
    """An answer that is already there; a :class:`Pending`."""

    value: T
    latency: float = 0.0

    def done(self) -> bool:
        """Returns True."""
        return True

    def result(self) -> T:
        """Returns the value."""
        return self.value


Commands = Mapping[str, object]
"""The target of each device that is commanded in one cycle, by device id.

A device without a target does its default safe task: an arm and a base brake within their limits and hold, a gripper
keeps its last target (so that it never lets go by omission).
"""


@dataclass(frozen=True, slots=True)
class Snapshot:
    """Everything all devices said in one cycle; every behaviour of the cycle sees this same value.

    Attributes:
        cycle: Number of the control cycle, from 0.
        time: Time since the start of the run [s]; simulated where the robot is.
        devices: State by device id, of the type that its kind says.
    """

    cycle: int
    time: float
    devices: Mapping[str, Any] = field(default_factory=dict)

    def of(self, type_: type[T]) -> dict[str, T]:
        """Returns the states of one type, by device id."""
        return {device: state for device, state in self.devices.items() if isinstance(state, type_)}

    def state(self, device: str, type_: type[T]) -> T:
        """Returns the state of a device.

        Raises:
            DeviceError: No device of that id says something of that type.
        """
        state = self.devices.get(device)
        if not isinstance(state, type_):
            known = ", ".join(self.of(type_)) or "none"
            raise DeviceError(f"no device '{device}' gives a {type_.__name__}; there is {known}")
        return state


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
        snapshot: What the devices said in the cycle in which it was taken: from it the camera's pose is worked out.
        depth: Distance along the optical axis [m], float32, shape (height, width); 0 where nothing was measured.
        colour: RGB, uint8, shape (height, width, 3).
        intrinsics: The camera's model.
    """

    snapshot: Snapshot
    depth: NDArray[np.float32]
    colour: NDArray[np.uint8]
    intrinsics: CameraIntrinsics

    def points(self) -> Array:
        """Returns the measured points in the optical frame [m], shape (n, 3)."""
        v, u = np.nonzero(self.depth > 0.0)
        z = self.depth[v, u].astype(np.float64)
        k = self.intrinsics
        return np.column_stack([(u - k.cx) / k.fx * z, (v - k.cy) / k.fy * z, z])

"""The port to a robot cell: PyBullet, the fake, later real hardware."""

from __future__ import annotations

from typing import Protocol

from skiros_py.robot.pending import Pending
from skiros_py.robot.values import Commands, DepthImage, Snapshot

__all__ = ["CellDriver"]


class CellDriver(Protocol):
    """All devices of a cell, exchanged once per control cycle."""

    @property
    def period(self) -> float:
        """Length of one control cycle [s]."""
        ...

    @property
    def kind(self) -> str:
        """Name of the adapter ("pybullet", "fake"); skills may have an implementation for one kind only."""
        ...

    def read(self) -> Snapshot:
        """Returns the present state without advancing time."""
        ...

    def exchange(self, commands: Commands) -> Snapshot:
        """Applies the commands for one period and returns what the sensors say at its end.

        Raises:
            DeviceError: A device broke.
        """
        ...

    def capture(self, camera: str) -> Pending[DepthImage]:
        """Takes a picture now; the image arrives after the camera's latency.

        Args:
            camera: Device id of the camera.

        Raises:
            DeviceError: No such camera.
        """
        ...

    def close(self) -> None:
        """Brings everything down; waits for its processes. May be called twice."""
        ...

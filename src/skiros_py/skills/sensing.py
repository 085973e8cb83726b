"""What conditions may ask of devices: the signals of the present cycle's snapshot, by name."""

from __future__ import annotations

from skiros_py.ports.board import DeviceBoard
from skiros_py.world.sensors import Reading

__all__ = ["BoardSensors"]


class BoardSensors:
    """The :class:`~skiros_py.world.sensors.Sensors` of the devices on a board."""

    def __init__(self, board: DeviceBoard) -> None:
        self._board = board

    def read(self, device: str, quantity: str) -> Reading | None:
        """Returns a single value that a device offers in this cycle; None where there is none of that name."""
        spec, states = self._board.devices.get(device), self._board.snapshot.devices
        signal = spec.signal(quantity) if spec is not None and device in states else None
        value = None if signal is None else signal.read(states[device])
        return None if isinstance(value, tuple) else value

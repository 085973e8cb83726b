"""What conditions may ask of devices: the signals of the present cycle, by the device and the name of the quantity."""

from __future__ import annotations

from skiros_py.ports.signals import SignalReader
from skiros_py.world.view import Reading


class SignalSensors:
    """The :class:`~skiros_py.world.view.Sensors` of a cell: a device's quantity is the signal "device.quantity"."""

    def __init__(self, signals: SignalReader) -> None:
        self._signals = signals

    def read(self, device: str, quantity: str) -> Reading | None:
        """Returns a single value in this cycle; None where there is none of that name."""
        value = self._signals.value(f"{device}.{quantity}")
        return None if isinstance(value, tuple) else value

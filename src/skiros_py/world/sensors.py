"""What devices say in this cycle, as a world view gives it: continuous, never stored, unknown to suppositions."""

from __future__ import annotations

from typing import Protocol

__all__ = ["NO_SENSORS", "NoSensors", "Reading", "Sensors"]

Reading = float | bool
"""What a sensor says."""


class Sensors(Protocol):
    """Reads devices by the ids of their individuals."""

    def read(self, device: str, quantity: str) -> Reading | None:
        """Returns what a device says of a quantity ("gap", "force", "still", "x") in this cycle, or None if nothing."""
        ...


class NoSensors:
    """Where nothing can be sensed: snapshots and suppositions, worlds without a robot."""

    def read(self, device: str, quantity: str) -> Reading | None:  # noqa: ARG002 - the port's signature
        """Returns None."""
        return None


NO_SENSORS = NoSensors()
"""Nothing is sensed here."""

"""A robot cell without physics: every device does at once what it is commanded to."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

from skiros_py.errors import DeviceError
from skiros_py.ports.cell import CellSpec
from skiros_py.ports.device import FakeRobot
from skiros_py.ports.driver import ModelCell
from skiros_py.ports.guard import DeviceModels, KindGuard, model_of
from skiros_py.ports.values import Commands, DepthImage, Pending, Snapshot


class FakeCell(ModelCell):
    """A :class:`skiros_py.ports.driver.CellDriver` for trying skills and plans without physics.

    Each device is the fake of its kind. Bodies do not exist: nothing can be seen, held or bumped into.

    Args:
        spec: The cell; its devices are used, its bodies are not.
        seed: Accepted for likeness with a simulated cell; nothing here is drawn.

    Attributes:
        devices: The devices, by id.

    Raises:
        DeviceError: The model of a device cannot be made.
    """

    def __init__(self, spec: CellSpec, *, seed: int = 0) -> None:
        self.seed = seed
        super().__init__(spec.devices)
        self._robots = [(group.carrier, FakeRobot(self.period, group.start)) for group in spec.groups]
        fakes = {
            device.id: model_of(device, "fake", robot)
            for group, (_, robot) in zip(spec.groups, self._robots, strict=True)
            for device in group.devices
        }
        models = {id_: model for id_, model in fakes.items() if model is not None}
        carriers = {carrier.id: models.pop(carrier.id) for carrier, _ in self._robots if carrier is not None}
        self._carriers, self._models = DeviceModels(self.devices, carriers), DeviceModels(self.devices, models)
        self._models.contain(self._carriers.guard)
        self._snapshot = Snapshot(0, 0.0, self._carriers.start(self._states))

    @property
    def kind(self) -> str:
        """Name of the adapter."""
        return "fake"

    @property
    def braking_time(self) -> float:
        """Longest time from full speed to standstill [s]: most stand in the next cycle."""
        return max(self._carriers.braking_time, self._models.braking_time) + self.period

    def _step(self, commands: Commands) -> None:
        for models in (self._carriers, self._models):
            models.command(commands)

    def _states(self) -> dict[str, Any]:
        """Returns the state of each device: first of those that move robots, which say where the others are."""
        states, guard = self._carriers.states(), self._carriers.guard
        for carrier, robot in self._robots:
            if carrier is not None and carrier.id not in guard.off:
                with suppress(DeviceError):  # it is switched off now, and named
                    robot.pose = guard.call(carrier, "pose", states[carrier.id])
        return states | self._models.states()

    def contain(self, guard: KindGuard) -> None:
        """Runs the code of kinds under a guard."""
        for models in (self._carriers, self._models):
            models.contain(guard)

    def capture(self, camera: str) -> Pending[DepthImage]:
        """Refuses: there is nothing to see.

        Raises:
            DeviceError: Always.
        """
        raise DeviceError(f"the fake cell has no camera (asked for '{camera}')")

    def close(self) -> None:
        """Does nothing; there is nothing to bring down."""

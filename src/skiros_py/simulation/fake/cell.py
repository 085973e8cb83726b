"""A robot cell without physics: every device does at once what it is commanded to."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from typing import Any

from skiros_py.errors import DeviceError
from skiros_py.geometry import Pose
from skiros_py.ports.cell import CellSpec
from skiros_py.ports.device import FakeRobot
from skiros_py.ports.device_faults import DeviceModels, model_of
from skiros_py.ports.driver import ModelCell
from skiros_py.ports.values import Commands, DepthImage, Pending, Snapshot


class FakeCell(ModelCell):
    """A :class:`skiros_py.ports.driver.CellDriver` for trying skills and plans without physics.

    Each device is the fake of its kind. Bodies do not exist: nothing can be seen, held or bumped into. Skills that
    only pretend drive nothing: a robot stands where :meth:`stand` puts it.

    Args:
        spec: The cell; its devices are used, its bodies are not.
        seed: Accepted for likeness with a simulated cell; nothing here is drawn.

    Attributes:
        kind: Name of the adapter.
        devices: The devices, by id.

    Raises:
        DeviceError: The model of a device cannot be made.
    """

    kind = "fake"

    def __init__(self, spec: CellSpec, *, seed: int = 0) -> None:
        self.seed = seed
        super().__init__(spec.devices)
        robots = [(group, FakeRobot(self.period, group.start)) for group in spec.groups]
        self._carried = {group.carrier.id: robot for group, robot in robots if group.carrier is not None}
        self._carriers = {group.carrier.id: group.carrier for group in spec.groups if group.carrier is not None}
        self._to_stand: dict[str, Pose] = {}
        fakes = {device.id: model_of(device, "fake", robot) for group, robot in robots for device in group.devices}
        order = sorted(fakes, key=lambda id_: id_ not in self._carried)  # what moves a robot says where its others are
        models = {id_: model for id_ in order if (model := fakes[id_]) is not None}
        self._models = DeviceModels(self.devices, models, self._move_robot)
        self._snapshot = Snapshot(0, 0.0, self._models.start(self._models.states))

    def stand(self, device: str, pose: Pose) -> None:
        """Lets a device that carries its robot stand elsewhere in the map from the next cycle on; for any thread."""
        self._to_stand[device] = pose

    def _step(self, commands: Commands) -> None:
        while self._to_stand:
            device, start = self._to_stand.popitem()
            with suppress(DeviceError):  # it is switched off now, and named
                elsewhere = replace(self._carriers[device], start=start)
                self._models.models[device] = self._models.guard.call(elsewhere, "fake", self._carried[device])
        super()._step(commands)

    def _move_robot(self, device: str, state: Any) -> None:
        if device in self._carried:
            with suppress(DeviceError):  # it is switched off now, and named
                self._carried[device].pose = self._models.guard.call(self.devices[device], "pose", state)

    def capture(self, camera: str) -> Pending[DepthImage]:
        """Refuses: there is nothing to see.

        Raises:
            DeviceError: Always.
        """
        raise DeviceError(f"the fake cell has no camera (asked for '{camera}')")

    def close(self) -> None:
        """Does nothing; there is nothing to bring down."""

"""A robot cell without physics: every device does at once what it is told."""

from __future__ import annotations

from functools import partial

from skiros_py.errors import DeviceError
from skiros_py.ports.cell import CellSpec
from skiros_py.ports.driver import command_models, model_of, require_known, states_of
from skiros_py.ports.values import Commands, DepthImage, Pending, Snapshot

_PERIOD = 1.0 / 200.0


class FakeCell:
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
        self.devices = spec.devices
        self._halted = False
        fakes = {id_: model_of(device, partial(device.fake, _PERIOD)) for id_, device in self.devices.items()}
        self._models = {id_: model for id_, model in fakes.items() if model is not None}
        self._snapshot = Snapshot(0, 0.0, states_of(self._models, self.devices))

    @property
    def period(self) -> float:
        """Length of one control cycle [s]."""
        return _PERIOD

    @property
    def kind(self) -> str:
        """Name of the adapter."""
        return "fake"

    @property
    def braking_time(self) -> float:
        """Longest time from full speed to standstill [s]: most stand in the next cycle."""
        return max((model.braking_time for model in self._models.values()), default=0.0) + _PERIOD

    def read(self) -> Snapshot:
        """Returns the present state without advancing time."""
        return self._snapshot

    def exchange(self, commands: Commands) -> Snapshot:
        """Does what the commands say and returns the state one period later.

        Raises:
            DeviceError: A command is for a device that does not exist, or the model of a device broke.
        """
        require_known(commands, self._models)
        command_models(self._models, self.devices, {} if self._halted else commands)
        cycle = self._snapshot.cycle + 1
        self._snapshot = Snapshot(cycle, cycle * _PERIOD, states_of(self._models, self.devices))
        return self._snapshot

    def halt(self) -> None:
        """Stands still from the next exchange on, whatever is commanded; for any thread."""
        self._halted = True

    def release(self) -> None:
        """Obeys commands again."""
        self._halted = False

    def capture(self, camera: str) -> Pending[DepthImage]:
        """Refuses: there is nothing to see.

        Raises:
            DeviceError: Always.
        """
        raise DeviceError(f"the fake cell has no camera (asked for '{camera}')")

    def close(self) -> None:
        """Does nothing; there is nothing to bring down."""

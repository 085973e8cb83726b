"""The port to a robot cell: PyBullet, the fake, later real hardware."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any, Protocol, TypeVar

from skiros_py.errors import DeviceError, SkirosError
from skiros_py.ports.device import DeviceModel, DeviceSpec
from skiros_py.ports.kinds import load_device_kinds
from skiros_py.ports.pending import Pending
from skiros_py.ports.values import Commands, DepthImage, Snapshot

T = TypeVar("T")


class CellDriver(Protocol):
    """All devices of a cell, exchanged once per control cycle."""

    @property
    def period(self) -> float:
        """Length of one control cycle [s]."""
        ...

    @property
    def devices(self) -> Mapping[str, DeviceSpec[Any, Any]]:
        """The devices that it drives, by id."""
        ...

    @property
    def kind(self) -> str:
        """Name of the adapter ("pybullet", "fake"); skills may have an implementation for one kind only."""
        ...

    @property
    def braking_time(self) -> float:
        """Longest time from full speed to standstill, as its snapshots say it, when commands cease [s]."""
        ...

    def read(self) -> Snapshot:
        """Returns the present state without advancing time."""
        ...

    def exchange(self, commands: Commands) -> Snapshot:
        """Applies the commands for one period and returns what the sensors say at its end.

        While the cell is halted it ignores the commands.

        Raises:
            DeviceError: A device broke.
        """
        ...

    def halt(self) -> None:
        """Brakes everything and ignores all commands until :meth:`release`; what is gripped stays gripped.

        May be called in any thread and at any time, also during :meth:`exchange`; returns at once and waits for
        nothing. A simulation, whose time stands still between two exchanges, brakes with the next one.
        """
        ...

    def release(self) -> None:
        """Obeys commands again; nothing moves by that alone."""
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


def require_known(commands: Commands, known: Collection[str]) -> None:
    """Refuses commands for devices that a driver does not have.

    Raises:
        DeviceError: There is one.
    """
    for device in commands:
        if device not in known:
            raise DeviceError(f"no device '{device}'; there is {', '.join(sorted(known)) or 'none'}")


def model_of(device: DeviceSpec[Any, Any], make: Callable[[], T]) -> T:
    """Returns the model of a device that its kind makes.

    Raises:
        DeviceError: The kind raised something else than an error of the platform.
    """
    try:
        return make()
    except SkirosError:
        raise
    except Exception as error:
        raise _broken(device, error) from error


def command_models(
    models: Mapping[str, DeviceModel], devices: Mapping[str, DeviceSpec[Any, Any]], commands: Commands
) -> None:
    """Gives each model its target, or None.

    Raises:
        DeviceError: A model raised; the message names the device and its kind.
    """
    for id_, model in models.items():
        try:
            model.command(commands.get(id_))
        except SkirosError:
            raise
        except Exception as error:
            raise _broken(devices[id_], error) from error


def states_of(models: Mapping[str, DeviceModel], devices: Mapping[str, DeviceSpec[Any, Any]]) -> dict[str, Any]:
    """Returns the state of each model.

    Raises:
        DeviceError: A model raised, or gave no state of its kind; the message names the device and its kind.
    """
    states = {}
    for id_, model in models.items():
        device = devices[id_]
        try:
            state = states[id_] = model.state()
        except SkirosError:
            raise
        except Exception as error:
            raise _broken(device, error) from error
        wanted = device.state_type
        if wanted is not None and not isinstance(state, wanted):
            text = f"its state is a {wanted.__name__}, not {state!r:.60}"
            raise DeviceError(f"{_described(device)} broke: {text}")
    return states


def _broken(device: DeviceSpec[Any, Any], error: Exception) -> DeviceError:
    return DeviceError(f"{_described(device)} broke: {type(error).__name__}: {error}")


def _described(device: DeviceSpec[Any, Any]) -> str:
    return load_device_kinds()[0].describe(device.id, type(device))

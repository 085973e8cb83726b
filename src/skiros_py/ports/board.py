"""The devices in one control cycle: what they said, what they are told, and the handles by which primitives do both."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, ClassVar, Generic, Protocol, TypeVar, cast

from skiros_py.errors import DeviceError
from skiros_py.ports.device import DeviceSpec
from skiros_py.ports.driver import CellDriver
from skiros_py.ports.pending import Pending
from skiros_py.ports.values import DepthImage, Snapshot

T = TypeVar("T")
SpecT = TypeVar("SpecT", bound=DeviceSpec[Any, Any])
StateT = TypeVar("StateT")
TargetT = TypeVar("TargetT")


class Commander(Protocol):
    """Whoever commands devices: a task of the control cycle.

    Attributes:
        devices: The devices that it may command; None for all.
    """

    devices: frozenset[str] | None

    @property
    def rate(self) -> float:
        """How fast its time goes: 1 in general, less while it is being paused."""
        ...


class DeviceBoard:
    """The snapshot of the present cycle and the commands collected for the next one.

    Attributes:
        devices: The devices, by id.
        snapshot: What the devices said.
        owner: Who is commanding now; None outside the control cycle's tasks.
        commanders: Who commanded a device last, by its id.
    """

    def __init__(self, driver: CellDriver) -> None:
        self._driver = driver
        self.snapshot: Snapshot = driver.read()
        self.devices = driver.devices
        self._targets: dict[str, object] = {}
        self.owner: Commander | None = None
        self.commanders: dict[str, Commander | None] = {}

    @property
    def now(self) -> float:
        """Time since the start of the run [s]."""
        return self.snapshot.time

    @property
    def period(self) -> float:
        """Length of one control cycle [s]."""
        return self._driver.period

    @property
    def braking_time(self) -> float:
        """Longest time from full speed to standstill [s]."""
        return self._driver.braking_time

    def exchange(self) -> Snapshot:
        """Sends the collected commands for one period, forgets them, and takes the new snapshot."""
        commands, self._targets = self._targets, {}
        self.snapshot = self._driver.exchange(commands)
        return self.snapshot

    @property
    def still(self) -> bool:
        """True when nothing moves that could be stopped."""
        return not self._moving(self.snapshot.devices)

    def moving(self, commander: Commander) -> list[str]:
        """Returns the ids of the devices that move and that this commander was the last to command."""
        return self._moving(device for device, other in self.commanders.items() if other is commander)

    def standing(self, commander: Commander) -> bool:
        """Returns True when nothing moves any more of what this commander was the last to command."""
        return not self.moving(commander)

    def stand(self, devices: Iterable[str]) -> bool:
        """Returns True when none of these devices moves."""
        return not self._moving(devices)

    def _moving(self, devices: Iterable[str]) -> list[str]:
        states = self.snapshot.devices
        return [one for one in devices if one in states and not self.devices[one].still(states[one])]

    def withdraw(self, commander: Commander) -> None:
        """Takes back what a commander has commanded for the coming cycle: its devices brake."""
        self.clear(device for device, other in self.commanders.items() if other is commander)

    def clear(self, devices: Iterable[str]) -> None:
        """Takes back the commands for some devices for the coming cycle: they brake."""
        for device in devices:
            self._targets.pop(device, None)

    def halt(self) -> None:
        """Brakes everything until :meth:`release`; for any thread."""
        self._driver.halt()

    def release(self) -> None:
        """Lets devices obey commands again."""
        self._driver.release()

    @property
    def rate(self) -> float:
        """How fast the time of whoever commands now goes."""
        return 1.0 if self.owner is None else self.owner.rate

    def send(self, device: str, target: object) -> None:
        """Takes a target of a device for the coming cycle; a speed slows down while the run is being paused.

        Raises:
            DeviceError: It is no target of that device, or whoever commands has not taken the device.
        """
        if device not in self.devices:
            raise DeviceError(f"no device '{device}' answers; there is {', '.join(self.devices) or 'none'}")
        spec, owner, rate = self.devices[device], self.owner, self.rate
        spec.check(target)
        if owner is not None and owner.devices is not None and device not in owner.devices:
            has = ", ".join(sorted(owner.devices)) or "none"
            raise DeviceError(
                f"{device} is not among the devices that were taken ({has}): name it in a parameter of kind HARDWARE, "
                "or take what has it (takes)"
            )
        self.commanders[device] = owner
        self._targets[device] = target if rate == 1.0 else spec.scaled(target, rate)

    def limited(self, devices: frozenset[str], action: Callable[[], T]) -> T:
        """Does something in which whoever commands may command these devices only."""
        owner = self.owner
        if owner is None:
            return action()
        before, owner.devices = owner.devices, devices
        try:
            return action()
        finally:
            owner.devices = before

    def capture(self, camera: str) -> Pending[DepthImage]:
        """Takes a picture now."""
        return self._driver.capture(camera)


class DeviceHandle(Generic[SpecT, StateT, TargetT]):
    """A device in the hands of a primitive; kinds have subclasses of it where a primitive needs more.

    Class attributes:
        spec_type: The kind that it is for; any where it is the base class.

    Args:
        board: The board.
        device: Id of the device.

    Attributes:
        id: Id of the device.
        spec: Its description.

    Raises:
        DeviceError: There is no such device of that kind.
    """

    spec_type: ClassVar[Any] = DeviceSpec

    def __init__(self, board: DeviceBoard, device: str) -> None:
        self._board = board
        self.id = device
        spec = board.devices.get(device)
        if not isinstance(spec, self.spec_type):
            there = ", ".join(id_ for id_, one in board.devices.items() if isinstance(one, self.spec_type))
            kind = getattr(self.spec_type, "kind", "device")
            raise DeviceError(f"no {kind} '{device}' answers; there is {there or 'none'}")
        self.spec: SpecT = cast("SpecT", spec)

    @property
    def state(self) -> StateT:
        """What it says in this cycle.

        Raises:
            DeviceError: It has no state, or has not answered.
        """
        snapshot = self._board.snapshot
        if self.id not in snapshot.devices:
            raise DeviceError(f"{self.id} says nothing in each cycle")
        return cast("StateT", snapshot.devices[self.id])

    def command(self, target: TargetT) -> None:
        """Sets its target for the coming cycle.

        Raises:
            DeviceError: It is no such target, or whoever commands has not taken the device.
        """
        self._board.send(self.id, target)

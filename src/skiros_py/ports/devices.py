"""What a primitive holds in its hands: one handle per device, reading this cycle's snapshot, writing its commands."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from itertools import chain
from typing import Protocol, TypeVar

from skiros_py.errors import DeviceError
from skiros_py.ports.driver import CellDriver
from skiros_py.ports.pending import Pending
from skiros_py.ports.values import (
    ArmState,
    ArmTarget,
    BaseState,
    BaseTwist,
    Commands,
    DepthImage,
    GripperState,
    GripperTarget,
    Snapshot,
)

__all__ = ["Arm", "Base", "Camera", "Commander", "DeviceBoard", "Gripper"]

T = TypeVar("T")


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
        snapshot: What the devices said.
        owner: Who is commanding now; None outside the control cycle's tasks.
        commanders: Who commanded a device last, by its id.
    """

    def __init__(self, driver: CellDriver) -> None:
        self._driver = driver
        self.snapshot: Snapshot = driver.read()
        self._arms: dict[str, ArmTarget] = {}
        self._grippers: dict[str, GripperTarget] = {}
        self._bases: dict[str, BaseTwist] = {}
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
        commands = Commands(self._arms, self._grippers, self._bases)
        self._arms, self._grippers, self._bases = {}, {}, {}
        self.snapshot = self._driver.exchange(commands)
        return self.snapshot

    @property
    def still(self) -> bool:
        """True when nothing moves that could be stopped: every arm and every base stands."""
        snapshot = self.snapshot
        return all(arm.still for arm in snapshot.arms.values()) and all(b.still for b in snapshot.bases.values())

    def moving(self, commander: Commander) -> list[str]:
        """Returns the ids of the arms and bases that move and that nobody else has commanded since."""
        return self._moving(device for device, other in self.commanders.items() if other is commander)

    def standing(self, commander: Commander) -> bool:
        """Returns True when nothing moves any more of what this commander was the last to command."""
        return not self.moving(commander)

    def stand(self, devices: Iterable[str]) -> bool:
        """Returns True when none of these devices moves."""
        return not self._moving(devices)

    def _moving(self, devices: Iterable[str]) -> list[str]:
        drives: dict[str, ArmState | BaseState] = {**self.snapshot.arms, **self.snapshot.bases}
        return [device for device in devices if device in drives and not drives[device].still]

    def withdraw(self, commander: Commander) -> None:
        """Takes back what a commander has commanded for the coming cycle: its devices brake."""
        self.clear(device for device, other in self.commanders.items() if other is commander)

    def clear(self, devices: Iterable[str]) -> None:
        """Takes back the commands for some devices for the coming cycle: they brake."""
        for device in devices:
            self._arms.pop(device, None)
            self._grippers.pop(device, None)
            self._bases.pop(device, None)

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

    def send(self, device: str, target: ArmTarget | GripperTarget | BaseTwist) -> None:
        """Takes a command of a device for the coming cycle.

        Raises:
            DeviceError: Whoever commands has not taken the device.
        """
        owner = self.owner
        if owner is not None and owner.devices is not None and device not in owner.devices:
            has = ", ".join(sorted(owner.devices)) or "none"
            raise DeviceError(
                f"{device} is not among the devices that were taken ({has}): name it in a parameter of kind HARDWARE, "
                "or take what has it (takes)"
            )
        self.commanders[device] = owner
        match target:
            case ArmTarget():
                self._arms[device] = target
            case GripperTarget():
                self._grippers[device] = target
            case BaseTwist():
                self._bases[device] = target

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


class Arm:
    """One arm."""

    def __init__(self, board: DeviceBoard, device: str) -> None:
        self._board = board
        self.id = _known(device, board.snapshot.arms, "arm")

    @property
    def state(self) -> ArmState:
        """Its joints in this cycle."""
        return self._board.snapshot.arms[self.id]

    def command(self, target: ArmTarget) -> None:
        """Sets where the joints shall be at the end of the coming cycle.

        Sample a motion by the clock of the run: then it brakes along its own path when the run is paused.

        Raises:
            DeviceError: It is no such command, or a number is missing or is none.
        """
        _require_kind(self.id, target, ArmTarget)
        _require_numbers(self.id, target, target.positions, target.velocities)
        if len(target.positions) != len(self.state.positions) or len(target.velocities) != len(target.positions):
            count = len(self.state.positions)
            raise DeviceError(f"{self.id}: a target needs {count} positions and {count} velocities: {target}")
        self._board.send(self.id, target)


class Gripper:
    """One parallel gripper."""

    def __init__(self, board: DeviceBoard, device: str) -> None:
        self._board = board
        self.id = _known(device, board.snapshot.grippers, "gripper")

    @property
    def state(self) -> GripperState:
        """Its fingers in this cycle."""
        return self._board.snapshot.grippers[self.id]

    def command(self, target: GripperTarget) -> None:
        """Moves the fingers; the target stays in force until it is replaced.

        Raises:
            DeviceError: It is no such command, or a number is none.
        """
        _require_kind(self.id, target, GripperTarget)
        _require_numbers(self.id, target, (target.gap, target.force))
        self._board.send(self.id, target)


class Base:
    """One mobile base."""

    def __init__(self, board: DeviceBoard, device: str) -> None:
        self._board = board
        self.id = _known(device, board.snapshot.bases, "base")

    @property
    def state(self) -> BaseState:
        """Its estimated pose and its speeds in this cycle."""
        return self._board.snapshot.bases[self.id]

    def command(self, twist: BaseTwist) -> None:
        """Sets its speeds for the coming cycle; without a command it brakes, and it slows down while the run is paused.

        Raises:
            DeviceError: It is no such command, or a number is none.
        """
        _require_kind(self.id, twist, BaseTwist)
        _require_numbers(self.id, twist, (twist.linear, twist.angular))
        rate = self._board.rate
        if rate != 1.0:
            twist = BaseTwist(twist.linear * rate, twist.angular * rate)
        self._board.send(self.id, twist)


class Camera:
    """One depth camera; it is asked for pictures, not read each cycle."""

    def __init__(self, board: DeviceBoard, device: str) -> None:
        self._board = board
        self.id = device

    def capture(self) -> Pending[DepthImage]:
        """Takes a picture now; it arrives after the camera's latency."""
        return self._board.capture(self.id)


def _known(device: str, devices: object, kind: str) -> str:
    names = list(devices) if hasattr(devices, "__iter__") else []
    if device not in names:
        raise DeviceError(f"no {kind} '{device}' answers; there is {', '.join(names) or 'none'}")
    return device


def _require_kind(device: str, command: object, kind: type) -> None:
    if not isinstance(command, kind):
        raise DeviceError(f"{device}: it is commanded by a {kind.__name__}, not by {command!r:.100}")


def _require_numbers(device: str, command: object, *numbers: Iterable[float]) -> None:
    """Refuses a malformed command where it is given, so that the fault is its author's and not the whole cell's."""
    try:
        good = all(map(math.isfinite, chain(*numbers)))
    except TypeError:
        good = False
    if not good:
        raise DeviceError(f"{device}: a command is made of finite numbers: {command}")

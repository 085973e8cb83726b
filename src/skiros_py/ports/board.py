"""The devices in one control cycle: their states, the commands for the next cycle, and the handles of primitives."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from typing import Any, ClassVar, Generic, Protocol, TypeVar, cast

from skiros_py.errors import DeviceError
from skiros_py.geometry import Pose
from skiros_py.ports.device import Contribution, DeviceSpec, Follower, MobileSpec
from skiros_py.ports.device_faults import KindGuard, has_nan
from skiros_py.ports.driver import CellDriver, RunsKinds, contain_kinds, exchange_with
from skiros_py.ports.paths import Path
from skiros_py.ports.values import DepthImage, Pending, Snapshot

T = TypeVar("T")
SpecT = TypeVar("SpecT", bound=DeviceSpec[Any, Any])
StateT = TypeVar("StateT")
TargetT = TypeVar("TargetT")


class Commander(Protocol):
    """A task of the control cycle, which commands devices.

    Attributes:
        devices: The devices that it may command; None for all.
    """

    devices: frozenset[str] | None

    @property
    def rate(self) -> float:
        """How fast its time goes: 1 in general, less while it is being paused."""


class Share(Protocol):
    """The devices of one run of a module.

    Attributes:
        owner: Name of the module, for messages.
        devices: All devices that the run may command.
        shared: Those of them that other runs may command in the same cycle.
    """

    owner: str
    devices: frozenset[str]
    shared: frozenset[str]


class DeviceBoard:
    """The snapshot of the current cycle and the commands collected for the next one.

    Commands for a device with one owner go straight to the driver. Commands for a shared device are collected by run;
    :class:`~skiros_py.execution.command_mixing.Mix` merges them into one target before the exchange.

    Attributes:
        guard: Contains the code of kinds of device; knows which devices were switched off.
        devices: The devices, by id.
        period: Length of one control cycle [s].
        snapshot: What the devices said.
        owner: The task that is commanding now; None outside the control cycle's tasks.
        share: The devices of the run whose code is executing; None outside a primitive.
        commanders: The task that commanded a device last, by the device's id.
        shared: What runs want of shared devices in the coming cycle, by device and run; mostly empty.
        unmixed: Why a kind's mix rule was switched off, by kind.
        closed: Ids of devices that were closed: they take no commands and no modules.

    Raises:
        DeviceError: The driver has no state of a device, or one of another type than the device's kind says.
    """

    def __init__(self, driver: CellDriver) -> None:
        self.guard = KindGuard()
        contain_kinds(driver, self.guard)
        self._driver = driver
        self.snapshot: Snapshot = driver.read()
        self.devices, self.period = driver.devices, driver.period
        self._types = {id_: spec.state_type for id_, spec in self.devices.items() if spec.state_type is not None}
        self._trusted = isinstance(driver, RunsKinds)  # its states come through the guard already
        if wrong := self._wrong_states(self.snapshot):
            raise DeviceError("; ".join(f"{id_}: {why}" for id_, why in wrong.items()))
        self._targets: dict[str, object] = {}
        self.owner: Commander | None = None
        self.share: Share | None = None
        self.commanders: dict[str, Commander | None] = {}
        self.shared: dict[str, dict[Share, tuple[Commander | None, Contribution[Any]]]] = {}
        self.unmixed: dict[str, str] = {}
        self.closed: set[str] = set()

    @property
    def now(self) -> float:
        """Time since the start of the run [s]."""
        return self.snapshot.time

    @property
    def braking_time(self) -> float:
        """Longest time from full speed to standstill [s]."""
        return self._driver.braking_time

    def exchange(self) -> Snapshot:
        """Sends the collected commands for one period, forgets them, and takes the new snapshot."""
        commands, self._targets = self._targets, {}
        for device in self.guard.off:
            commands.pop(device, None)
        last, now = self.snapshot, exchange_with(self._driver, commands, self.snapshot)
        if wrong := self._wrong_states(now):
            for device, why in wrong.items():
                self.guard.switch_off(self.devices[device], why)
            now = replace(now, devices={**now.devices, **{device: last.devices[device] for device in wrong}})
        self.snapshot = now
        return now

    def _wrong_states(self, now: Snapshot) -> dict[str, str]:
        """Returns what is wrong with states, by device."""
        states, wrong = now.devices, {}
        for device, type_ in self._types.items():
            state = states.get(device)
            if not isinstance(state, type_) or (not self._trusted and has_nan(state)):
                right = f"a {type_.__name__} with numbers"
                wrong[device] = f"driver '{self._driver.kind}' gave the state {state!r:.80}, not {right}"
        return wrong

    @property
    def still(self) -> bool:
        """True when nothing moves that could be stopped."""
        return not self._moving(self.snapshot.devices)

    def moving(self, commander: Commander) -> list[str]:
        """Returns the ids of the devices that move and that this commander was the last to command."""
        return self._moving(device for device, other in self.commanders.items() if other is commander)

    def stand(self, devices: Iterable[str]) -> bool:
        """Returns True when none of these devices moves."""
        return not self._moving(devices)

    def _moving(self, devices: Iterable[str]) -> list[str]:
        states, off = self.snapshot.devices, self.guard.off
        return [one for one in devices if one in states and one not in off and not self._still(one)]

    def _still(self, device: str) -> bool:
        try:
            return bool(self.guard.call(self.devices[device], "still", self.snapshot.devices[device]))
        except DeviceError:  # it is switched off: nothing can say whether it moves
            return True

    def withdraw(self, commander: Commander) -> None:
        """Takes back what a task has commanded for the coming cycle: devices that no other run commands brake."""
        for device, other in self.commanders.items():
            if other is commander:
                self._targets.pop(device, None)
        for runs in self.shared.values():
            for run in [run for run, (task, _) in runs.items() if task is commander]:
                del runs[run]

    def clear(self, share: Share) -> None:
        """Takes back what a run has commanded for the coming cycle: devices that no other run commands brake."""
        for device in share.devices:
            if device in share.shared:
                self.shared.get(device, {}).pop(share, None)
            else:
                self._targets.pop(device, None)

    def set_target(self, device: str, target: object) -> None:
        """Sets the target to which the commands for a shared device were merged."""
        self._targets[device] = target

    def halt(self) -> None:
        """Brakes everything until :meth:`release`; for any thread."""
        self._driver.halt()

    def release(self) -> None:
        """Lets devices obey commands again."""
        self._driver.release()

    @property
    def rate(self) -> float:
        """Rate of the clock of the task that commands now."""
        return 1.0 if self.owner is None else self.owner.rate

    def send(self, device: str, target: object, weight: float = 1.0) -> None:
        """Takes a target of a device for the coming cycle; a speed slows down while the run is being paused.

        Args:
            device: Id of the device.
            target: The target.
            weight: Its weight among the runs that share the device; without effect where the device has one owner.

        Raises:
            DeviceError: It is no target of that device, the run has not taken the device, or the mix rule of a shared
                device was switched off.
        """
        if device not in self.devices:
            raise DeviceError(f"no device '{device}' answers; there is {', '.join(self.devices) or 'none'}")
        self.require_open(device)
        spec, owner, share, rate = self.devices[device], self.owner, self.share, self.rate
        self.guard.attempt(spec, "check", partial(spec.check, target))
        allowed = None if owner is None else owner.devices if share is None else share.devices
        if allowed is not None and device not in allowed:
            has = ", ".join(sorted(allowed)) or "none"
            raise DeviceError(
                f"{device} is not among the devices that were taken ({has}): name it in a parameter of kind HARDWARE, "
                "or take what has it (takes)"
            )
        if rate != 1.0:
            target = self.guard.call(spec, "scaled", target, rate)
        if share is None or device not in share.shared:
            self._targets[device] = target
        else:
            if spec.kind in self.unmixed:
                raise DeviceError(f"{device} cannot be shared: {self.unmixed[spec.kind]}")
            if not 0.0 < weight < math.inf:
                raise DeviceError(f"{device}: the weight of a command is a positive number, not {weight!r}")
            self.shared.setdefault(device, {})[share] = owner, Contribution(share.owner, target, weight)
        self.commanders[device] = owner

    def require_open(self, device: str) -> None:
        """Requires that a device may be used.

        Raises:
            DeviceError: It was closed or switched off.
        """
        self.guard.require(device)
        if device in self.closed:
            raise DeviceError(f"{device} is closed: open it first")

    def limited(self, share: Share, action: Callable[[], T]) -> T:
        """Does something in which only the devices of a run may be commanded, in the name of that run."""
        outer, self.share = self.share, share
        try:
            return action()
        finally:
            self.share = outer

    def capture(self, camera: str) -> Pending[DepthImage]:
        """Takes a picture now.

        Raises:
            DeviceError: The camera was closed.
        """
        self.require_open(camera)
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
        DeviceError: There is no such device of that kind, or it was closed.
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
        board.require_open(device)
        self.spec: SpecT = cast("SpecT", spec)

    @property
    def state(self) -> StateT:
        """What it says in this cycle.

        Raises:
            DeviceError: It has no state, or was switched off.
        """
        snapshot = self._board.snapshot
        self._board.guard.require(self.id)
        if self.id not in snapshot.devices:
            raise DeviceError(f"{self.id} says nothing in each cycle")
        return cast("StateT", snapshot.devices[self.id])

    def command(self, target: TargetT, weight: float = 1.0) -> None:
        """Sets its target for the coming cycle.

        Args:
            target: The target.
            weight: Its weight among the runs that share the device.

        Raises:
            DeviceError: It is no such target, the run has not taken the device, or it can no longer be shared.
        """
        self._board.send(self.id, target, weight)


class Mobile(DeviceHandle[MobileSpec[Any, Any], Any, Any]):
    """A base of any kind in the hands of a primitive."""

    spec_type: ClassVar[Any] = MobileSpec

    def direct_path(self, start: Pose, goal: Pose) -> Path:
        """Returns the path on which it drives a short way; see :meth:`MobileSpec.direct_path`.

        Raises:
            DeviceError: Its kind broke, and it was switched off.
        """
        return self._board.guard.attempt(self.spec, "direct_path", partial(self.spec.direct_path, start, goal))

    def follow(self, path: Path, pose: Callable[[], Pose], **limits: float) -> Follower[Any]:
        """Follows a path; see :meth:`MobileSpec.follow`.

        Raises:
            DeviceError: It follows no such path; or its kind broke, and it was switched off.
        """
        attempt, spec = self._board.guard.attempt, self.spec
        follower = attempt(spec, "follow", partial(spec.follow, path, pose, **limits))
        while True:
            try:
                yield attempt(spec, "follow", partial(next, follower))
            except StopIteration as end:
                return bool(end.value)

    @property
    def still(self) -> bool:
        """True when it stands."""
        return self._board.stand([self.id])

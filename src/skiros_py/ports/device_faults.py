"""Runs the code of kinds of device, so that an error in it switches off one device, by name, and nothing else."""

from __future__ import annotations

import dataclasses
import inspect
import logging
import math
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from functools import lru_cache, partial
from itertools import chain
from threading import get_ident
from typing import Any, TypeVar

import numpy as np

from skiros_py.errors import DeviceError, SkirosError
from skiros_py.geometry import Pose
from skiros_py.interruptions import Activity, CycleOverrun, limited
from skiros_py.ports.device import DeviceModel, DeviceSpec, LocalisingSpec, MobileSpec, WiredModel
from skiros_py.ports.device_kinds import load_device_kinds
from skiros_py.ports.values import Commands

T = TypeVar("T")
_log = logging.getLogger(__name__)

_LONGEST = 30.0
"""Wall time that a function of a kind may take outside the control cycle [s]."""


class KindGuard:
    """Calls functions of kinds of device; one that raises, hangs or returns NaN switches its device off.

    Until the next reset a device that is switched off keeps its last state, takes no commands and offers no signals; it
    brakes, as far as its model still can. If it cannot, everything is halted.

    Attributes:
        activity: What the control thread is doing, for the watchdog.
        off: Why devices were switched off, by id.
        uncontrolled: Ids of devices whose models take no commands, not even to brake.
        halt: Halts everything, with a reason.
        calling: Device and function whose code a task is running; None for none.
    """

    def __init__(self) -> None:
        self.activity = Activity()
        self.off: dict[str, str] = {}
        self.uncontrolled: set[str] = set()
        self.halt: Callable[[str], None] = lambda _reason: None
        self.calling: tuple[DeviceSpec[Any, Any], str] | None = None
        self._poses: dict[str, tuple[Any, Pose]] = {}

    def switch_off(self, device: DeviceSpec[Any, Any], why: str) -> DeviceError:
        """Switches a device off; returns the error for those who use it."""
        if device.id not in self.off:
            self.off[device.id] = f"{described(device)} was switched off: {why}"
            _log.error("%s", self.off[device.id])
        return DeviceError(self.off[device.id])

    def give_up(self, device: DeviceSpec[Any, Any], why: str) -> None:
        """Switches off a device that cannot be braked either; halts everything."""
        self.uncontrolled.add(device.id)
        self.halt(str(self.switch_off(device, why)))

    def require(self, device: str) -> None:
        """Requires that a device is at work.

        Raises:
            DeviceError: It was switched off.
        """
        if device in self.off:
            raise DeviceError(self.off[device])

    def restart(self) -> None:
        """Gives devices that were switched off another try."""
        self.off.clear()
        self.uncontrolled.clear()

    def call(self, device: DeviceSpec[Any, Any], function: str, *arguments: Any) -> Any:
        """Calls a function of a device's kind; for any thread.

        Only calls in the control thread are watched, and switch the device off.

        Raises:
            DeviceError: It is switched off, or this call fails; the message names device, kind and function.
        """
        activity = self.activity
        if activity.thread != get_ident():
            return limited_call(device, function, *arguments)
        self.require(device.id)
        work = partial(self.attempt, device, function, partial(getattr(device, function), *arguments), refusals=())
        if activity.task is not None and activity.task.interruptible:  # the watchdog looks at what is called
            return work()
        answer = activity.run(KindCall(self, device, function), work)
        self.require(device.id)
        return answer

    def pose(self, device: LocalisingSpec[Any, Any], state: Any) -> Pose:
        """Returns the pose that a device says; for any thread. Its kind is asked once for each state.

        Raises:
            DeviceError: It is switched off, or the call fails.
        """
        known = self._poses.get(device.id)
        if known is None or known[0] is not state:
            known = self._poses[device.id] = state, self.call(device, "pose", state)
        elif self.activity.thread == get_ident():
            self.require(device.id)
        return known[1]

    def attempt(
        self,
        device: DeviceSpec[Any, Any],
        function: str,
        work: Callable[[], T],
        refusals: tuple[type[Exception], ...] = (SkirosError, StopIteration),
    ) -> T:
        """Runs code of a device's kind within a task of the control cycle, and switches the device off if it fails.

        Args:
            device: The device.
            function: Name of the function, for messages.
            work: Calls it.
            refusals: Exceptions that are no failures.

        Raises:
            DeviceError: The device was switched off, or the function refuses what it was given.
        """
        outer, self.calling = self.calling, (device, function)
        try:
            answer = work()
        except refusals:
            raise
        except Exception as error:
            raise self.switch_off(device, f"its {function} {_raised(error)}") from error
        finally:
            self.calling = outer
        if has_nan(answer):
            raise self.switch_off(device, f"its {function} returned {answer!r:.80}")
        return answer


class KindCall:
    """A function of a kind, as the watchdog sees it.

    Args:
        guard: Switches the device off.
        device: The device.
        function: Name of the function.
    """

    interruptible = True

    def __init__(self, guard: KindGuard, device: DeviceSpec[Any, Any], function: str) -> None:
        self.done = False
        self._guard = guard
        self._device = device
        self._function = function

    @property
    def name(self) -> str:
        """For messages."""
        return f"{self._function} of {described(self._device)}"

    def fail(self, fault: BaseException) -> None:
        """Switches the device off."""
        self.done = True
        if self._function == "command":
            self._guard.give_up(self._device, str(fault))
        else:
            self._guard.switch_off(self._device, str(fault))


class DeviceModels:
    """The models of a driver's devices: simulated ones, or those without physics.

    Args:
        devices: All devices of the driver.
        models: Their models, in the order in which they are called.
        seen: Gets the id of a device and its state whenever it has a new one.

    Attributes:
        guard: Contains their code.
        models: The models.
    """

    def __init__(
        self,
        devices: Mapping[str, DeviceSpec[Any, Any]],
        models: dict[str, DeviceModel],
        seen: Callable[[str, Any], None] = lambda _device, _state: None,
    ) -> None:
        self.models = models
        self._seen = seen
        self._devices = devices
        self._states: dict[str, Any] = {}
        self.contain(KindGuard())
        for id_, model in models.items():
            if isinstance(model, WiredModel):
                limited(partial(described, devices[id_]), _LONGEST, partial(model.wire, models))

    def start(self, begin: Callable[[], T]) -> T:
        """Does what begins their use, within a time limit.

        Args:
            begin: Calls :meth:`states`, at least.

        Raises:
            DeviceError: A model fails; the message names the device, its kind and the function.
        """
        activity = self.guard.activity
        try:
            return limited(lambda: "the first cycle", _LONGEST, begin)
        except TimeoutError as error:
            raise DeviceError(f"{activity.task.name if activity.task else 'the engine'} hangs: {error}") from error
        finally:
            activity.task = None

    def contain(self, guard: KindGuard) -> None:
        """Uses the guard of a board from now on."""
        self.guard = guard
        self._states_calls, self._command_calls = (
            {id_: KindCall(guard, self._devices[id_], function) for id_ in self.models}
            for function in ("state", "command")
        )

    @property
    def braking_time(self) -> float:
        """Longest time from full speed to standstill of those that are at work [s]."""
        times = [self._braking_time(id_) for id_ in self.models if id_ not in self.guard.off]
        return max(times, default=0.0)

    def command(self, commands: Commands) -> None:
        """Gives each model its target, or None.

        Raises:
            DeviceError: A target is malformed.
        """
        self._each(self._command_calls, partial(self._command, commands))

    def states(self) -> dict[str, Any]:
        """Returns the state of each device; the last one of a device that was switched off.

        Raises:
            DeviceError: A device that was switched off has no state yet.
        """
        self._each(self._states_calls, self._read)
        if len(self._states) < len(self.models):
            raise DeviceError("; ".join(self.guard.off.values()))
        return dict(self._states)

    def _each(self, calls: Mapping[str, KindCall], do: Callable[[str], None]) -> None:
        """Does something for each model, also after one that hung."""
        activity = self.guard.activity
        outer, coming = activity.task, iter(self.models)
        activity.begin_cycle()
        while True:
            try:
                for id_ in coming:
                    activity.task = calls[id_]
                    if activity.overrun is not None:
                        activity.settle()
                    do(id_)
                activity.leave(outer)
            except CycleOverrun:
                if activity.overrun is None:  # not of the watchdog of this cycle
                    raise
                continue
            return

    def _command(self, commands: Commands, id_: str) -> None:
        guard, model, device = self.guard, self.models[id_], self._devices[id_]
        if id_ in guard.uncontrolled:
            return
        target = commands.get(id_) if id_ not in guard.off else None
        try:
            model.command(target)
        except Exception as error:
            if target is not None and _refuses(device, target):  # a mistake of the caller, not of the kind
                raise
            guard.switch_off(device, f"its command {_raised(error)}")
            self._brake(id_, again=target is not None)

    def _brake(self, id_: str, *, again: bool) -> None:
        try:
            if again:
                self.models[id_].command(None)
        except Exception:  # noqa: BLE001 - the same error, or another one
            again = False
        if not again:
            self.guard.give_up(self._devices[id_], "it does not brake")

    def _read(self, id_: str) -> None:
        guard, device = self.guard, self._devices[id_]
        if id_ in guard.off:
            return
        try:
            state = self.models[id_].state()
        except Exception as error:  # noqa: BLE001 - a plug-in's code: it switches off one device
            guard.switch_off(device, f"its state {_raised(error)}")
            return
        if state is self._states.get(id_):
            return
        if device.state_type is not None and not isinstance(state, device.state_type):
            guard.switch_off(device, f"its state is a {device.state_type.__name__}, not {state!r:.60}")
        elif has_nan(state):
            guard.switch_off(device, f"its state has NaN: {state!r:.200}")
        else:
            self._states[id_] = state
            self._seen(id_, state)

    def _braking_time(self, id_: str) -> float:
        guard, device = self.guard, self._devices[id_]
        call = KindCall(guard, device, "braking_time")
        try:
            time = guard.activity.run(call, lambda: self.models[id_].braking_time)
            if time is None or 0.0 <= time < math.inf:  # None: it was interrupted
                return time or 0.0
            why = f"is no time: {time!r:.60}"
        except Exception as error:  # noqa: BLE001 - a plug-in's code: it switches off one device
            why = _raised(error)
        guard.switch_off(device, f"its braking_time {why}")
        return 0.0


def limited_call(
    device: DeviceSpec[Any, Any], function: str, *arguments: Any, read: Callable[[Any], Any] | None = None
) -> Any:
    """Calls a function of a device's kind outside the control cycle, with a time limit.

    Args:
        device: The device.
        function: Name of the function.
        *arguments: Its arguments.
        read: Reads a property instead.

    Raises:
        DeviceError: The function fails or hangs; the message names device, kind and function.
    """

    def what() -> str:
        return f"{function} of {described(device)}"

    try:
        answer = limited(what, _LONGEST, lambda: read(device) if read else getattr(device, function)(*arguments))
    except SkirosError:
        raise
    except TimeoutError as error:
        raise DeviceError(str(error)) from error
    except Exception as error:
        raise DeviceError(f"{what()} raised {type(error).__name__}: {error}") from error
    if has_nan(answer):
        raise DeviceError(f"{what()} returned {answer!r:.80}")
    return answer


def model_of(device: DeviceSpec[Any, Any], function: str, *arguments: Any) -> DeviceModel | None:
    """Returns the model of a device that its kind makes; None for a device without a state.

    Args:
        device: The device.
        function: The function that makes it: "fake" or "simulate".
        *arguments: Its arguments.

    Raises:
        DeviceError: The function fails or hangs, or makes no model of a device that has a state.
    """
    model: DeviceModel | None = limited_call(device, function, *arguments)
    if model is None and (device.state_type is not None or isinstance(device, MobileSpec)):
        raise DeviceError(f"{described(device)} has a state, but {function} makes no model of it")
    return model


def require_description(device: DeviceSpec[Any, Any]) -> None:
    """Requires that all that describes a device can be read: its joints, frames and the platform on it.

    Raises:
        DeviceError: A property raises, hangs or has NaN; the message names device, kind and property.
    """
    for name, found in inspect.getmembers(type(device), lambda one: isinstance(one, property)):
        limited_call(device, name, read=found.fget)


def described(device: DeviceSpec[Any, Any]) -> str:
    """Names a device, its kind and the kind's distribution."""
    return load_device_kinds()[0].describe(device.id, type(device))


def _refuses(device: DeviceSpec[Any, Any], target: object) -> bool:
    try:
        device.check(target)
    except Exception:  # noqa: BLE001 - a plug-in's code
        return True
    return False


def _raised(error: Exception) -> str:
    return f"raised {error if isinstance(error, SkirosError) else f'{type(error).__name__}: {error}'}"


def has_nan(value: Any) -> bool:
    """Returns True when a number in a state, a pose or a tuple is NaN; infinite ones may have a meaning."""
    kind: type = type(value)
    return _nan_check(kind)(value)


@lru_cache(maxsize=256)
def _nan_check(kind: type) -> Callable[[Any], bool]:
    """Returns what finds NaN in values of a type: states are checked in each cycle."""
    if issubclass(kind, float):
        return math.isnan
    if issubclass(kind, np.ndarray | np.generic):
        return lambda value: value.dtype.kind in "fc" and bool(np.isnan(value).any())
    if issubclass(kind, Mapping):
        return lambda value: any(map(has_nan, value.values()))
    if issubclass(kind, list | tuple):
        return lambda value: not _is_finite(value) and any(map(has_nan, value))
    if not dataclasses.is_dataclass(kind):
        return lambda _value: False
    return _fields_check(tuple(field.name for field in dataclasses.fields(kind)))


def _fields_check(names: tuple[str, ...]) -> Callable[[Any], bool]:
    def found(value: Any) -> bool:
        for name in names:
            one = getattr(value, name)
            kind: Any = type(one)
            if one != one if kind is float else kind not in _WITHOUT_NAN and _nan_check(kind)(one):
                return True
        return False

    return found


_WITHOUT_NAN = {bool, int, str, type(None)}


def _is_finite(values: Iterable[Any]) -> bool:
    """Returns True if the sum says that numbers, or rows of numbers, are finite; False where it does not say that."""
    with suppress(Exception):  # of what cannot be added up
        total = sum(values)
        return bool(total - total == 0.0)
    if not any(issubclass(type(one), Mapping) for one in values):  # iterating over one gives its keys
        with suppress(Exception):
            total = sum(chain.from_iterable(values))
            return bool(total - total == 0.0)
    return False

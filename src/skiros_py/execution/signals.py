"""The signals of a cell: checked and ordered once, computed when they are read, at most once in a cycle."""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from graphlib import CycleError, TopologicalSorter
from typing import Any

from skiros_py.errors import DescriptionError, DeviceError, UnknownName, UsageError
from skiros_py.execution.module_faults import off_words
from skiros_py.ports.board import DeviceBoard
from skiros_py.ports.device import DeviceSignal
from skiros_py.ports.device_kinds import load_device_kinds
from skiros_py.ports.signals import Input, Request, Sample, Signal, SignalProvider, Value
from skiros_py.ports.values import Snapshot

_log = logging.getLogger(__name__)


class SignalLost(DeviceError):
    """A signal has no value in this cycle.

    Attributes:
        signal: Its name.
        reason: Why.
    """

    def __init__(self, signal: str, reason: str) -> None:
        self.signal = signal
        self.reason = reason
        super().__init__(f"signal '{signal}' has no value: {reason}")


class _Node:
    """One provider as the watchdog and the other providers see it: at work, or switched off with a reason."""

    interruptible = True

    def __init__(self, provider: SignalProvider, source: str, title: str = "") -> None:
        self.provider = provider
        self.title = title or (f"{provider.name} of {source}" if source else provider.name)
        self.name = title or f"signal provider {self.title}"
        self.cycle = -1
        self.values: Mapping[str, Value] = {}
        self.lost = ""
        self.off = ""
        self.left_out = False
        self.done = False

    def fail(self, fault: BaseException) -> None:
        """Switches it off because of what it raised, or because it held the cycle for too long."""
        self.switch_off(off_words(fault))

    def switch_off(self, why: str) -> None:
        """Computes it no more until :meth:`restart`."""
        if not self.off:
            self.off = f"{self.title} was switched off in cycle {self.cycle}: {why}"
            _log.warning("%s", self.off)
        self.done = True

    def leave_out(self, why: str) -> None:
        """Never computes it: this cell lacks what it reads."""
        self.off, self.done, self.left_out = f"{self.title} is left out: {why}", True, True
        _log.warning("%s", self.off)

    def restart(self) -> None:
        """Gives it another try."""
        if not self.left_out:
            self.off, self.done = "", False


class _OfDevice:
    """Gives a signal of a device; a :class:`~skiros_py.ports.signals.SignalProvider`."""

    every_cycle = False
    requests: tuple[Request, ...] = ()

    def __init__(self, board: DeviceBoard, device: str, name: str, offered: DeviceSignal[Any]) -> None:
        self.name = device
        self.provides: tuple[Signal, ...] = (Signal(name, offered.unit, frame=offered.frame, help=offered.help),)
        self._board = board
        self._offered = offered

    def compute(self, inputs: Mapping[str, Value], time: float) -> Mapping[str, Value]:  # noqa: ARG002 - the protocol
        """Takes it out of the device's state."""
        return {self.provides[0].name: self._offered.read(self._board.snapshot.devices[self.name])}

    def why_not(self) -> str:
        """Returns why the device has no signals in this cycle; empty where it has."""
        silent = "" if self.name in self._board.snapshot.devices else f"{self.name} says nothing in this cycle"
        return self._board.guard.off.get(self.name, silent)


class Signals:
    """The signals of one cell. Reading belongs to the control thread; setting may come from any thread.

    Args:
        board: The devices.
        providers: What computes further signals, from those of the devices and from each other's.
        sources: Distribution of each provider, in the same order; none where they are not from plug-ins.
        missing: Why plug-ins bring no signals; then a provider that reads a signal which none provides is left out.

    Raises:
        DescriptionError: Two provide the same signal, a requested signal is provided by none, or providers need each
            other in a ring; the message names them. A provider that reads a signal of a device which this cell lacks is
            left out instead, as are those that read from it; see :attr:`faults`.
    """

    def __init__(
        self,
        board: DeviceBoard,
        providers: Sequence[SignalProvider] = (),
        sources: Sequence[str] = (),
        missing: str = "",
    ) -> None:
        self._board = board
        self._missing = missing
        self._activity = board.guard.activity
        nodes = map(_Node, providers, sources or [""] * len(providers))
        self._nodes = self._ordered(list(nodes))
        self._of = {signal.name: node for node in self._nodes for signal in node.provider.provides}
        for node in self._nodes:
            self._require_inputs(node)
        self._steady: list[_Node] = []
        self._set: dict[str, Value] = {}

    # ------------------------------------------------------------------ description

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all signals."""
        offered = (f"{id_}.{one.name}" for id_, device in self._board.devices.items() for one in device.signals)
        return tuple(dict.fromkeys((*offered, *self._of)))

    def describe(self, name: str) -> Signal:
        """Describes a signal.

        Raises:
            UnknownName: There is no such signal.
        """
        return next(signal for signal in self._known(name).provider.provides if signal.name == name)

    def source(self, name: str) -> str:
        """Returns the name of the device or provider that gives a signal.

        Raises:
            UnknownName: There is no such signal.
        """
        return self._known(name).provider.name

    def is_input(self, name: str) -> bool:
        """Returns True for a signal that :meth:`set` takes."""
        return name in self._of and isinstance(self._of[name].provider, Input)

    @property
    def faults(self) -> Mapping[str, str]:
        """Why providers were switched off or left out, by provider."""
        return {node.provider.name: node.off for node in tuple(self._nodes) if node.off}

    # ------------------------------------------------------------------ values

    def read(self, name: str) -> Sample:
        """Returns the value of a signal in this cycle.

        Raises:
            UnknownName: There is no such signal.
            SignalLost: It has no value: its provider was switched off, or lacks what it reads.
        """
        snapshot = self._board.snapshot
        node = self._known(name)
        if node.cycle != snapshot.cycle:
            self._update(node, snapshot)
        if name not in node.values:
            raise SignalLost(name, node.off or node.lost or f"{node.provider.name} gives none in this cycle")
        return Sample(node.values[name], snapshot.cycle, node.provider.name)

    def value(self, name: str) -> Value | None:
        """Returns the value of a signal in this cycle; None where there is no such signal, or it has no value."""
        try:
            return self.read(name).value
        except (UnknownName, SignalLost):
            return None

    def why_not(self, name: str) -> str:
        """Returns why a signal has no value in this cycle; empty where there is no such signal, or it has one."""
        try:
            self.read(name)
        except SignalLost as error:
            return error.reason
        except UnknownName:
            pass
        return ""

    def current(self) -> Mapping[str, Value]:
        """Returns the values of the signals that were read in this cycle; reads and computes none."""
        cycle = self._board.snapshot.cycle
        return {name: value for node in self._nodes if node.cycle == cycle for name, value in node.values.items()}

    def set(self, name: str, value: Value) -> None:
        """Sets an input from outside, for any thread; it counts from the next cycle on.

        Raises:
            UnknownName: There is no such signal.
            UsageError: It is no input, or the value is not of its shape or not finite.
        """
        provider = self._of[name].provider if name in self._of else None
        if not isinstance(provider, Input):
            raise UsageError(
                "signal '{name}' comes from {source}: only inputs can be set", name=name, source=self.source(name)
            )
        if (wrong := _wrong(value, provider.provides[0])) is not None:
            raise UsageError("signal '{name}': {wrong}", name=name, wrong=wrong)
        self._set[name] = value

    def update(self) -> None:
        """Begins a cycle: takes over what was set, and computes the providers that have a memory and are in use."""
        while self._set:
            name, value = self._set.popitem()
            provider = self._of[name].provider
            assert isinstance(provider, Input)
            provider.value = value
        snapshot = self._board.snapshot
        for node in tuple(self._steady):  # one that another reads joins meanwhile
            if node.cycle != snapshot.cycle:
                self._update(node, snapshot)

    def restart(self) -> None:
        """Gives the providers that were switched off another try, after everything was halted and looked at."""
        for node in self._nodes:
            node.restart()

    # ------------------------------------------------------------------ parts

    def _offered(self, name: str) -> tuple[str, DeviceSignal[Any] | None]:
        """Returns the device and its signal that a name such as "gripper_1.force" means; None for no such signal."""
        device, _, own = name.rpartition(".")
        spec = self._board.devices.get(device)
        return device, None if spec is None else spec.signal(own)

    def _known(self, name: str) -> _Node:
        """Returns what computes a signal; for one of a device it is made when it is first read."""
        if name not in self._of:
            device, offered = self._offered(name)
            if offered is None:
                raise UnknownName("signal", name, self.names)
            node = self._of[name] = _Node(_OfDevice(self._board, device, name, offered), "", f"signal '{name}'")
            self._nodes.append(node)
        return self._of[name]

    def _update(self, node: _Node, snapshot: Snapshot) -> None:
        node.cycle, node.values, node.lost = snapshot.cycle, {}, ""
        if node.provider.every_cycle and node not in self._steady:
            self._steady.append(node)
        if node.off:
            return
        if isinstance(node.provider, _OfDevice) and (why := node.provider.why_not()):
            node.lost = why
            return
        inputs: dict[str, Value] = {}
        for request in node.provider.requests:
            try:
                inputs[request.name] = self.read(request.name).value
            except (SignalLost, UnknownName) as error:
                if not request.optional:
                    node.lost = f"{node.provider.name} needs '{request.name}': {error}"
                    return
        self._compute(node, inputs, snapshot)

    def _compute(self, node: _Node, inputs: Mapping[str, Value], snapshot: Snapshot) -> None:
        """Runs a provider's code under the watchdog; whatever is wrong with it switches this provider off."""
        provider = node.provider
        try:
            values = self._activity.run(node, partial(provider.compute, inputs, snapshot.time)) or {}
            faults = [
                f"'{signal.name}': {wrong}"
                for signal in provider.provides
                if signal.name in values and (wrong := _wrong(values[signal.name], _shaped(signal, provider, values)))
            ]
        except Exception as error:  # noqa: BLE001 - an author's code: whatever it raises switches it off
            node.fail(error)
            return
        if faults:
            node.switch_off("; ".join(faults))
        elif not node.off:
            node.values = values

    def _ordered(self, nodes: Sequence[_Node]) -> list[_Node]:
        """Returns the providers, each after those that it reads from.

        Raises:
            DescriptionError: Two provide one signal, or they need each other in a ring.
        """
        source: dict[str, _Node] = {}
        for node in nodes:
            for signal in node.provider.provides:
                device, offered = self._offered(signal.name)
                other = device if offered is not None else source.setdefault(signal.name, node).title
                if offered is not None or source[signal.name] is not node:
                    raise DescriptionError(f"signal '{signal.name}' is provided twice: by {other} and {node.title}")
        before = {
            node: {source[request.name] for request in node.provider.requests if request.name in source}
            for node in nodes
        }
        try:
            return list(TopologicalSorter(before).static_order())
        except CycleError as error:
            ring = " → ".join(one.title for one in error.args[1])
            raise DescriptionError(f"signal providers need each other in a ring: {ring}") from None

    def _require_inputs(self, node: _Node) -> None:
        """Leaves a provider out that reads what this cell lacks, or what one that was left out provides.

        Raises:
            DescriptionError: It reads a signal that no cell could have: that is a mistake.
        """
        for request in node.provider.requests:
            name = request.name
            device, _, own = name.rpartition(".")
            if request.optional or self._offered(name)[1] is not None:
                continue
            source = self._of.get(name)
            if source is not None and not source.left_out:
                continue
            if source is not None:
                why = source.off
            elif device and device not in self._board.devices and own in load_device_kinds()[0].signal_names():
                why = f"this cell has no {device}"
            elif self._missing:
                why = f"none provides it ({self._missing})"
            else:
                raise DescriptionError(f"{node.title}: {UnknownName('signal', name, sorted(self.names))}")
            node.leave_out(f"it reads '{name}', and {why}")
            return


def _shaped(signal: Signal, provider: SignalProvider, values: Mapping[str, Value]) -> Signal:
    """Returns a signal with its length; a vector of a device has whichever it has."""
    value = values[signal.name]
    if isinstance(value, tuple) and isinstance(provider, _OfDevice):
        return replace(signal, length=len(value))
    return signal


def _wrong(value: object, signal: Signal) -> str | None:
    """Says what is wrong with a value of a signal; None where nothing is."""
    if signal.length is None:
        fits = isinstance(value, int | float) and math.isfinite(value)
        return None if fits else f"a finite number or truth value is wanted, not {value!r:.60}"
    if not isinstance(value, tuple) or len(value) != signal.length:
        return f"a tuple of {signal.length} numbers is wanted, not {value!r:.60}"
    finite = all(isinstance(one, int | float) and math.isfinite(one) for one in value)
    return None if finite else f"finite numbers are wanted, not {value!r:.60}"

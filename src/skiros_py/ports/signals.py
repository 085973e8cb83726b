"""Signals: named values that are computed in each cycle from what devices said and from other signals.

A provider is written by a device's author or by anyone else: a filter over a force sensor, the distance between two
robots, the answer of a worker process. Plug-ins offer providers by the entry-point group ``skiros.signals``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from skiros_py.ports.values import Pending

Value = float | bool | tuple[float, ...]
"""What a signal is worth in one cycle: a number, a truth value or a vector."""


_DIMENSIONS = {
    "m": "length",
    "m²": "area",
    "m³": "volume",
    "rad": "angle",
    "s": "time",
    "Hz": "frequency",
    "kg": "mass",
    "m/s": "speed",
    "rad/s": "angular speed",
    "m/s²": "acceleration",
    "rad/s²": "angular acceleration",
    "N": "force",
    "N m": "torque",
    "Pa": "pressure",
    "J": "energy",
    "W": "power",
    "A": "electric current",
    "V": "voltage",
    "K": "temperature",
    "°C": "temperature",
    "%": "ratio",
    "px": "pixels",
}


def dimension_of(unit: str) -> str:
    """Returns the dimension of values in a unit ("force" for "N"); empty for no unit, or one that is not known."""
    return _DIMENSIONS.get(unit, "")


_FACTOR = (
    r"(?:[pnµumcdhkMGT]?(?:m|g|s|A|K|mol|cd|rad|sr|Hz|N|Pa|J|W|C|V|Ω|F|T|H|S|lm|lx|l|L|bar|Wh)|1|min|h|d|°C|°|deg|%|px|rpm)"
    r"(?:[²³⁻¹]+|\^?-?\d)?"
)
_UNIT = re.compile(rf"{_FACTOR}(?:[ ·*/]{_FACTOR})*")


def is_unit(text: str) -> bool:
    """Returns whether a text is a unit: SI symbols with prefixes and powers, "1", "%", "°C", "px", or a product."""
    return _UNIT.fullmatch(text) is not None


@dataclass(frozen=True, slots=True)
class Signal:
    """Describes one signal.

    Attributes:
        name: Its name, unique in a cell: "wrist_1.force", "kit_distance".
        unit: SI unit ("N", "m/s"); empty where it has none.
        length: Number of values of a vector; None for a single value.
        frame: Frame in which a vector is given; empty where that means nothing.
        help: One sentence of meaning.
    """

    name: str
    unit: str = ""
    length: int | None = None
    frame: str = ""
    help: str = ""


@dataclass(frozen=True, slots=True)
class Request:
    """A signal that a provider reads.

    Attributes:
        name: The signal's name.
        optional: True where the provider can do without it: it is left out of its inputs while nothing provides it.
    """

    name: str
    optional: bool = False


@dataclass(frozen=True, slots=True)
class Sample:
    """The value of a signal in one cycle.

    Attributes:
        value: The value.
        cycle: Number of the control cycle that it belongs to.
        source: Name of the provider or device that gave it.
    """

    value: Value
    cycle: int
    source: str


class SignalProvider(Protocol):
    """Computes signals.

    Attributes:
        name: Its name, for messages.
        provides: The signals that it computes.
        requests: The signals that it reads.
        every_cycle: True for one that has a memory (a filter, a counter): it is computed in every cycle from the time
            it is first read. Others are computed only in cycles in which they are read.
    """

    name: str
    provides: tuple[Signal, ...]
    requests: tuple[Request, ...]
    every_cycle: bool

    def compute(self, inputs: Mapping[str, Value], time: float) -> Mapping[str, Value]:
        """Computes its signals for this cycle. It must be quick: it runs in the control thread.

        Args:
            inputs: Values of the requested signals.
            time: Time of the run [s].

        Returns:
            A value for each provided signal; one left out has no value in this cycle.
        """


def provider_problem(thing: object) -> str | None:
    """Returns why something is no signal provider, or None."""
    wanted: dict[str, Any] = {"name": str, "provides": Sequence, "requests": Sequence, "compute": Callable}
    for attribute, type_ in wanted.items():
        if not isinstance(getattr(thing, attribute, None), type_):
            return f"{thing!r:.60} is no SignalProvider: its {attribute} is missing or wrong"
    if not hasattr(thing, "every_cycle"):
        return f"{thing!r:.60} is no SignalProvider: it has no every_cycle"
    for attribute, kind in (("provides", Signal), ("requests", Request)):
        if not all(isinstance(one, kind) for one in getattr(thing, attribute)):
            return f"{thing!r:.60} is no SignalProvider: its {attribute} are objects of class {kind.__name__}"
    return None


class SignalReader(Protocol):
    """Reads the signals of the current cycle; belongs to the control thread."""

    def read(self, name: str) -> Sample:
        """Returns the value of a signal in this cycle.

        Raises:
            UnknownName: There is no such signal.
            DeviceError: It has no value in this cycle; the message says why.
        """

    def value(self, name: str) -> Value | None:
        """Returns the value of a signal in this cycle; None where there is no such signal, or it has no value."""


class Input:
    """A signal that people and other systems set from outside.

    Args:
        signal: The signal.
        initial: Its value until it is set.
    """

    every_cycle: bool = False
    requests: tuple[Request, ...] = ()

    def __init__(self, signal: Signal, initial: Value) -> None:
        self.name = signal.name
        self.provides: tuple[Signal, ...] = (signal,)
        self.value = initial

    def compute(self, inputs: Mapping[str, Value], time: float) -> Mapping[str, Value]:  # noqa: ARG002 - the protocol
        """Returns what was set last."""
        return {self.name: self.value}


class Latest:
    """A signal whose values come from a worker process: the latest answer counts, and the next one is asked for.

    In lockstep simulated time stands still while the worker is awaited, so an answer always arrives its declared
    latency after it was asked for; at a pace the cycle never waits.

    Args:
        signal: The signal.
        ask: Starts the computation of the next value.
        requests: The signals whose values ``ask`` gets.
        lockstep: Whether to wait for the answer when its latency is over.
    """

    every_cycle: bool = True

    def __init__(
        self,
        signal: Signal,
        ask: Callable[[Mapping[str, Value]], Pending[Any]],
        requests: tuple[Request, ...] = (),
        *,
        lockstep: bool = True,
    ) -> None:
        self.name = signal.name
        self.provides: tuple[Signal, ...] = (signal,)
        self.requests = requests
        self._ask = ask
        self._lockstep = lockstep
        self._pending: Pending[Any] | None = None
        self._due = 0.0
        self._latest: dict[str, Value] = {}

    def compute(self, inputs: Mapping[str, Value], time: float) -> Mapping[str, Value]:
        """Returns the latest answer; without one yet the signal has no value."""
        pending = self._pending
        if pending is not None and time >= self._due and (self._lockstep or pending.done()):
            self._latest = {self.name: pending.result()}
            pending = None
        if pending is None:
            pending = self._ask(inputs)
            self._due = time + pending.latency
        self._pending = pending
        return self._latest

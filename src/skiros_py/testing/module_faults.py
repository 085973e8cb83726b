"""Faults of primitives, as plain data, and primitives that have them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from skiros_py.errors import UnknownName
from skiros_py.skills.outcome import Failure, Outcome
from skiros_py.skills.primitive import Execution, Primitive


@dataclass(frozen=True, slots=True)
class Fails:
    """A primitive fails immediately, for a number of calls (None for all); then it works."""

    primitive: str
    reason: str = "a fault of the test"
    times: int | None = 1
    code: int = -1


@dataclass(frozen=True, slots=True)
class Breaks:
    """A primitive raises an exception, for a number of calls (None for all); then it works."""

    primitive: str
    exception: BaseException
    times: int | None = 1


@dataclass(frozen=True, slots=True)
class Slow:
    """A primitive starts with a delay [s], for a number of calls (None for all)."""

    primitive: str
    seconds: float
    times: int | None = None


ModuleFault = Fails | Breaks | Slow


def spoiled(
    primitives: Sequence[type[Primitive[Any]]], faults: Sequence[ModuleFault]
) -> tuple[type[Primitive[Any]], ...]:
    """Returns the primitives, with those that have a fault replaced by faulty ones of the same name.

    Raises:
        UnknownName: A fault is for a primitive that is not among them.
    """
    known = {primitive.name: primitive for primitive in primitives}
    for fault in faults:
        if fault.primitive not in known:
            raise UnknownName("primitive", fault.primitive, known, where=f"in {fault}")
        known[fault.primitive] = _with_fault(known[fault.primitive], fault)
    return tuple(known.values())


def _with_fault(primitive: type[Primitive[Any]], fault: ModuleFault) -> type[Primitive[Any]]:
    calls = _calls(fault.times)

    class Spoiled(primitive):  # type: ignore[valid-type,misc]  # a class made at run time
        __doc__ = primitive.__doc__

        def execute(self) -> Execution[Outcome]:
            if next(calls):
                match fault:
                    case Fails():
                        return Failure(fault.reason, fault.code)
                    case Breaks():
                        raise fault.exception
                    case Slow():
                        yield from _idle(self, fault.seconds)
            outcome: Outcome = yield from super().execute()
            return outcome

    Spoiled.__name__, Spoiled.__qualname__ = primitive.__name__, primitive.__qualname__
    return Spoiled


def _calls(times: int | None) -> Iterator[bool]:
    """Yields for each call whether it has the fault."""
    left = times
    while True:
        yield left is None or left > 0
        left = None if left is None else left - 1


def _idle(primitive: Primitive[Any], seconds: float) -> Execution[None]:
    end = primitive.context.now + seconds
    while primitive.context.now < end:
        yield

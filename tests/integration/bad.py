"""Primitives that misbehave on purpose, for claims about what becomes of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

from skiros_py.devices.mobile_base import Base, BaseState, BaseTwist
from skiros_py.skills.outcome import Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.testing import Bench

Behaviour = Callable[["Bad"], Any]


class OwnBase(BaseException):
    """Somebody's exception that is no Exception."""


class Moving(Primitive["Moving.Params"]):
    """Drives; what it does then is told by its subclasses."""

    name: ClassVar[str] = "moving"

    @dataclass(frozen=True, slots=True)
    class Params:
        base: str = param("sk:Base", "The base.", kind=Kind.HARDWARE)

    def execute(self) -> Execution[Outcome]:
        yield from self.drive(0.1)
        return Success("drove")

    def drive(self, seconds: float) -> Execution[None]:
        end = self.context.now + seconds
        while self.context.now < end:
            Base(self.context.board, self.params.base).command(BaseTwist(0.5, 0.0))
            yield


class Bad(Moving):
    """Drives for a while and then does what the test says."""

    name: ClassVar[str] = "bad"
    behaviour: ClassVar[Behaviour]

    def execute(self) -> Execution[Outcome]:
        yield from self.drive(0.1)
        Base(self.context.board, self.params.base).command(BaseTwist(0.5, 0.0))
        return (yield from type(self).behaviour(self))


def bad(behaviour: Behaviour) -> type[Bad]:
    return type("Bad", (Bad,), {"behaviour": staticmethod(behaviour), "__doc__": Bad.__doc__})


def raising(error: BaseException) -> Behaviour:
    def behave(bad: Bad) -> Execution[Outcome]:
        yield
        raise error

    return behave


def returning(value: Any) -> Behaviour:
    def behave(bad: Bad) -> Execution[Any]:
        yield
        return value

    return behave


def yielding(value: Any) -> Behaviour:
    def behave(bad: Bad) -> Iterator[Any]:
        while True:
            yield value

    return behave


def halted(bench: Bench) -> bool:
    """Lets a robot brake; true when it stands where it is from then on."""
    bench.advance(0.1)
    before = bench.cycle.board.snapshot.state("base_1", BaseState).pose
    bench.advance(0.5)
    return bench.cycle.board.still and bench.cycle.board.snapshot.state("base_1", BaseState).pose == before


def assert_others_go_on(bench: Bench) -> None:
    """The robot stands, its devices are free, and a good module runs on them."""
    assert halted(bench)
    assert bench.run("moving", base="base_1") == Success("drove")

"""The base class of primitives: parameters and an execution, no conditions."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Generator
from typing import Any, ClassVar, Generic, TypeVar

from skiros_py.robot.pending import Pending
from skiros_py.skills.context import RunContext
from skiros_py.skills.outcome import Outcome
from skiros_py.world.world import World

__all__ = ["Execution", "Primitive"]

P = TypeVar("P")
T = TypeVar("T")

Execution = Generator[None, None, T]
"""A generator that yields once per control cycle while it still runs and returns its result."""


class Primitive(ABC, Generic[P]):
    """One thing a robot does, written as sequential code: each ``yield`` waits for the next control cycle.

    Life cycle: made with its arguments (nothing happens), then :meth:`execute` is ticked once per cycle until it
    returns. When stopped, the generator is closed: its ``finally`` must be instantaneous (the ports brake by
    themselves); motion that must follow a stop is a second generator, :meth:`recover`, ticked afterwards.

    Class attributes:
        name: Its name; compositions refer to it.
        Params: Frozen dataclass whose fields are declared with :func:`~skiros_py.skills.parameters.param`.
        watches: Class of device that this primitive watches in the background for as long as its manager runs; its
            ``Params`` then have one field, ``device``. None for primitives that are called.
    """

    name: ClassVar[str]
    Params: ClassVar[type[Any]]
    watches: ClassVar[str | None] = None

    def __init__(self, context: RunContext, params: P) -> None:
        self.context = context
        self.params = params

    @property
    def world(self) -> World:
        """The live world model."""
        return self.context.world

    @abstractmethod
    def execute(self) -> Execution[Outcome]:
        """Does it; returns how it ended."""

    def recover(self) -> Execution[None]:
        """Motion that must follow a stop (retreat, open); nothing by default."""
        yield from ()

    def progress(self, code: int, text: str) -> None:
        """Reports how far it is: a growing positive code, and words for a person."""
        self.context.report(self.name, code, text)

    def wait(self, pending: Pending[T]) -> Execution[T]:
        """Ticks until an answer may be used, and returns it.

        In lockstep that is exactly the declared latency after the request, however long the worker takes.
        """
        due = self.context.now + pending.latency
        while self.context.now < due - 1e-9 or not (self.context.lockstep or pending.done()):
            yield
        return pending.result()

    def seed(self) -> int:
        """Draws a seed for a library's random choices."""
        return int(self.context.rng.integers(2**31))

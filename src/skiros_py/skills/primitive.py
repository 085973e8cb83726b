"""The base class of primitives: parameters and an execution, no conditions."""

from __future__ import annotations

import ast
import inspect
import textwrap
from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Mapping
from inspect import isasyncgenfunction, iscoroutinefunction, isgeneratorfunction
from types import MappingProxyType
from typing import Any, ClassVar, Generic, TypeVar

from skiros_py.errors import DescriptionError
from skiros_py.ports.values import Pending
from skiros_py.skills.context import RunContext
from skiros_py.skills.outcome import Execution, Failure, Outcome, tick
from skiros_py.skills.parameters import Output, check_params
from skiros_py.skills.parameters.fields import own_fields, params_class
from skiros_py.world.element import Value
from skiros_py.world.world import World

__all__ = ["Execution", "Primitive"]

P = TypeVar("P")
T = TypeVar("T")


class Primitive(ABC, Generic[P]):
    """One thing a robot does, written as sequential code: each ``yield`` waits for the next control cycle.

    Life cycle. Once per skill manager, before the first run: :meth:`load`. For each run a new object is made (nothing
    happens) and then :meth:`start` is called; unless it refuses, :meth:`execute` is ticked once per cycle until it
    returns. When it is cancelled, the generator is closed: its ``finally`` must be instantaneous, and so must
    :meth:`stop`, which follows (the ports brake by themselves); motion that must follow a stop is a second generator,
    :meth:`recover`, ticked afterwards under a time limit. After a fault a person may :meth:`reset` the module.

    Class attributes:
        name: Its name; compositions refer to it.
        Params: Frozen dataclass whose fields are declared with :func:`~skiros_py.skills.parameters.param`. It is made
            by itself where they are declared in the class: ``arm: str = param(…)`` is ``self.arm`` in a run.
        takes: Further fields of ``Params``, besides those of kind HARDWARE, whose element is taken with all devices it
            has: no other module commands them meanwhile.
        watches: Class of device that this primitive watches in the background for as long as its manager runs; its
            ``Params`` then have one field, ``device``. None for primitives that are called.
        outputs: The values that it finds out; ``Success(values=…)`` may have these and no others.
        version: Version of this implementation.
        duration: How long it takes as a rule [s]; None where that differs too much.
        limit: How long one run may take at most [s], without pauses and questions to a person; ``math.inf`` for no
            limit. None for 20 times the duration, at least 300 s; where that is not known, it is ended when its
            devices stand and it has reported no progress for 600 s.
        offered: Names of modules of its own distribution that are offered under another one, which the platform sets.
    """

    name: ClassVar[str]
    Params: ClassVar[type[Any]]
    takes: ClassVar[tuple[str, ...]] = ()
    watches: ClassVar[str | None] = None
    outputs: ClassVar[tuple[Output, ...]] = ()
    version: ClassVar[str] = "1.0.0"
    duration: ClassVar[float | None] = None
    limit: ClassVar[float | None] = None
    offered: ClassVar[Mapping[str, str]] = MappingProxyType({})

    _fields: ClassVar[tuple[str, ...]] = ()
    """Keys of the parameters that are declared in the class."""

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        if fields := own_fields(cls):
            cls.Params, cls._fields = params_class(cls, fields), (*cls._fields, *fields)
            for key in fields:
                delattr(cls, key)
        if not isinstance(cls.outputs, tuple) or not all(isinstance(one, Output) for one in cls.outputs):
            raise DescriptionError(f"outputs of primitive {cls.__name__}: a tuple of Output(name, type, help)")
        check_params([output.param for output in cls.outputs], f"of the outputs of primitive {cls.__name__}")
        for seconds in (cls.duration, cls.limit):
            if seconds is not None and not (isinstance(seconds, int | float) and seconds > 0.0):
                raise DescriptionError(f"duration and limit of primitive {cls.__name__}: seconds, not {seconds!r}")
        for name in _AT_ONCE:
            method = getattr(cls, name)
            if isgeneratorfunction(method) or iscoroutinefunction(method) or isasyncgenfunction(method):
                raise DescriptionError(
                    f"{name}() of primitive {cls.__name__}: it is called once and would never run, for it is a "
                    "generator or async; what takes time goes into execute() or recover()"
                )

    def __init__(self, context: RunContext, params: P, loaded: Any = None) -> None:
        self.context = context
        self.params = params
        self.loaded = loaded
        vars(self).update({key: getattr(params, key) for key in self._fields})

    # ------------------------------------------------------------------ life cycle

    @classmethod
    def load(cls, context: RunContext) -> Any:  # noqa: ARG003 - what overriding methods get
        """Prepares what is expensive and kept between runs; what it returns is ``self.loaded`` of each run."""
        return None

    def start(self) -> Failure | None:
        """Looks whether it can run at all; a failure ends it before anything moves."""
        return None

    @abstractmethod
    def execute(self) -> Execution[Outcome]:
        """Does it; returns how it ended."""

    def stop(self) -> None:
        """Cleans up at once when it was cancelled; nothing by default."""

    def recover(self) -> Execution[None]:
        """Motion that must follow a stop (retreat, open); nothing by default."""
        yield from ()

    @classmethod
    def reset(cls, context: RunContext, loaded: Any) -> Any:  # noqa: ARG003 - what overriding methods get
        """Makes it fit to run again after a fault; by default it is loaded again."""
        return cls.load(context)

    # ------------------------------------------------------------------ what it may reach

    @property
    def world(self) -> World:
        """The live world model."""
        return self.context.world

    def progress(self, code: int, text: str) -> None:
        """Reports how far it is: a growing positive code, and words for a person; a negative code is an error."""
        self.context.report(self.name, code, text)

    def emit(self, event: str, value: Any = None) -> None:
        """Announces a named event ("slipped"), with a value as plain data; recordings and listeners get it."""
        self.context.emit(event, value)

    def wait(self, pending: Pending[T]) -> Execution[T]:
        """Ticks until an answer may be used, and returns it.

        In lockstep that is exactly the declared latency after the request, however long the worker takes.

        Raises:
            TypeError: It is no answer that is on its way.
        """
        if not hasattr(pending, "latency"):
            raise TypeError(
                f"wait() takes an answer that is on its way, such as camera.capture(), not {pending!r:.100}"
            )
        due = self.context.now + pending.latency
        while self.context.now < due - 1e-9 or not (self.context.lockstep or pending.done()):
            yield
        with self.context.waiting():
            return pending.result()

    def call(self, module: str, **arguments: Any) -> Execution[Outcome]:
        """Runs another module and waits for it: ``outcome = yield from self.call("move_arm", arm=…)``."""
        return (yield from self.context.call(self.offered.get(module, module), arguments))

    def join(self, *calls: Execution[Outcome]) -> Execution[tuple[Outcome, ...]]:
        """Runs several calls at the same time until all have ended: ``yield from self.join(self.call(…), …)``.

        Raises:
            TypeError: Something is no call.
        """
        for call in calls:
            if not isinstance(call, Generator):
                raise TypeError(f"join() takes calls, one by one, such as self.call('drive'), not {call!r:.100}")
        outcomes: dict[int, Outcome] = {}
        try:
            while True:
                for number, call in enumerate(calls):
                    outcome = None if number in outcomes else tick(call)
                    if outcome is not None:
                        outcomes[number] = outcome
                if len(outcomes) == len(calls):
                    return tuple(outcomes[number] for number in range(len(calls)))
                yield
        finally:
            for call in calls:
                call.close()

    def assert_effects(self, *effects: str, reason: str, sensed: Value | None = None) -> None:
        """Writes effects of the skill that this primitive is part of: it has sensed that they are so.

        Args:
            *effects: Keys of the skill's postconditions; none for all.
            reason: What was sensed.
            sensed: The sensed value of the property that they speak of; needed where they leave it open ("at least 8").
        """
        if self.context.effects is not None:
            self.context.effects.write(*effects, author=self.name, reason=reason, sensed=sensed)

    def seed(self) -> int:
        """Draws a seed for a library's random choices."""
        return int(self.context.rng.integers(2**31))


_AT_ONCE = ("load", "start", "stop", "reset")
"""What takes no time: plain functions, called once."""


def generator_problem(function: Callable[..., Any]) -> str:
    """Returns why a method cannot be ticked once per cycle; an empty text if it can, or its source is not known."""
    if isgeneratorfunction(function) or getattr(function, "__isabstractmethod__", False):
        return ""
    if iscoroutinefunction(function) or isasyncgenfunction(function):
        return "must be a plain generator, not async: each yield waits for the next control cycle"
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    except (OSError, TypeError, SyntaxError):
        return ""
    returned = [node.value for node in ast.walk(tree) if isinstance(node, ast.Return)]
    if any(isinstance(value, ast.Call) and isinstance(value.func, ast.Attribute) for value in returned):
        return ""  # it hands on what another method makes (``return self.call(…)``), which may be a generator
    return "never yields, so it is not a generator: each yield waits for the next control cycle"

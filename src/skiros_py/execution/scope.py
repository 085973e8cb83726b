"""What a part of a running skill runs in, and what was broken off in it and has to be made up for."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

from skiros_py.errors import UsageError
from skiros_py.execution.claims import Claim
from skiros_py.execution.contained import contained
from skiros_py.execution.hardware import standstill
from skiros_py.execution.monitor import Monitor
from skiros_py.skills.conditions.watch import Watches
from skiros_py.skills.context import RunContext
from skiros_py.skills.execution import Execution
from skiros_py.skills.outcome import Failure, Outcome

__all__ = ["ModuleRunner", "Scope", "Unfinished", "make_up"]

_log = logging.getLogger(__name__)

_DEEPEST = 20
"""Modules within modules: more than these are taken for a circle."""
_RECOVERY_LIMIT = 20.0
"""Longest time for motion after something was broken off [s]."""


class ModuleRunner(Protocol):
    """Runs modules by name: primitives and skills."""

    def run(self, module: str, arguments: Mapping[str, Any], scope: Scope) -> Execution[Outcome]:
        """Returns the run of a module within a scope; ticked to its end, or closed."""
        ...


@dataclass(frozen=True, slots=True)
class Unfinished:
    """A module that was broken off and may have motion to make up for; until then it keeps its devices.

    Attributes:
        name: The module.
        recover: Starts that motion.
        claim: Its devices.
    """

    name: str
    recover: Callable[[], Execution[None]]
    claim: Claim


@dataclass(frozen=True, slots=True)
class Scope:
    """What a part of a running skill runs in.

    Attributes:
        context: World, devices, libraries, the run's clock.
        modules: Runs what is called.
        watches: Conditions that are looked at again when something they read has changed.
        monitor: Takes module events.
        agent: Id of the subsystem.
        claim: The devices that whatever runs here may share out; None at the top.
        arguments: The skill's parameters.
        unfinished: What was broken off here.
        callers: The modules around this, outermost first.
        task: Name of the task that it is done for; empty for none.
    """

    context: RunContext
    modules: ModuleRunner
    watches: Watches
    monitor: Monitor
    agent: str
    claim: Claim | None = None
    arguments: Mapping[str, Any] = field(default_factory=dict)
    unfinished: list[Unfinished] = field(default_factory=list)
    callers: tuple[str, ...] = ()
    task: str = ""

    def check_depth(self, module: str) -> None:
        """Looks whether modules seem to call each other without end, where one more is about to run.

        Raises:
            UsageError: They do.
        """
        if len(self.callers) >= _DEEPEST:
            raise UsageError(f"modules call each other without end: {' > '.join((*self.callers, module)[-4:])}")

    def with_arguments(self, more: Mapping[str, Any]) -> Scope:
        """Returns the same scope with further arguments."""
        return replace(self, arguments={**self.arguments, **more})

    @contextmanager
    def apart(self) -> Iterator[Scope]:
        """Gives a scope of its own to what may be broken off alone; what it has not made up for at the end stays."""
        inner = replace(self, unfinished=[])
        try:
            yield inner
        finally:
            self.unfinished.extend(inner.unfinished)


def make_up(scope: Scope) -> Execution[None]:
    """Ticks what the modules broken off in a scope want to make up for, under a time limit for all together."""
    context = scope.context
    deadline = context.now + _RECOVERY_LIMIT
    while scope.unfinished:
        entry = scope.unfinished.pop(0)
        try:
            yield from _recovery(entry, context, deadline)
            yield from standstill(context.board, entry.claim.devices)
        except GeneratorExit:
            scope.unfinished.insert(0, entry)  # broken off itself: it keeps its devices, and begins again if it may
            raise
        entry.claim.release()


def _recovery(entry: Unfinished, context: RunContext, deadline: float) -> Execution[None]:
    what = f"{entry.name}, while it recovered,"
    recovery, devices = _begun(entry), entry.claim.devices
    try:
        while context.now <= deadline:
            ended = contained(what, lambda: context.board.limited(devices, lambda: next(recovery, _ENDED)))
            if ended is _ENDED:
                return
            if isinstance(ended, Failure):
                break
            yield
        else:
            _log.warning("%s did not recover within %g s", entry.name, _RECOVERY_LIMIT)
    finally:
        contained(what, recovery.close)
    context.board.clear(devices)


def _begun(entry: Unfinished) -> Execution[None]:
    yield from entry.recover()


_ENDED = object()

"""What nodes of a running skill run in, how runs of modules report and end, and the recovery of what was cancelled."""

from __future__ import annotations

import json
import logging
from abc import ABC, abstractmethod
from collections import ChainMap
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, Protocol

from skiros_py.errors import UsageError
from skiros_py.execution.claims import Claim, standstill
from skiros_py.execution.module_faults import contained
from skiros_py.execution.monitor import ModuleEvent, Monitor, Status, end_of
from skiros_py.execution.task import Task
from skiros_py.interruptions import EndlessCalls, Interruption
from skiros_py.messages import Message
from skiros_py.skills.behaviour import Behaviour, Call, P
from skiros_py.skills.conditions import Condition
from skiros_py.skills.conditions.watch import Watch, Watches
from skiros_py.skills.context import RunContext
from skiros_py.skills.inference.inferring import applying
from skiros_py.skills.outcome import BROKEN, Execution, Failure, Outcome, Success, tick

_log = logging.getLogger(__name__)

_DEEPEST = 20
"""Modules within modules: more than these are taken for a circle."""
_RECOVERY_LIMIT = 20.0
"""Longest time for the recovery of what was cancelled [s]."""
_NONE: Mapping[str, Any] = MappingProxyType({})


class ModuleRunner(Protocol):
    """Runs modules by name: primitives and skills."""

    def run(self, module: str, arguments: Mapping[str, Any], scope: Scope) -> Execution[Outcome]:
        """Returns the run of a module within a scope; ticked to its end, or closed."""

    def launch(self, module: str, arguments: Mapping[str, Any]) -> None:
        """Starts a module in the background, unless it runs there already with these arguments."""


@dataclass(frozen=True, slots=True)
class Unfinished:
    """A module that was cancelled and still has to recover; until then it keeps its devices.

    Attributes:
        name: The module.
        recover: Starts its recovery.
        claim: Its devices.
    """

    name: str
    recover: Callable[[], Execution[None]]
    claim: Claim


@dataclass(frozen=True, slots=True)
class Scope:
    """What a node of a running skill runs in; implements :class:`skiros_py.skills.behaviour.Scope`.

    Attributes:
        context: World, devices, adapters, the run's clock.
        modules: Runs what is called.
        watches: Conditions that are looked at again when something they read has changed.
        monitor: Takes module events.
        agent: Id of the subsystem.
        claim: The devices that what runs here may share; None at the top.
        arguments: The skill's parameters, elements of loops, and values that were written.
        unfinished: What was cancelled here.
        callers: The modules around this, outermost first.
        task: Name of the task that it is done for; empty for none.
        id: Id of the run that this is the scope of; parent of the runs that begin in it.
        parent: Id of the run around that one; empty for none.
        root: Id of the outermost run.
        path: Path of that run's node, from the module that was started: ``pick/body/0/2``.
        values: What was written by nodes of this skill.
        breakpoints: Paths of nodes before which the task is paused; people may change them while it runs.
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
    id: str = ""
    parent: str = ""
    root: str = ""
    path: str = ""
    values: dict[str, Any] = field(default_factory=dict)
    breakpoints: set[str] = field(default_factory=set)

    @property
    def author(self) -> str:
        """Name of the innermost module around."""
        return self.callers[-1] if self.callers else ""

    def run(self, child: Behaviour, key: str, elements: Mapping[str, Any] = _NONE) -> Execution[Outcome]:
        """Returns the run of a child node; its path ends with the key."""
        arguments = ChainMap(dict(elements), self.arguments) if elements else self.arguments  # type: ignore[arg-type]
        path = f"{self.path}/{key}"
        inner = replace(self, id=self.monitor.new_id(), parent=self.id, path=path, arguments=arguments)
        return _run_node(child, inner)

    def call(self, call: Call) -> Execution[Outcome]:
        """Returns the run of a module; values of its outcome are written when it has succeeded."""
        values = self._inputs(call)
        if isinstance(values, Failure):
            return failed(values)
        run = contained(call.module, lambda: self.modules.run(call.module, values, self))
        if isinstance(run, Failure):
            return failed(run)
        return _with_outputs(run, call, self) if call.outputs else run

    def launch(self, call: Call) -> Outcome:
        """Starts a module that runs on beside the skill, and after it."""
        values = self._inputs(call)
        if isinstance(values, Failure):
            return values
        started = contained(call.module, lambda: self.modules.launch(call.module, values))
        return started if isinstance(started, Failure) else Success()

    def write(self, name: str, value: Any) -> None:
        """Writes a value that later nodes of the same skill read."""
        self.values[name] = value

    def emit(self, event: str, value: Any = None) -> None:
        """Announces a named event of this node.

        Raises:
            UsageError: The value is no plain data.
        """
        try:
            json.dumps(value, allow_nan=False)
        except (TypeError, ValueError, RecursionError) as error:
            raise UsageError(f"event {event}: its value is plain data that JSON can carry: {error}") from None
        self.publish_node(Status.EVENT, 0, event, event=event, value=value)

    def watch(self, conditions: Sequence[Condition]) -> Watch:
        """Watches those conditions whose parameters are specified; close it."""
        return self.watches.add(applying(conditions, self.arguments), self.arguments)

    def recover(self) -> Execution[None]:
        """Runs the recovery of what was cancelled in this scope."""
        return run_recovery(self)

    def _inputs(self, call: Call) -> dict[str, Any] | Failure:
        """Fills in parameters; those that are unspecified stay so in what is called."""
        values = {}
        for key, value in call.inputs.items():
            if isinstance(value, P):
                if value.key not in self.arguments:
                    return Failure(
                        Message("{module}: no node has written '{key}' yet", module=call.module, key=value.key)
                    )
                value = self.arguments[value.key]
            if value is not None:
                values[key] = value
        return values

    def publish(self, kind: str, module: str, status: Status, code: int, text: str, **more: Any) -> None:
        """Reports an event of what runs in this scope; ``more`` are further fields of it."""
        time = self.context.board.snapshot.time
        event = ModuleEvent(
            time, kind, module, status, code, text,
            agent=self.agent, caller=self.author, task=self.task, root=self.root, path=self.path, **more,
        )  # fmt: skip
        self.monitor.publish(event)

    def publish_node(self, status: Status, code: int, text: str, **more: Any) -> None:
        """Reports an event of the node of this scope."""
        self.publish("node", self.author, status, code, text, id=self.id, parent=self.parent, **more)

    def check_depth(self, module: str) -> None:
        """Looks whether modules seem to call each other without end, where one more is about to run.

        Raises:
            EndlessCalls: They do.
        """
        if len(self.callers) >= _DEEPEST:
            raise EndlessCalls(f"modules call each other without end: {' > '.join((*self.callers, module)[-4:])}")

    @contextmanager
    def apart(self) -> Iterator[Scope]:
        """Gives a scope of its own to what may be cancelled alone; what has not recovered in it stays for this one."""
        inner = replace(self, unfinished=[])
        try:
            yield inner
        finally:
            self.unfinished.extend(inner.unfinished)


def _run_node(node: Behaviour, scope: Scope) -> Execution[Outcome]:
    """Runs one node: obeys breakpoints, reports its start and end where anybody wants to know."""
    if scope.path in scope.breakpoints:
        yield from _hold(scope)
    reports = scope.monitor.wants_nodes
    if reports:
        scope.publish_node(Status.STARTED, 0, node.title)
    try:
        outcome = yield from node.run(scope)
    except (GeneratorExit, Interruption):
        if reports:
            scope.publish_node(Status.PREEMPTED, 0, "cancelled")
        raise
    if not isinstance(outcome, Success | Failure):
        raise TypeError(f"node {scope.path} returned {outcome!r:.100}: a run returns Success or Failure")
    if reports:
        scope.publish_node(*end_of(outcome))
    return outcome


def _hold(scope: Scope) -> Execution[None]:
    """Pauses the task before a node; it goes on when the task is resumed or stepped."""
    task = scope.context.board.owner
    if isinstance(task, Task):
        task.pause()
        while task.pausing:
            yield


def failed(failure: Failure) -> Execution[Outcome]:
    """Returns the run of what has failed already."""
    yield from ()
    return failure


def _with_outputs(run: Execution[Outcome], call: Call, scope: Scope) -> Execution[Outcome]:
    outcome = yield from run
    if isinstance(outcome, Success):
        for key, name in call.outputs.items():
            if key not in outcome.values:
                there = (
                    Message("its outcome has {values}", values=", ".join(outcome.values))
                    if outcome.values
                    else Message("its outcome has none")
                )
                return Failure(
                    Message("{module} gave no value '{key}': {there}", module=call.module, key=key, there=there)
                )
            scope.write(name, outcome.values[key])
    return outcome


def run_recovery(scope: Scope) -> Execution[None]:
    """Ticks the recoveries of the modules that were cancelled in a scope, under a time limit for all together."""
    context = scope.context
    deadline = context.now + _RECOVERY_LIMIT
    while scope.unfinished:
        entry = scope.unfinished.pop(0)
        try:
            yield from _recovery(entry, context, deadline)
            yield from standstill(context.board, entry.claim)
        except GeneratorExit:
            scope.unfinished.insert(0, entry)  # cancelled itself: it keeps its devices, and begins again if it may
            raise
        entry.claim.release()


def _recovery(entry: Unfinished, context: RunContext, deadline: float) -> Execution[None]:
    what = f"{entry.name}, while it recovered,"
    recovery, claim = _begun(entry), entry.claim
    try:
        while context.now <= deadline:
            ended = contained(what, lambda: context.board.limited(claim, lambda: next(recovery, _ENDED)))
            if ended is _ENDED:
                return
            if isinstance(ended, Failure):
                break
            yield
        else:
            _log.warning("%s did not recover within %g s", entry.name, _RECOVERY_LIMIT)
    finally:
        contained(what, recovery.close)
    context.board.clear(claim)


def _begun(entry: Unfinished) -> Execution[None]:
    yield from entry.recover()


_ENDED = object()


class ModuleRun(ABC):
    """One run of a module: reports to the monitor, and gives its devices back at its end.

    Args:
        kind: "skill", "primitive" or "document".
        name: The module.
        arguments: Its parameters.
        scope: What it runs in.
        run: Id of this run; a new one where left out.

    Attributes:
        name: The module.
        arguments: Its parameters, as far as they are known.
        id: Id of this run.
        started: True when the monitor has heard of it.
    """

    def __init__(self, kind: str, name: str, arguments: Mapping[str, Any], scope: Scope, run: str = "") -> None:
        self.name = name
        self.arguments = arguments
        self.id = run or scope.monitor.new_id()
        self.started = False
        self._kind = kind
        self._outer = scope
        self._claim: Claim | None = None

    def execute(self) -> Execution[Outcome]:
        """Runs it until it ends or is cancelled, reports that, and gives its devices back.

        The end of an outermost run that was cancelled is reported by its skill manager, when its devices stand.
        """
        kept, nested = False, bool(self._outer.callers)
        try:
            outcome = yield from self.run()
        except GeneratorExit:
            kept = self.leave()
            if self.started:
                self.tell(*((Status.PREEMPTED, 0, "cancelled") if nested else (Status.RUNNING, 0, "stopping")))
            raise
        except Interruption as interruption:
            if nested:
                self.tell(Status.ERROR, BROKEN, str(interruption))
            raise
        finally:
            if not kept:
                self.release()
        self.tell(*end_of(outcome))
        return outcome

    def tick(self, part: Execution[Outcome]) -> Outcome | None:
        """Ticks a part of it; returns its outcome, None while it goes on.

        Raises:
            EndlessCalls: Modules call each other without end; of the outermost module, that is its failure.
        """
        try:
            return contained(self.name, lambda: tick(part))
        except EndlessCalls as error:
            if self._outer.callers:
                raise
            return Failure(str(error), BROKEN)

    def tell(self, status: Status, code: int, text: str) -> None:
        """Reports its state, progress code, and words for a person."""
        more = {"id": self.id, "parent": self._outer.id, "target": self.target, "implementation": self.implementation}
        self._outer.publish(self._kind, self.name, status, code, text, **more)

    def inner_scope(self, **changes: Any) -> Scope:
        """Returns the scope of what is part of it."""
        outer = self._outer
        callers = (*outer.callers, self.name)
        return replace(outer, unfinished=[], callers=callers, id=self.id, parent=outer.id, **changes)

    def cancel(self, reason: str) -> bool:  # noqa: ARG002 - for those that can
        """Ends it in the coming tick, with what must follow; returns False for what can only be stopped."""
        return False

    def account(self) -> dict[str, Any]:
        """Returns what it was run with, and what was found last of its conditions, as plain data."""
        return {"inputs": dict(self.arguments), "conditions": []}

    @property
    def target(self) -> str:
        """Id of the element that it is done to, as far as that is known."""
        return ""

    @property
    def implementation(self) -> str | None:
        """Label of the way in which it is done, as far as that is known."""
        return None

    @abstractmethod
    def run(self) -> Execution[Outcome]:
        """Does it."""

    @abstractmethod
    def leave(self) -> bool:
        """Ends it at once where it is; returns whether it keeps its devices to recover."""

    def release(self) -> None:
        """Gives its devices back; may be called twice."""
        if self._claim is not None:
            self._claim.release()

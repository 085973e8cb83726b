"""Runs a skill's body: a tree of data becomes a generator of generators."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from skiros_py.errors import SkirosError, UnknownName
from skiros_py.execution.monitor import ModuleEvent, Monitor, Status
from skiros_py.skills.composition import AssertEffects, Do, Fallback, Node, P, Retry, Sequence
from skiros_py.skills.context import RunContext
from skiros_py.skills.outcome import BROKEN, Failure, Outcome, Success
from skiros_py.skills.primitive import Execution, Primitive

__all__ = ["Scope", "run_node"]

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Scope:
    """What a body runs in.

    Attributes:
        context: World, devices, libraries.
        primitives: Classes by name.
        monitor: Takes module events.
        arguments: The skill's parameters.
        assert_effects: Writes all of the skill's effects; for fakes.
        interrupted: Primitives that were broken off and may have motion to make up for (:meth:`Primitive.recover`).
    """

    context: RunContext
    primitives: Mapping[str, type[Primitive[Any]]]
    monitor: Monitor
    arguments: Mapping[str, Any]
    assert_effects: Callable[[], None]
    interrupted: list[Primitive[Any]] = field(default_factory=list)


def run_node(node: Node, scope: Scope) -> Execution[Outcome]:
    """Runs one node; a successor starts in the very next cycle."""
    match node:
        case Do(name, arguments):
            return (yield from _do(name, arguments, scope))
        case Sequence(children):
            return (yield from _until(children, scope, ends_with=Failure))
        case Fallback(children):
            return (yield from _until(children, scope, ends_with=Success))
        case Retry(child, times):
            return (yield from _until((child,) * times, scope, ends_with=Success))
        case AssertEffects(seconds):
            return (yield from _pretend(seconds, scope))


def _until(children: tuple[Node, ...], scope: Scope, *, ends_with: type[Outcome]) -> Execution[Outcome]:
    outcome: Outcome = Success()
    for index, child in enumerate(children):
        if index:
            yield
        outcome = yield from run_node(child, scope)
        if isinstance(outcome, ends_with):
            return outcome
    return outcome


def _do(name: str, arguments: Mapping[str, Any], scope: Scope) -> Execution[Outcome]:
    if name not in scope.primitives:
        raise UnknownName("primitive", name, scope.primitives)
    cls = scope.primitives[name]
    values = {key: scope.arguments[v.key] if isinstance(v, P) else v for key, v in arguments.items()}

    def tell(status: Status, code: int, text: str) -> None:
        scope.monitor.publish(ModuleEvent(scope.context.now, "primitive", name, status, code, text))

    context = replace(scope.context, report=lambda _module, code, text: tell(Status.RUNNING, code, text))
    tell(Status.STARTED, 0, ", ".join(f"{k}={v}" for k, v in values.items()))
    primitive = cls(context, cls.Params(**values))
    try:
        outcome = yield from primitive.execute()
    except SkirosError:
        raise
    except Exception as error:  # noqa: BLE001 - an author's mistake ends this primitive, not the platform
        outcome = Failure(f"{name} broke: {type(error).__name__}: {error}", BROKEN)
        _log.exception("primitive %s broke", name)
    except GeneratorExit:
        scope.interrupted.append(primitive)
        tell(Status.PREEMPTED, 0, "stopped")
        raise
    if isinstance(outcome, Failure):
        tell(Status.ERROR, outcome.code, outcome.reason)
    else:
        tell(Status.TERMINATED, 1, outcome.message)
    return outcome


def _pretend(seconds: float, scope: Scope) -> Execution[Outcome]:
    end = scope.context.now + seconds
    while scope.context.now < end:
        yield
    scope.assert_effects()
    return Success("pretended")

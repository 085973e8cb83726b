"""One run of a primitive: its devices, its life cycle, and whatever its author's code does instead of ending well."""

from __future__ import annotations

import logging
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from skiros_py.errors import SkirosError, UsageError
from skiros_py.execution.claims import Claim
from skiros_py.execution.hardware import complete, devices_of
from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.execution.pulse import CycleOverrun
from skiros_py.execution.scope import Scope, Unfinished
from skiros_py.skills.outcome import BROKEN, Failure, Outcome, Success
from skiros_py.skills.parameters import missing, params_of, read_arguments
from skiros_py.skills.primitive import Execution, Primitive

__all__ = ["Loaded", "Take", "run_primitive"]

_log = logging.getLogger(__name__)

Take = Callable[[str, set[str], Claim | None], Claim]
"""Asks for devices: who asks, which, and out of whose."""


@dataclass(frozen=True, slots=True)
class Loaded:
    """A primitive that a skill manager has loaded.

    Attributes:
        cls: Its class.
        config: Values of its configuration parameters.
        resource: What its :meth:`~skiros_py.skills.primitive.Primitive.load` returned.
    """

    cls: type[Primitive[Any]]
    config: Mapping[str, Any]
    resource: Any


def run_primitive(loaded: Loaded, given: Mapping[str, Any], scope: Scope, take: Take) -> Execution[Outcome]:
    """Runs one primitive within a scope.

    Args:
        loaded: The primitive.
        given: Its parameters; devices that are left out are those of the subsystem, where there is only one.
        scope: What it runs in.
        take: Asks for its devices.
    """
    primitive = loaded.cls
    tell = _teller(primitive.name, scope)
    world = scope.context.world
    try:
        params = params_of(primitive.Params)
        values = complete(world, params, {**read_arguments(params, given, world), **loaded.config}, scope.agent)
        open_ = missing(params, values)
        if open_:
            raise UsageError(f"{', '.join(open_)}: not specified")
        claim = take(primitive.name, devices_of(world, params, primitive.takes, values), scope.claim)
    except SkirosError as error:
        failure = Failure(f"{primitive.name}: {error}")
        tell(Status.ERROR, failure.code, failure.reason)
        return failure
    return (yield from _with_devices(primitive, values, scope, claim, loaded.resource, tell))


def _with_devices(
    cls: type[Primitive[Any]],
    values: Mapping[str, Any],
    scope: Scope,
    claim: Claim,
    resource: Any,
    tell: Callable[[Status, int, str], None],
) -> Execution[Outcome]:
    made: Primitive[Any] | None = None
    execution: Generator[None, None, Outcome] | None = None
    kept = False
    try:
        while not claim.granted:
            yield
        tell(Status.STARTED, 0, ", ".join(f"{k}={v}" for k, v in values.items()))
        made = cls(_own_context(scope, claim, tell), cls.Params(**values), resource)
        refusal = made.start()
        execution = _generator(made) if refusal is None else _refused(refusal)
        while True:
            try:
                value = next(execution)
            except StopIteration as end:
                outcome = _outcome(end.value)
                break
            if value is not None:
                raise TypeError(f"it yielded {value!r}: yield nothing, and call others with 'yield from'")
            yield
    except GeneratorExit:
        _break_off(cls.name, made, execution)
        if made is not None:
            scope.unfinished.append(Unfinished(cls.name, made.recover, claim))
            kept = True
        tell(*((Status.PREEMPTED, 0, "broken off") if scope.callers else (Status.RUNNING, 0, "stopping")))
        raise
    except (KeyboardInterrupt, CycleOverrun):
        raise
    except BaseException as error:  # noqa: BLE001 - an author's mistake ends this primitive, not the platform
        outcome = Failure(f"{cls.name} broke: {_words(error)}", BROKEN)
        _log.exception("primitive %s, %s, broke", cls.name, _origin(cls))
    finally:
        if not kept:
            claim.release()
    if isinstance(outcome, Failure):
        tell(Status.ERROR, outcome.code, outcome.reason)
    else:
        tell(Status.TERMINATED, 1, outcome.message)
    return outcome


def _outcome(returned: object) -> Outcome:
    if not isinstance(returned, Success | Failure):
        raise TypeError(f"it returned {returned!r}: a run returns Success or Failure")
    return returned


def _refused(refusal: Failure) -> Generator[None, None, Outcome]:
    yield from ()
    return refusal


def _generator(made: Primitive[Any]) -> Generator[None, None, Outcome]:
    execution = made.execute()
    if not isinstance(execution, Generator):
        raise TypeError(f"execute() returned {execution!r} instead of running: it has no 'yield'")
    return execution


def _own_context(scope: Scope, claim: Claim, tell: Callable[[Status, int, str], None]) -> Any:
    """Returns the context of one primitive: it reports in its own name, and shares its devices with what it calls."""
    inner = replace(scope, claim=claim)
    return replace(
        scope.context,
        report=lambda _module, code, text: tell(Status.RUNNING, code, text),
        call=lambda module, arguments: scope.modules.run(module, arguments, inner),
    )


def _break_off(name: str, made: Primitive[Any] | None, execution: Generator[None, None, Outcome] | None) -> None:
    """Closes what ran; what its author's clean-up raises must not keep the others from being stopped."""
    for end in (execution.close if execution is not None else None, made.stop if made is not None else None):
        try:
            if end is not None:
                end()
        except (KeyboardInterrupt, CycleOverrun):
            raise
        except BaseException:  # noqa: BLE001 - an author's mistake, which must not keep others from being stopped
            _log.exception("primitive %s broke while it was stopped", name)


def _teller(name: str, scope: Scope) -> Callable[[Status, int, str], None]:
    caller = scope.callers[-1] if scope.callers else ""

    def tell(status: Status, code: int, text: str) -> None:
        event = ModuleEvent(
            scope.context.board.snapshot.time, "primitive", name, status, code, text, agent=scope.agent, caller=caller
        )
        scope.monitor.publish(event)

    return tell


def _words(error: BaseException) -> str:
    if isinstance(error, SystemExit):
        return f"it tried to end the program: sys.exit({error.code!r})"
    return f"{type(error).__name__}: {error}"


def _origin(cls: type) -> str:
    return f"{cls.__module__}.{cls.__qualname__}"

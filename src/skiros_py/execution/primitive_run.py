"""One run of a primitive: its devices, its life cycle, and whatever its author's code does instead of ending well."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from skiros_py.errors import UsageError
from skiros_py.execution.claims import Claim
from skiros_py.execution.contained import broken, contained
from skiros_py.execution.hardware import complete, devices_of, standstill
from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.execution.pulse import CycleOverrun
from skiros_py.execution.scope import Scope, Unfinished, make_up
from skiros_py.skills.context import RunContext
from skiros_py.skills.outcome import BROKEN, Failure, Outcome, Success
from skiros_py.skills.parameters import missing, params_of, read_arguments
from skiros_py.skills.primitive import Execution, Primitive

__all__ = ["Loaded", "Take", "run_primitive"]

Take = Callable[[str, set[str], Claim | None], Claim]
"""Asks for devices: who asks, which, and out of whose."""
_Tell = Callable[[Status, int, str], None]


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
    name = loaded.cls.name
    tell = _teller(name, scope)
    specified = contained(name, lambda: _specify(loaded, given, scope, take))
    if isinstance(specified, Failure):
        tell(Status.ERROR, specified.code, specified.reason)
        return specified
    values, claim = specified
    return (yield from _Run(loaded, values, scope, claim, tell).execute())


def _specify(loaded: Loaded, given: Mapping[str, Any], scope: Scope, take: Take) -> tuple[dict[str, Any], Claim]:
    """Completes the parameters and asks for the devices.

    Raises:
        SkirosError: Something is wrong with what is given, is missing, or is not there.
    """
    cls, world = loaded.cls, scope.context.world
    params = params_of(cls.Params)
    values = complete(world, params, {**read_arguments(params, given, world), **loaded.config}, scope.agent)
    open_ = missing(params, values)
    if open_:
        raise UsageError(f"{', '.join(open_)}: not specified")
    devices = set() if cls.watches else devices_of(world, params, cls.takes, values)  # who only looks on takes nothing
    return values, take(cls.name, devices, scope.claim)


class _Run:
    """One run of a primitive that is specified and has asked for its devices.

    What it calls runs in a scope of its own: what of that its author breaks off makes up for it before the next call,
    and before the run ends.
    """

    def __init__(self, loaded: Loaded, values: Mapping[str, Any], scope: Scope, claim: Claim, tell: _Tell) -> None:
        self._loaded = loaded
        self._values = values
        self._scope = scope
        self._calls = replace(scope, claim=claim, unfinished=[], callers=(*scope.callers, loaded.cls.name))
        self._claim = claim
        self._tell = tell
        self._made: Primitive[Any] | None = None
        self._started = False
        self._broken = False
        self._code = self._life()

    def execute(self) -> Execution[Outcome]:
        """Waits for its devices, then runs it; also reports to the monitor."""
        kept = False
        try:
            while not self._claim.granted:
                yield
            self._started = True
            self._tell(Status.STARTED, 0, ", ".join(f"{k}={v}" for k, v in self._values.items()))
            outcome = yield from self._ticks()
            yield from make_up(self._calls)
            if self._broken:
                yield from standstill(self._scope.context.board, self._claim.devices)
        except GeneratorExit:
            kept = self._break_off()
            raise
        except CycleOverrun:
            if self._scope.callers:  # else whoever started it tells, when all stands
                self._tell(Status.ERROR, BROKEN, "held the control cycle too long")
            raise
        finally:
            if not kept:
                self._claim.release()
        if isinstance(outcome, Failure):
            self._tell(Status.ERROR, outcome.code, outcome.reason)
        else:
            self._tell(Status.TERMINATED, 1, outcome.message)
        return outcome

    def _ticks(self) -> Execution[Outcome]:
        while True:
            outcome = self._tick()
            if outcome is not None:
                return outcome
            yield

    def _tick(self) -> Outcome | None:
        """Runs its author's code up to the next ``yield``; returns how it ended, None while it goes on."""
        try:
            yielded: object = next(self._code)
        except StopIteration as end:
            ended: object = end.value
            if isinstance(ended, Success | Failure):
                return ended
            return self._broke(TypeError(f"it returned {ended!r}: a run returns Success or Failure"))
        except (KeyboardInterrupt, CycleOverrun):
            raise
        except BaseException as error:  # noqa: BLE001 - an author's mistake ends this primitive, not the platform
            return self._broke(error)
        if yielded is None:
            return None
        return self._broke(TypeError(f"it yielded {yielded!r}: yield nothing, and call others with 'yield from'"))

    def _life(self) -> Execution[Outcome]:
        """Its author's code, from its making to its end."""
        cls = self._loaded.cls
        made = self._made = cls(self._own_context(), cls.Params(**self._values), self._loaded.resource)
        refusal = made.start()
        if refusal is not None:
            return refusal
        execution = made.execute()
        if not isinstance(execution, Generator):
            raise TypeError(f"execute() returned {execution!r} instead of running: it has no 'yield'")
        return (yield from execution)

    def _own_context(self) -> RunContext:
        """Returns its own context: it reports in its own name, and shares its devices with what it calls."""
        return replace(
            self._scope.context,
            report=lambda _module, code, text: self._tell(Status.RUNNING, code, text),
            call=self._call,
        )

    def _call(self, module: str, arguments: Mapping[str, Any]) -> Execution[Outcome]:
        yield from make_up(self._calls)
        return (yield from self._calls.modules.run(module, arguments, self._calls))

    def _broke(self, error: BaseException) -> Failure:
        """Lets its devices brake; they stay its own until they stand."""
        self._broken = True
        cls = self._loaded.cls
        failure = broken(cls.name, error, f"{cls.__module__}.{cls.__qualname__}")
        self._close()
        return failure

    def _close(self) -> None:
        """Ends its author's code and takes back what it commanded; what clean-up raises must not keep others moving."""
        contained(f"{self._loaded.cls.name}, when it was ended,", self._code.close)
        self._scope.context.board.clear(self._claim.devices)

    def _break_off(self) -> bool:
        """Ends it at once; returns whether it keeps its devices to make up for that."""
        if not self._started:
            return False
        self._close()
        self._scope.unfinished.extend(self._calls.unfinished)
        made = self._made
        if made is not None:
            contained(f"{made.name}, when it was stopped,", made.stop)
            self._scope.context.board.clear(self._claim.devices)
            self._scope.unfinished.append(Unfinished(made.name, made.recover, self._claim))
        nested = bool(self._scope.callers)
        self._tell(*((Status.PREEMPTED, 0, "broken off") if nested else (Status.RUNNING, 0, "stopping")))
        return made is not None


def _teller(name: str, scope: Scope) -> _Tell:
    caller = scope.callers[-1] if scope.callers else ""

    def tell(status: Status, code: int, text: str) -> None:
        event = ModuleEvent(
            scope.context.board.snapshot.time, "primitive", name, status, code, text, agent=scope.agent, caller=caller
        )
        scope.monitor.publish(event)

    return tell

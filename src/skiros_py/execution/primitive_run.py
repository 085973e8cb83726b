"""One run of a primitive: its devices, its life cycle, and whatever its author's code does instead of ending well."""

from __future__ import annotations

import logging
from collections.abc import Callable, Generator, Mapping
from dataclasses import replace
from itertools import count
from math import inf
from typing import Any

from skiros_py.errors import UsageError
from skiros_py.execution.claims import Claim, complete, devices_of, standstill
from skiros_py.execution.loader import Loaded, Loader
from skiros_py.execution.module_faults import broken, contained
from skiros_py.execution.monitor import Status
from skiros_py.execution.scope import ModuleRun, Scope, Unfinished, failed, run_recovery
from skiros_py.execution.time_limit import TimeLimit
from skiros_py.interruptions import CycleOverrun, EndlessCalls, by_user
from skiros_py.messages import Message, joined
from skiros_py.skills.context import RunContext
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.parameters import Access, missing, params_of, read_arguments
from skiros_py.skills.parameters.values import refusal
from skiros_py.skills.primitive import Execution, Primitive

_log = logging.getLogger(__name__)

Take = Callable[[str, Mapping[str, Access], Claim | None], Claim]
"""Asks for devices: for which module, which devices in which way, and out of which claim."""


_NOT_TEXTS = ("number", "integer", "boolean", "vector", "pose")
"""Types whose values a command line gives as texts; code does not."""


class PrimitiveRun(ModuleRun):
    """One run of a primitive.

    What it calls runs in a scope of its own. A cancelled call recovers while the primitive goes on, but before the
    next call begins and before the run ends.

    Args:
        name: The primitive.
        loader: Loads it.
        given: Its parameters; devices that are left out are those of the subsystem, where there is only one.
        scope: What it runs in.
        take: Asks for its devices.
        run: Id of this run; a new one where left out.
    """

    def __init__(
        self, name: str, loader: Loader, given: Mapping[str, Any], scope: Scope, take: Take, run: str = ""
    ) -> None:
        context = replace(scope.context, questions=scope.context.questions.within())
        super().__init__("primitive", name, given, replace(scope, context=context), run)
        self._loader = loader
        self._loaded: Loaded
        self._values = given
        self._take = take
        self._board = scope.context.board
        self._calls = self.inner_scope()
        self._open: dict[int, Execution[Outcome]] = {}
        self._numbers = count()
        self._recovering: Execution[None] | None = None
        self._recovered_in = -1
        self._made: Primitive[Any] | None = None
        self._broken = False
        self._limit: TimeLimit
        self._code: Execution[Outcome] | None = None
        self._next: Callable[[], object] = self._begin

    def run(self) -> Execution[Outcome]:
        """Specifies it and waits for its devices, then runs it."""
        loaded = self._loader.get(self.name, self._outer.context)
        if isinstance(loaded, Failure):
            return loaded
        self._loaded = loaded
        claim = contained(self.name, self._specify)
        if isinstance(claim, Failure):
            return claim
        while not claim.granted:
            yield
        self.started = True
        self.tell(Status.STARTED, 0, ", ".join(f"{k}={v}" for k, v in self._values.items()))
        cls = loaded.cls
        self._limit = TimeLimit(self._outer.context, cls.duration, inf if cls.watches else cls.limit)
        cycles = count(1)
        while True:
            outcome = self._tick()
            if outcome is None and not next(cycles) % _CYCLES:
                outcome = self._overdue()
            if outcome is not None:
                break
            if self._calls.unfinished or self._recovering is not None:
                self._recover_calls()
            yield
        self._end_calls()
        while self._recover_calls():
            yield
        if self._broken:
            yield from standstill(self._board, claim)
        return outcome

    def _specify(self) -> Claim:
        """Completes the parameters and asks for the devices.

        Raises:
            SkirosError: Something is wrong with what is given, is missing, or is not there.
        """
        cls, world, scope = self._loaded.cls, self._outer.context.world, self._outer
        scope.check_depth(cls.name)
        params = params_of(cls.Params)
        given = {**read_arguments(params, self._values, world), **self._loaded.config}
        values = self._values = complete(world, params, given, scope.agent)
        open_ = missing(params, values)
        if open_:
            raise UsageError("{keys}: not specified", keys=", ".join(open_))
        devices = {} if cls.watches else devices_of(world, params, cls.takes, values)  # one that watches takes nothing
        claim = self._claim = self._take(cls.name, devices, scope.claim)
        self._calls = replace(self._calls, claim=claim)
        return claim

    def leave(self) -> bool:
        """Ends it at once; returns whether it keeps its devices to recover."""
        made, claim = self._made, self._claim
        if not self.started or claim is None:
            return False
        self._close()
        if self._recovering is not None:
            self._recovering.close()
        self._outer.unfinished.extend(self._calls.unfinished)
        if made is not None:
            self._tidy("when it was stopped", made.stop)
            self._outer.unfinished.append(Unfinished(made.name, made.recover, claim))
        return made is not None

    def _tick(self) -> Outcome | None:
        """Runs its author's code up to the next ``yield``; returns how it ended, None while it goes on.

        Meanwhile no other devices obey than those it has taken.
        """
        board = self._board
        outer, board.share = board.share, self._claim
        try:
            yielded: object = self._next()
        except StopIteration as end:
            ended: object = end.value
            if isinstance(ended, Success | Failure):
                return self._checked(ended)
            return self._broke(TypeError(f"it returned {ended!r}: a run returns Success or Failure"))
        except BaseException as error:
            is_callers = isinstance(error, EndlessCalls) and self._outer.callers
            if is_callers or isinstance(error, CycleOverrun) or by_user(error):
                raise
            return self._broke(error)
        finally:
            board.share = outer
        if yielded is None:
            return None
        return self._broke(TypeError(f"it yielded {yielded!r}: yield nothing, and call others with 'yield from'"))

    def _checked(self, outcome: Outcome) -> Outcome:
        """Returns an outcome; one with values other than the primitive declares is a mistake in its code."""
        if isinstance(outcome, Failure):
            reason: object = outcome.reason
            if isinstance(reason, str) and type(outcome.code) is int:
                return outcome
            return self._broke(TypeError(f"it returned {outcome!r}: the reason is a text, the code a whole number"))
        given: object = outcome.values
        if given == {}:
            return outcome
        declared = {output.name: output.param for output in self._loaded.cls.outputs}
        try:
            if not isinstance(given, Mapping):
                raise TypeError(f"the values of its outcome are given by name, not as {given!r}")
            for key in declared.keys() & given.keys():
                value, param = given[key], declared[key]
                if value is None or (isinstance(value, str) and param.type in _NOT_TEXTS):
                    raise UsageError(refusal(param, value, "output"))
            values = read_arguments(tuple(declared.values()), given, self._outer.context.world, "output")
        except Exception as error:  # noqa: BLE001 - what an author returns may be anything
            return self._broke(error)
        return Success(outcome.message, {key: values[key] for key in given})

    def _begin(self) -> object:
        """Makes the primitive, starts it, and runs it up to its first ``yield``."""
        cls = self._loaded.cls
        made = self._made = cls(self._own_context(), cls.Params(**self._values), self._loaded.resource)
        refusal = made.start()
        if refusal is not None and not isinstance(refusal, Failure):
            raise TypeError(f"start() returned {refusal!r}: None lets it run, a Failure refuses")
        self._code = made.execute() if refusal is None else failed(refusal)
        if not isinstance(self._code, Generator):
            raise TypeError(f"execute() returned {self._code!r} instead of running: it has no 'yield'")
        self._next = self._code.__next__
        return self._next()

    def _own_context(self) -> RunContext:
        """Returns its own context: it reports in its own name, and shares its devices with what it calls."""
        return replace(
            self._outer.context,
            report=self._report,
            call=self._call,
            emit=self._calls.emit,
        )

    def _report(self, _module: str, code: int, text: str) -> None:
        self._limit.progress()
        self.tell(Status.RUNNING, code, text)

    def _overdue(self) -> Failure | None:
        """Ends it where it takes too long; says, once, where it waits when it makes no progress."""
        told = self._limit.stalled
        why = self._limit.why_over(self._gets_on)
        if self._limit.stalled and not (told or self._loaded.cls.watches):
            text = Message("makes no progress{where}", where=_where_it_waits(self._code))
            _log.warning("%s %s", self.name, text)
            self.tell(Status.RUNNING, 0, text)
        if not why:
            return None
        self._broken = True  # its devices stay its own until they stand
        where = _where_it_waits(self._code)
        self._close()
        if self._made is not None:
            self._tidy("when it took too long", self._made.stop)
        return Failure(joined("", (self.name, " ", why, where)))

    def _gets_on(self) -> bool:
        claim = self._claim
        return bool(self._open) or (claim is not None and not self._board.stand(claim.devices))

    # ------------------------------------------------------------------ what it calls

    def _call(self, module: str, arguments: Mapping[str, Any]) -> Execution[Outcome]:
        number = next(self._numbers)
        called = self._open[number] = self._called(number, module, arguments)
        return called

    def _called(self, number: int, module: str, arguments: Mapping[str, Any]) -> Execution[Outcome]:
        try:
            while self._recover_calls():
                yield
            calls = replace(self._calls, path=f"{self._calls.path}/{module}")
            return (yield from calls.modules.run(module, arguments, calls))
        finally:
            self._open.pop(number, None)

    def _recover_calls(self) -> bool:
        """Ticks, once in a cycle, the recovery of cancelled calls; returns whether there is more to do."""
        if self._recovering is None and not self._calls.unfinished:
            return False
        cycle = self._board.snapshot.cycle
        if cycle != self._recovered_in:
            self._recovered_in = cycle
            self._recovering = self._recovering or run_recovery(self._calls)
            if next(self._recovering, _ENDED) is _ENDED:
                self._recovering = None
        return self._recovering is not None or bool(self._calls.unfinished)

    def _end_calls(self) -> None:
        """Cancels calls that were not ticked to their end."""
        for call in reversed(list(self._open.values())):
            self._tidy("when a call was ended", call.close)
        self._open.clear()

    # ------------------------------------------------------------------ ending

    def _broke(self, error: BaseException) -> Failure:
        """Lets its devices brake; they stay its own until they stand."""
        self._broken = True
        cls = self._loaded.cls
        failure = broken(cls.name, error, f"{cls.__module__}.{cls.__qualname__}")
        self._close()
        return failure

    def _close(self) -> None:
        """Ends its author's code and what that has called."""
        if isinstance(self._code, Generator):
            self._tidy("when it was ended", self._code.close)
        self._end_calls()

    def _tidy(self, when: str, action: Callable[[], object]) -> None:
        """Calls what its author wrote for its end; neither what that raises nor what it commands counts."""
        claim = self._claim
        assert claim is not None, "its code runs with its devices only"
        contained(f"{self.name}, {when},", lambda: self._board.limited(claim, action))
        self._board.clear(claim)


def _where_it_waits(code: object) -> str:
    """Returns the place of the innermost ``yield`` at which a generator waits, for a message."""
    frame = None
    while isinstance(code, Generator):
        frame, code = getattr(code, "gi_frame", None) or frame, getattr(code, "gi_yieldfrom", None)
    if frame is None:
        return ""
    at = frame.f_code
    return Message(": it waits in {code}, {file}:{line}", code=at.co_qualname, file=at.co_filename, line=frame.f_lineno)


_CYCLES = 32
"""Cycles between two looks at the time of a run: a look costs as much as a cycle of a run that waits."""
_ENDED = object()

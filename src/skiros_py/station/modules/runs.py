"""Modules started by callers: followed until they end, repeated if requested, and kept for a while."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict, deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import count
from typing import Any, Literal

from skiros_py.api.modules import ModuleRunStatus
from skiros_py.errors import SkirosError, UnknownName, WrongState
from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.execution.panel import Panel
from skiros_py.execution.running import RunningModule
from skiros_py.listeners import Listeners
from skiros_py.messages import Message
from skiros_py.skills.outcome import Failure, Outcome
from skiros_py.station.requests import addressed
from skiros_py.station.session import Session
from skiros_py.world.change import Change

Turn = Literal["paused", "resumed"]
"""Transitions of an active run."""
_KEPT = 200
"""Number of ended runs kept; the oldest are dropped first."""
_ROUNDS, _PROGRESS, _CHANGES = 100, 500, 100
"""Number of latest entries of each kind kept of one run."""
_AT_ONCE = 4
"""Cycles within which a run that must start immediately has to get its devices: one to start, and some to spare."""


@dataclass(frozen=True, slots=True)
class Wish:
    """A requested run.

    Attributes:
        agent: Id of the subsystem.
        module: Name of the module.
        given: Value by parameter key; omitted ones are inferred.
        by: Name of the caller who requested it.
        repeat: Number of times to run it.
        at_once: True if it must not wait for devices, because a person watches it.
        breakpoints: Paths of nodes before which it is paused, with or without the name of the module as prefix.
    """

    agent: str
    module: str
    given: Mapping[str, Any]
    by: str
    repeat: int = 1
    at_once: bool = False
    breakpoints: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Round:
    """The result of one repetition.

    Attributes:
        outcome: Its outcome.
        start, end: Run time [s].
    """

    outcome: Outcome
    start: float
    end: float


class ModuleRun:
    """One run; written in the control thread, read in any thread.

    Attributes:
        id: Its id.
        wish: The request.
        kind: "skill" or "primitive".
        params: The parameters of its module.
        wall: When it was started [s since 1970].
        values: Its arguments as far as known, including inferred ones.
        running: The module that runs now, or that ran last if the run is over.
        rounds: The results of its repetitions; only the latest of very many.
        done: Number of repetitions that have ended.
        succeeded: Number of repetitions that succeeded.
        progress: Its progress reports.
        changes: Its changes of the world.
        ended_as: Its final status; None while it is active.
        cut_off: True if the last repetition was cancelled, so that its outcome says nothing about the module.
        begun: True if it has its devices, in this repetition.
        breakpoints: Paths of nodes before which it is paused.
    """

    def __init__(self, id_: str, wish: Wish, kind: str, panel: Panel, running: RunningModule, now: float) -> None:
        self.id = id_
        self.wish = wish
        self.kind = kind
        self.params = panel.params
        self.wall = time.time()
        self.values = dict(panel.values)
        self.rounds: deque[Round] = deque(maxlen=_ROUNDS)
        self.done = 0
        self.succeeded = 0
        self.progress: deque[ModuleEvent] = deque(maxlen=_PROGRESS)
        self.changes: deque[Change] = deque(maxlen=_CHANGES)
        self.ended_as: Literal["stopped", "succeeded", "failed"] | None = None
        self.cut_off = False
        self.stop_wanted = False
        self.refusal = ""
        self.breakpoints: frozenset[str] = frozenset()
        self._stood = False
        self.begin(running, now)
        self.set_breakpoints(wish.breakpoints)

    @property
    def over(self) -> bool:
        """True if it has ended."""
        return self.ended_as is not None

    @property
    def status(self) -> ModuleRunStatus:
        """Its present or final status."""
        if self.ended_as is not None:
            return self.ended_as
        status = self.running.status
        return "paused" if status == "paused" else "stopping" if status in ("stopping", "stopped") else "running"

    def command(self, verb: str) -> None:
        """Pauses, resumes, steps or stops it; to be called in the control thread.

        Raises:
            WrongState: It is over, or is already stopping; stopping it again has no effect.
        """
        if verb == "stop":
            if self.over:
                return
        elif self.over or self.status == "stopping":
            raise WrongState(
                "run {run} of {module} is {status}: it takes no {verb}",
                run=self.id,
                module=self.wish.module,
                status=self.status,
                verb=verb,
            )
        self.stop_wanted = self.stop_wanted or verb == "stop"
        getattr(self.running, verb)()

    def set_breakpoints(self, paths: Iterable[str]) -> None:
        """Replaces its breakpoints; to be called in the control thread."""
        module = self.wish.module
        self.breakpoints = frozenset(p if p.startswith(f"{module}/") else f"{module}/{p}" for p in paths)
        self.running.breakpoints.clear()
        self.running.breakpoints.update(self.breakpoints)

    def turn(self) -> Turn | None:
        """Returns its transition since the last call: it was paused, or it was resumed."""
        before, self._stood = self._stood, self.status == "paused"
        if self._stood:
            return None if before else "paused"
        return "resumed" if before and self.status == "running" else None  # otherwise it was stopped meanwhile

    def is_about(self, event: ModuleEvent) -> bool:
        """Returns whether an event concerns the module itself, not a part of it."""
        return event.id == self.running.id

    def begin(self, running: RunningModule, now: float) -> None:
        """Records the start of a repetition."""
        self.running, self.since, self.cycles, self.begun = running, now, 0, False
        running.breakpoints.update(self.breakpoints)

    def note(self, event: ModuleEvent) -> None:
        """Records an event."""
        self.progress.append(event)
        if event.status is Status.STARTED and self.is_about(event):
            self.begun = True
        if event.kind == "skill" and self.begun:
            inferred = {k: v for k, v in self.running.arguments.items() if k not in self.wish.given}
            self.values = {**self.values, **inferred}

    def end(self, outcome: Outcome, now: float) -> None:
        """Records the end of a repetition."""
        self.rounds.append(Round(outcome, self.since, now))
        self.done += 1
        self.succeeded += not isinstance(outcome, Failure)
        was_cancelled = self.running.status == "stopped"  # perhaps together with everything else
        stopped = self.stop_wanted or (was_cancelled and self.running.task.fault is None)
        had_ended = self.running.done and not was_cancelled  # before it could be cancelled
        self.cut_off = stopped and isinstance(outcome, Failure) and not had_ended
        if stopped or self.refusal or self.done >= self.wish.repeat:
            good = self.succeeded == self.wish.repeat
            self.ended_as = "succeeded" if good else "stopped" if stopped and not self.refusal else "failed"


class ModuleRuns:
    """The modules started by callers, of all sessions of one server.

    Args:
        name: Prefix of the ids of runs, which makes them differ from those of other starts of the server.

    Attributes:
        turns: Called when a run was paused, and when it continues.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._numbers = count(1)
        self._runs: OrderedDict[str, ModuleRun] = OrderedDict()
        self._active: tuple[ModuleRun, ...] = ()
        self.turns = Listeners[[ModuleRun, Turn]]("turns of modules")
        self._guard = threading.Lock()

    # ------------------------------------------------------------------ reading

    def all(self) -> tuple[ModuleRun, ...]:
        """Returns the active and recent runs, newest first."""
        with self._guard:
            return tuple(reversed(self._runs.values()))

    def find(self, id_: str) -> ModuleRun:
        """Returns a run.

        Raises:
            NotFound: There is none, or it ended long ago.
        """
        with self._guard, addressed():
            if id_ not in self._runs:
                raise UnknownName("module run", id_, tuple(reversed(self._runs))[:20])
            return self._runs[id_]

    # ------------------------------------------------------------------ in the control thread

    def start(self, session: Session, wish: Wish) -> ModuleRun:
        """Starts a module; to be called in the control thread.

        Raises:
            UnknownName: There is no such module, parameter or element.
            UsageError: The arguments are not valid.
            WrongState: It cannot be started now: it runs already, its manager is lost, or everything is halted.
        """
        manager = session.managers[wish.agent]
        panel, kind = manager.panel(wish.module, wish.given), manager.info(wish.module).kind
        running = session.start_module(wish.module, wish.given, wish.agent)
        id_ = f"{self._name}-{next(self._numbers)}"
        run = ModuleRun(id_, wish, kind, panel, running, session.cycle.board.now)
        with self._guard:
            self._runs[run.id] = run
            over = [id_ for id_, one in self._runs.items() if one.over]
            for id_ in over[: max(0, len(over) - _KEPT)]:
                del self._runs[id_]
        self._active = (*self._active, run)
        return run

    def open(self, session: Session) -> None:
        """Follows the modules of a session, from its first cycle on."""
        session.cycle.observe(lambda: self._attend(session))
        session.monitor.subscribe(partial(self._on_event, session))
        session.world.subscribe(partial(self._on_change, session))
        session.on_close(partial(self._end_all, session))

    def _end_all(self, session: Session) -> None:
        """Ends the runs that are still active together with their session."""
        for run in self._active:
            run.stop_wanted = True
            run.end(Failure(Message("the station was shut down")), session.cycle.board.now)
        self._active = ()

    def _attend(self, session: Session) -> None:
        """Checks at the end of each cycle which runs have ended, and starts the next repetition if requested."""
        for run in self._active:
            self._follow(run, session)
            if turn := run.turn():
                self.turns.notify(run, turn)
        self._active = tuple(run for run in self._active if not run.over)

    def _follow(self, run: ModuleRun, session: Session) -> None:
        running = run.running
        run.cycles += 1
        if run.wish.at_once and not run.begun and run.cycles >= _AT_ONCE and not running.task.done:
            run.refusal = Message("{module} did not start: something else uses its devices", module=run.wish.module)
            running.stop()
        manager = session.managers.get(run.wish.agent)
        if not running.done or (manager is not None and manager.running.get(run.wish.module) is running):
            return
        run.end(Failure(run.refusal) if run.refusal else running.result, session.cycle.board.now)
        if not run.over:
            self._again(run, session)

    def _again(self, run: ModuleRun, session: Session) -> None:
        if session.cycle.halted:
            run.ended_as = "stopped"  # everything was stopped after the last repetition
            return
        try:
            running = session.start_module(run.wish.module, run.wish.given, run.wish.agent)
            run.begin(running, session.cycle.board.now)
        except SkirosError as error:
            run.refusal = Message("it cannot be done once more: {error}", error=error)
            run.end(Failure(run.refusal), session.cycle.board.now)

    # ------------------------------------------------------------------ progress and changes of a run

    def _on_event(self, session: Session, event: ModuleEvent) -> None:
        for run in self._active:
            if _is_at_work(session, run) or run.is_about(event):
                run.note(event)

    def _on_change(self, session: Session, change: Change) -> None:
        for run in self._active:
            if _is_at_work(session, run):
                run.changes.append(change)


def _is_at_work(session: Session, run: ModuleRun) -> bool:
    """Returns whether the control thread is executing code of this run, so that the call comes from it."""
    activity = session.cycle.activity
    return activity.thread == threading.get_ident() and activity.task is run.running.task

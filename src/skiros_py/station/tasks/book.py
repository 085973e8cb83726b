"""The active and recent tasks of a server, each with its trace."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict, deque
from collections.abc import Callable
from typing import Any

from skiros_py.errors import UnknownName, WrongState
from skiros_py.planning.plan import Plan
from skiros_py.skills.context import Question
from skiros_py.station.session import Session
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.report import GoalReport
from skiros_py.tasks.trace import TraceEntry

_KEPT = 100
"""Number of ended tasks kept; the oldest are dropped first."""
_ENTRIES = 1000
"""Number of trace entries kept per task."""


class KeptTask:
    """One task, as seen by callers; of an ended task only these attributes are kept.

    Attributes:
        name: Its name.
        goal: Its conditions, as texts.
        job: Id of the job to which it belongs; empty for none.
        by: Name of the caller who started it; empty if a job did.
        wall: When it started [s since 1970].
        entries: The trace; only the latest entries of a very long one.
        forgotten: Number of entries that were dropped.
    """

    def __init__(self, task: TaskHandle, *, job: str = "", by: str = "") -> None:
        self.name = task.name
        self.goal = tuple(map(str, task.goal))
        self.job = job
        self.by = by
        self.wall = time.time()
        self.entries: deque[TraceEntry] = deque(task.trace.entries, maxlen=_ENTRIES)
        self.forgotten = 0
        self.task: TaskHandle | None = task
        self._plan: Plan | None = None
        self._report: GoalReport | None = None
        task.trace.subscribe(self._take)

    def _take(self, entry: TraceEntry) -> None:
        self.forgotten += len(self.entries) == _ENTRIES
        self.entries.append(entry)

    @property
    def over(self) -> bool:
        """True when it has ended."""
        return self.task is None or self.task.done

    @property
    def status(self) -> str:
        """Its present status."""
        task = self.task
        return "ended" if task is None else task.status

    @property
    def plan(self) -> Plan | None:
        """The present plan, or the last one."""
        task = self.task
        return self._plan if task is None else task.plan

    @property
    def report(self) -> GoalReport | None:
        """Its result; None until it is over."""
        task = self.task
        return self._report if task is None else task.report

    @property
    def question(self) -> Question | None:
        """Its pending question to a person."""
        task = self.task
        return None if task is None else task.question

    def command(self, verb: str, by: str) -> None:
        """Pauses, resumes, steps or stops it; takes effect in the next cycle.

        Raises:
            WrongState: It is over, or belongs to a job; stopping an ended task has no effect.
        """
        task = self.task
        if self.job and not self.over:
            raise WrongState(f"task '{self.name}' belongs to a job: command that one, /jobs/{self.job}")
        if task is None or task.done:
            if verb == "stop":
                return
            raise WrongState(f"task '{self.name}' has ended: it takes no {verb}")
        if verb == "stop":
            task.stop(f"{by} stopped it")
        else:
            getattr(task, verb)()

    def settle(self) -> None:
        """Releases the task if it is over."""
        if self.task is not None and self.task.done:
            self._plan, self._report = self.task.plan, self.task.report
            self.task = None


class TaskBook:
    """All tasks, by name; the latest of several with the same name."""

    def __init__(self) -> None:
        self._tasks: OrderedDict[str, KeptTask] = OrderedDict()
        self._guard = threading.Lock()
        self._leave: Callable[[], None] = lambda: None

    # ------------------------------------------------------------------ reading, in any thread

    def all(self) -> tuple[KeptTask, ...]:
        """Returns the tasks, newest first."""
        with self._guard:
            return tuple(reversed(self._tasks.values()))

    def find(self, name: str) -> KeptTask:
        """Returns a task.

        Raises:
            UnknownName: There is none, or it ended long ago.
        """
        with self._guard:
            if name not in self._tasks:
                raise UnknownName("task", name, tuple(self._tasks))
            return self._tasks[name]

    def job_of(self, name: str) -> str:
        """Returns the id of the job to which a task belongs; empty for none, and for a task no longer kept."""
        with self._guard:
            known = self._tasks.get(name)
        return "" if known is None else known.job

    # ------------------------------------------------------------------ in the control thread

    def open(self, session: Session) -> None:
        """Records the tasks of a session, from its first cycle on."""

        def note(task: TaskHandle) -> None:
            job = task.name if task.name in session.jobs.open else ""
            self.note(task, job=job)

        self._leave = session.tasks.on_begin(note)

    def close(self, session: Session) -> None:
        """Releases a session, whose tasks are over."""
        del session
        self._leave()
        for task in self.all():
            task.settle()

    def note(self, task: TaskHandle, **who: Any) -> KeptTask:
        """Adds a task, unless it is already known.

        Args:
            task: The task.
            **who: ``job`` or ``by``, as for :class:`KeptTask`.
        """
        with self._guard:
            known = self._tasks.get(task.name)
            if known is not None and known.task is task:
                return known
            self._tasks.pop(task.name, None)
            kept = self._tasks[task.name] = KeptTask(task, **who)
            self._forget()
        return kept

    def _forget(self) -> None:
        over = [task for task in self._tasks.values() if task.over]
        for task in over:
            task.settle()
        for task in over[: max(0, len(over) - _KEPT)]:
            del self._tasks[task.name]

"""Use cases: active and ended tasks."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict, deque
from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

from skiros_py.api.modules import RunCommand
from skiros_py.api.tasks import NewTask, TaskInfo, TaskReport, Tasks, TaskStep, TaskTrace
from skiros_py.errors import Refused, WrongState
from skiros_py.messages import Message
from skiros_py.planning.plan import Step
from skiros_py.station.document_store import SEQUENCE
from skiros_py.station.jobs.views import planned_steps
from skiros_py.station.requests import LIBRARY, Author, Service, find
from skiros_py.station.session import Session
from skiros_py.station.tasks.sequence_document import require_works, steps_of
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.policy import Policy
from skiros_py.tasks.report import GoalReport
from skiros_py.tasks.sequences import check_steps, read_step
from skiros_py.tasks.trace import TraceEntry, TraceEventKind

if TYPE_CHECKING:
    from skiros_py.station.station import Station

_KEPT = 100
"""Number of ended tasks kept; the oldest are dropped first."""
_ENTRIES = 1000
"""Number of trace entries kept per task."""
_ENDS = (TraceEventKind.ENDED, TraceEventKind.FAILED, TraceEventKind.CANCELLED)


class KeptTask:
    """One task, as seen by callers; of an ended task only its description and its trace are kept.

    Attributes:
        name: Its name.
        job: Id of the job to which it belongs; empty for none.
        by: Name of the caller who started it; empty if a job did.
        begun: When it started [s since 1970].
        entries: The trace; only the latest entries of a very long one.
        forgotten: Number of entries that were dropped.
        task: The task; None when it was released, because it is over.
    """

    def __init__(self, task: TaskHandle, *, job: str = "", by: str = "") -> None:
        self.name = task.name
        self.job = job
        self.by = by
        self.begun = time.time()
        self.entries: deque[TraceEntry] = deque(task.trace.entries, maxlen=_ENTRIES)
        self.forgotten = 0
        self.task: TaskHandle | None = task
        self._ended: TaskInfo | None = None
        task.trace.subscribe(self._take)

    def _take(self, entry: TraceEntry) -> None:
        self.forgotten += len(self.entries) == _ENTRIES
        self.entries.append(entry)

    @property
    def over(self) -> bool:
        """True when it has ended."""
        return self.task is None or self.task.done

    def info(self, *, in_full: bool = True) -> TaskInfo:
        """Describes it; callable in any thread; without ``in_full``, omits its plan and steps."""
        task = self.task
        if task is None:
            assert self._ended is not None
            return self._ended if in_full else self._ended.model_copy(update={"plan": (), "steps": ()})
        return TaskInfo.view_of(
            task,
            job=self.job,
            by=self.by,
            begun=self.begun,
            goal=tuple(map(str, task.goal)),
            plan=planned_steps(task.plan) if in_full and task.plan is not None else (),
            steps=_steps(tuple(self.entries)) if in_full else (),
            report=None if task.report is None else _report(task.report),
        )

    def trace(self, limit: int) -> TaskTrace:
        """Returns the last entries of its trace."""
        entries = tuple(self.entries)
        kept = entries[-limit:]
        forgotten = self.forgotten + len(entries) - len(kept)
        return TaskTrace(items=tuple(entry.as_json() for entry in kept), forgotten=forgotten)

    def command(self, verb: str, by: str) -> None:
        """Pauses, resumes, steps or stops it; takes effect in the next cycle.

        Raises:
            WrongState: It is over, or belongs to a job; stopping an ended task has no effect.
        """
        task = self.task
        if self.job and not self.over:
            raise WrongState(
                "task '{name}' belongs to a job: command that one, /jobs/{job}", name=self.name, job=self.job
            )
        if task is None or task.done:
            if verb == "stop":
                return
            raise WrongState("task '{name}' has ended: it takes no {verb}", name=self.name, verb=verb)
        if verb == "stop":
            task.stop(Message("{by} stopped it", by=by))
        else:
            getattr(task, verb)()

    def release(self) -> None:
        """Releases the task if it is over."""
        if self.task is not None and self.task.done:
            self._ended = self.info()
            self.task = None


def _steps(entries: tuple[TraceEntry, ...]) -> tuple[TaskStep, ...]:
    """Combines the start and the end of each step."""
    found: dict[int, TaskStep] = {}
    for entry in entries:
        if entry.step is None:
            continue
        if entry.what is TraceEventKind.STARTED:
            times = {"start": entry.time, "end": None, "ended": None}
            found[entry.step] = TaskStep.view_of(entry, number=entry.step, **times)
        elif entry.what in _ENDS and entry.step in found:
            ended = {"end": entry.time, "ended": entry.what.value, "text": entry.text}
            found[entry.step] = found[entry.step].model_copy(update=ended)
    return tuple(found[number] for number in sorted(found))


def _report(report: GoalReport) -> TaskReport:
    return TaskReport.view_of(report, conditions=tuple(map(asdict, report.conditions)))


class TaskService(Service):
    """Starts, follows and commands tasks; keeps the latest of several with the same name."""

    def __init__(self, station: Station) -> None:
        super().__init__(station)
        self._tasks: OrderedDict[str, KeptTask] = OrderedDict()
        self._guard = threading.Lock()

    # ------------------------------------------------------------------ sessions, in the control thread

    def open(self, session: Session) -> None:
        """Records the tasks of a session, from its first cycle on."""

        def note(task: TaskHandle) -> None:
            self._note(task, job=task.name if task.name in session.jobs.open else "")

        session.on_close(self._release, session.tasks.on_begin(note))

    def _release(self) -> None:
        """Releases the tasks of a session that ends, which are over."""
        for task in tuple(self._tasks.values()):
            task.release()

    def _note(self, task: TaskHandle, *, job: str = "", by: str = "") -> KeptTask:
        """Adds a task, unless it is already known; drops the oldest ended ones."""
        with self._guard:
            known = self._tasks.get(task.name)
            if known is not None and known.task is task:
                return known
            self._tasks.pop(task.name, None)
            kept = self._tasks[task.name] = KeptTask(task, job=job, by=by)
            over = [one for one in self._tasks.values() if one.over]
            for one in over:
                one.release()
            for one in over[: max(0, len(over) - _KEPT)]:
                del self._tasks[one.name]
        return kept

    def job_of(self, name: str) -> str:
        """Returns the id of the job to which a task belongs; empty for none, and for a task no longer kept."""
        known = self._tasks.get(name)
        return "" if known is None else known.job

    # ------------------------------------------------------------------ for callers, in any thread

    def all(self, *, active: bool | None = None, limit: int = 100) -> Tasks:
        """Lists tasks, newest first.

        Args:
            active: True for active tasks only, False for ended tasks only.
            limit: Maximum number of tasks.
        """
        with self._guard:
            tasks = tuple(reversed(self._tasks.values()))
        wanted = [task for task in tasks if active is None or active != task.over]
        return Tasks(items=tuple(task.info(in_full=False) for task in wanted[:limit]))

    def begin(self, request: NewTask, author: Author = LIBRARY) -> TaskInfo:
        """Starts to pursue a goal, or to run given steps or those of a sequence without planning.

        Raises:
            UsageError: The goal or a step cannot be parsed, or there is no such sequence.
            Refused: There are no steps, or a step cannot work and running it anyway was not requested.
            WrongState: Everything is halted.
        """
        policy = Policy(**request.policy.model_dump())
        if request.goal is not None:
            conditions = self._session.parse(request.goal)
            return self._start(lambda session: session.begin(conditions, policy), author)
        steps = self._steps(request)
        if not steps:  # repetitions without steps take no time: the control cycle would never end
            raise Refused("CannotWork", Message("the sequence has no steps: add one"))
        session = self._session
        if not request.anyway:
            require_works(check_steps(session.world.snapshot(), steps, session.tasks.skills))

        def begin(session: Session) -> TaskHandle:
            # Checked above: the control thread has no time to check again.
            session.runtime.require_ready()
            return session.tasks.execute(steps, iterate=request.iterate, policy=policy, anyway=True)

        return self._start(begin, author)

    def _steps(self, request: NewTask) -> Sequence[Step]:
        if request.sequence is not None:
            return steps_of(self._station.document_store.find(SEQUENCE, request.sequence).data)
        session = self._session
        view, skills = session.world.snapshot(), session.tasks.skills
        return [read_step(Step(one.skill, one.arguments), view, skills) for one in request.steps or []]

    def _start(self, begin: Callable[[Session], TaskHandle], author: Author) -> TaskInfo:
        return self._call(lambda session: self._note(begin(session), by=author.name)).info()

    def get(self, name: str) -> TaskInfo:
        """Describes a task: its plan, steps, pending question and result.

        Raises:
            NotFound: There is none with this name.
        """
        return self._find(name).info()

    def trace(self, name: str, limit: int = 1000) -> TaskTrace:
        """Returns the last entries of a task's trace.

        Raises:
            NotFound: There is none with this name.
        """
        return self._find(name).trace(limit)

    def command(self, name: str, command: RunCommand, author: Author = LIBRARY) -> TaskInfo:
        """Commands a task; takes effect in the next control cycle.

        Raises:
            NotFound: There is none with this name.
            WrongState: It does not accept that command now.
        """
        task = self._find(name)
        task.command(command, author.name)
        return task.info()

    def _find(self, name: str) -> KeptTask:
        with self._guard:
            return find("task", name, self._tasks)

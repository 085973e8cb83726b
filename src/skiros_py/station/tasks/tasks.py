"""Use cases: active and ended tasks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from typing import Literal

from skiros_py.api.tasks import NewTask, TaskInfo, TaskQuestion, TaskReport, Tasks, TaskStep, TaskTrace
from skiros_py.errors import Refused
from skiros_py.planning.plan import Step
from skiros_py.skills.skill import SkillDescription
from skiros_py.station.document_store import SEQUENCE
from skiros_py.station.jobs.accounts import planned_steps
from skiros_py.station.requests import LIBRARY, Author, Service, addressed
from skiros_py.station.session import Session
from skiros_py.station.tasks.book import KeptTask
from skiros_py.station.tasks.sequences import require_works, steps_of
from skiros_py.tasks.handle import Policy, TaskHandle
from skiros_py.tasks.report import GoalReport
from skiros_py.tasks.sequences import read_step
from skiros_py.tasks.trace import TraceEntry, TraceEventKind

_ENDS = (TraceEventKind.ENDED, TraceEventKind.FAILED, TraceEventKind.CANCELLED)


def task_info(task: KeptTask, *, in_full: bool = True) -> TaskInfo:
    """Describes a task; callable in any thread; without ``in_full``, omits its plan and steps."""
    question, report, plan = task.question, task.report, task.plan
    return TaskInfo.view_of(
        task,
        begun=datetime.fromtimestamp(task.wall, UTC),
        plan=planned_steps(plan) if in_full and plan is not None else (),
        steps=_steps(tuple(task.entries)) if in_full else (),
        question=TaskQuestion.view_of(question) if question else None,
        report=_report(report) if report is not None else None,
    )


def _steps(entries: tuple[TraceEntry, ...]) -> tuple[TaskStep, ...]:
    """Combines the start and the end of each step."""
    found: dict[int, TaskStep] = {}
    for entry in entries:
        if entry.step is None:
            continue
        if entry.what is TraceEventKind.STARTED:
            found[entry.step] = _started(entry.step, entry)
        elif entry.what in _ENDS and entry.step in found:
            ended = {"end": entry.time, "ended": entry.what.value, "text": entry.text}
            found[entry.step] = found[entry.step].model_copy(update=ended)
    return tuple(found[number] for number in sorted(found))


def _started(number: int, entry: TraceEntry) -> TaskStep:
    return TaskStep.view_of(
        entry, number=number, arguments=dict(entry.arguments), start=entry.time, end=None, ended=None
    )


def _report(report: GoalReport) -> TaskReport:
    conditions = tuple(asdict(condition) for condition in report.conditions)
    return TaskReport.view_of(report, outcome=report.outcome.value, conditions=conditions)


def task_trace(task: KeptTask, limit: int) -> TaskTrace:
    """Returns the last entries of the trace of a task."""
    entries = tuple(task.entries)
    kept = entries[-limit:]
    forgotten = task.forgotten + len(entries) - len(kept)
    return TaskTrace(entries=tuple(entry.as_json() for entry in kept), forgotten=forgotten)


def _skills(session: Session) -> dict[str, SkillDescription]:
    return {capability.skill.name: capability.skill for capability in session.tasks.capabilities}


class TaskService(Service):
    """Starts, follows and commands tasks."""

    def all(self, *, active: bool | None = None, limit: int = 100) -> Tasks:
        """Lists tasks, newest first.

        Args:
            active: True for active tasks only, False for ended tasks only.
            limit: Maximum number of tasks.
        """
        wanted = [task for task in self._station.task_book.all() if active is None or active != task.over]
        return Tasks(items=tuple(task_info(task, in_full=False) for task in wanted[:limit]))

    def begin(self, request: NewTask, author: Author = LIBRARY) -> TaskInfo:
        """Starts to pursue a goal, or to run given steps or those of a sequence without planning.

        Raises:
            UsageError: The goal or a step cannot be parsed, or there is no such sequence.
            Refused: There are no steps, or a step cannot work and running it anyway was not requested.
            WrongState: Everything is halted.
        """
        policy = Policy(**request.policy.model_dump())
        if request.goal is not None:
            conditions = self._station.session.parse(request.goal)
            return self._note(lambda session: session.begin(conditions, policy), author)
        steps = self._steps(request)
        if not steps:  # repetitions without steps take no time: the control cycle would never end
            raise Refused("CannotWork", "the sequence has no steps: add one")
        session = self._station.session
        if not request.anyway:
            require_works(steps, session.world.snapshot(), _skills(session))

        def begin(session: Session) -> TaskHandle:
            # Checked above: the control thread has no time to check again.
            session.runtime.require_ready()
            return session.tasks.execute(steps, iterate=request.iterate, policy=policy, anyway=True)

        return self._note(begin, author)

    def _steps(self, request: NewTask) -> Sequence[Step]:
        if request.sequence is not None:
            return steps_of(self._station.document_store.find(SEQUENCE, request.sequence).data)
        session = self._station.session
        view, skills = session.world.snapshot(), _skills(session)
        return [read_step(Step(one.skill, one.arguments), view, skills) for one in request.steps or []]

    def _note(self, begin: Callable[[Session], TaskHandle], author: Author) -> TaskInfo:
        def do(session: Session) -> KeptTask:
            return self._station.task_book.note(begin(session), by=author.name)

        return task_info(self._station.control.call(do))

    def get(self, name: str) -> TaskInfo:
        """Describes a task: its plan, steps, pending question and result.

        Raises:
            NotFound: There is none with this name.
        """
        return task_info(self._find(name))

    def trace(self, name: str, limit: int = 1000) -> TaskTrace:
        """Returns the last entries of a task's trace.

        Raises:
            NotFound: There is none with this name.
        """
        return task_trace(self._find(name), limit)

    def command(
        self, name: str, command: Literal["pause", "resume", "step", "stop"], author: Author = LIBRARY
    ) -> TaskInfo:
        """Commands a task; takes effect in the next control cycle.

        Raises:
            NotFound: There is none with this name.
            WrongState: It does not accept that command now.
        """
        task = self._find(name)
        task.command(command, author.name)
        return task_info(task)

    def _find(self, name: str) -> KeptTask:
        with addressed():
            return self._station.task_book.find(name)

"""The sources of events: the world, modules, tasks, questions and jobs of the open session."""

from __future__ import annotations

import time
from functools import partial
from typing import Any

from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.messages import cut
from skiros_py.skills.context import Question
from skiros_py.station.events.log import EventLog, Kind
from skiros_py.station.jobs.views import job_state, state_name
from skiros_py.station.modules.runs import ModuleRun, ModuleRuns, Turn
from skiros_py.station.session import Session
from skiros_py.station.tasks.tasks import TaskService
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.jobs.job import Job
from skiros_py.tasks.trace import TraceEntry
from skiros_py.world.change import Change
from skiros_py.world.element import is_learned

_MOST_EDITS = 100
"""Number of edits listed in the event of one change; the history has all of them."""


class EventSources:
    """Logs the events of a session. Its callbacks run in the thread of the event and do not block.

    Args:
        events: The event log.
        tasks: Maps tasks to jobs; notified of a task before this object.
        modules: Reports when a run is paused and when it continues.
        session: The session.
    """

    def __init__(self, events: EventLog, tasks: TaskService, modules: ModuleRuns, session: Session) -> None:
        self._events = events
        self._tasks = tasks
        board = session.cycle.board
        self._events.clock = lambda: board.snapshot.time
        session.on_close(
            lambda: self._events.append(Kind.SYSTEM, "closed"),
            session.world.subscribe(self._change),
            session.monitor.subscribe(self._module),
            modules.turns.add(self._turn),
            session.questions.subscribe(self._question),
            session.tasks.on_begin(self._task),
            session.jobs.subscribe(self._job),
            session.jobs.on_remove(partial(self._job, removed=True)),
        )
        data = {"scene": session.scene, "world_version": session.world.version}
        self._events.append(Kind.SYSTEM, "opened", data=data)

    # ------------------------------------------------------------------ listeners

    def _change(self, change: Change) -> None:
        about = {name for edit in change.edits for name in edit.concerns()}
        learned = bool(about) and all(is_learned(name) for name in change.marks())
        type_ = "learned" if learned else "scene"
        self._events.append(Kind.WORLD, type_, elements=about, data=change_data(change))

    def _module(self, event: ModuleEvent) -> None:
        elements = [name for name in (event.agent, event.target) if name]
        job, data = self._tasks.job_of(event.task), event.as_json()
        self._events.append(Kind.MODULE, event.status.value, event.module, job=job, elements=elements, data=data)

    def _turn(self, run: ModuleRun, turn: Turn) -> None:
        text = {"paused": "paused at its current position", "resumed": "continues"}[turn]
        agent, module = run.wish.agent, run.wish.module
        event = ModuleEvent(0.0, run.kind, module, Status.RUNNING, 0, text, agent=agent, id=run.id, path=module)
        self._events.append(Kind.MODULE, turn, module, elements=[agent], data=event.as_json())

    def _question(self, question: Question) -> None:
        data = {
            "question": question.id,
            "kind": question.kind.value,
            "text": question.text,
            "options": question.options,
            "asker": question.asker,
        }
        self._events.append(Kind.TASK, "question", question.asker, data=data)

    def _task(self, task: TaskHandle) -> None:
        name, job = task.name, self._tasks.job_of(task.name)

        def tell(entry: TraceEntry) -> None:
            data = {key: value for key, value in entry.as_json().items() if key not in ("time", "what")}
            elements = {*entry.arguments.values(), entry.agent} - {""}
            self._events.append(Kind.TASK, entry.what.value, name, job=job, elements=elements, data=data)

        task.trace.subscribe(tell)

    def _job(self, job: Job, *, removed: bool = False) -> None:
        type_ = "Removed" if removed else state_name(job.state).value
        self._events.append(Kind.JOB, type_, job.id, job=job.id, data=job_data(job))


def change_data(change: Change) -> dict[str, Any]:
    """Returns a change of the world as plain data: the first edits, and the number of all edits."""
    few = change.edits[:_MOST_EDITS]
    data = Change(change.number, change.author, change.reason, change.time, few, change.writer, change.undoes).as_json()
    if len(few) < len(change.edits):
        data |= {"all_edits": len(change.edits), "read": f"/api/v1/world/changes/{change.number}"}
    return data


def job_data(job: Job) -> dict[str, Any]:
    """Returns the state of a job as data of an event; the full job is available from the job routes."""
    return {
        "id": job.id,
        "version": job.version,
        "state": job_state(job, time.time()).model_dump(mode="json"),
        "detail": job.detail,
        "choices": job.choices,
        "question": job.question,
        "outcome": job.outcome.value if job.outcome is not None else None,
        "reasons": [cut(reason, 1000) for reason in job.reasons[:10]],
        "attempts": job.attempts,
        "late": job.late,
    }

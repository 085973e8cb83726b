"""Where alarms come from: what stops the robots of the session that is open, breaks, or waits for a person."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from functools import partial

from skiros_py.api.alarms import AlarmKind, Severity
from skiros_py.errors import FileError
from skiros_py.execution.monitor import ModuleEvent, Status
from skiros_py.interruptions import Overrun, WatchedTask
from skiros_py.messages import Message
from skiros_py.plugins.plugin import by_cause
from skiros_py.skills.outcome import BROKEN
from skiros_py.station.alarms.alarms import Alarms
from skiros_py.station.control import CLOSING, ControlThread
from skiros_py.station.session import Session
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.jobs.job import Job
from skiros_py.tasks.trace import TraceEntry, TraceEventKind
from skiros_py.world import vocabulary as v

_log = logging.getLogger(__name__)

_OF_SESSION = (
    AlarmKind.HALTED,
    AlarmKind.CYCLE,
    AlarmKind.MANAGER,
    AlarmKind.QUESTION,
    AlarmKind.JOB,
    AlarmKind.RECORD,
    AlarmKind.DISK,
    AlarmKind.CAMERA,
)
"""These end with the session; what is still so in the next one is raised again."""
_HALTED = partial(Message, "everything was halted ({why}): look, then reset")
_PAUSED = partial(Message, "everything is paused, and goes on by itself once this has ended: {why}")
_LOST = partial(Message, "the skill manager of {agent} is lost: {why}")
_OFF = partial(Message, "{camera} sees things {why} mm off: compare the cameras, then calibrate it")
_SELDOM = 200
"""Cycles between two looks at what seldom changes."""


class AlarmSources:
    """Watches a session until it is closed, and raises and ends its alarms.

    Args:
        alarms: The list.
        control: Runs the session.
        records: The records that cannot be read of each file besides the session's, by name.
        session: The session.
    """

    def __init__(
        self, alarms: Alarms, control: ControlThread, records: Sequence[Mapping[str, FileError]], session: Session
    ) -> None:
        self._alarms = alarms
        self._control = control
        self._records = records
        self._session = session
        self._shown: dict[tuple[AlarmKind, str], str] = {}
        self._asked: dict[int, str] = {}
        self._waiting: dict[str, Job] = {}
        alarms.clear_all(AlarmKind.STATION)
        for job in session.jobs.open.values():
            self._job(job)
        self._look_at_records()
        # The jobs' own observer comes before this one: what a job asks is known when the questions are looked at.
        session.on_close(
            self._close,
            session.jobs.subscribe(self._job),
            session.cycle.observe(self._attend),
            session.monitor.subscribe(self._module),
            session.tasks.on_begin(self._task),
        )
        session.runtime.watchdog.on_overrun(self._overrun)
        session.runtime.watchdog.on_lost(self._stuck)
        self._look_at_plugins()

    def _close(self) -> None:
        self._alarms.clear_all(*_OF_SESSION)
        if self._control.fault is not None:
            self._alarms.raise_(
                AlarmKind.STATION,
                Message("there is no station any more: {fault}", fault=self._control.fault),
                severity=Severity.CRITICAL,
            )

    # ------------------------------------------------------------------ looked at in each cycle

    def _attend(self) -> None:
        try:
            self._look()
        except Exception:  # noqa: BLE001 - a fault of an observer must not stop the robots
            _log.exception("monitoring of alarms failed; the robots continue")

    def _look(self) -> None:
        """Looks for what no listener reports; usually a few comparisons."""
        session, halted = self._session, self._session.cycle.halted
        if self._show(AlarmKind.HALTED, "", "" if halted == CLOSING else halted, _HALTED) and not halted:
            self._alarms.clear(AlarmKind.CYCLE)
        self._show(AlarmKind.DISK, "", session.jobs.fault, _PAUSED)
        if session.questions.open or self._asked:
            self._look_at_questions()
        cycle = session.cycle.board.snapshot.cycle
        if cycle % _SELDOM == 0:
            self._look_at_plugins()
            self._look_at_records()
            self._look_at_cameras()
        for agent in session.managers:
            manager = session.managers.get(agent)
            if manager is not None:
                self._show(AlarmKind.MANAGER, agent, manager.lost, _LOST, agent=agent)

    def _show(self, kind: AlarmKind, source: str, why: str, text: Callable[..., Message], **values: str) -> bool:
        """Raises the alarm of a state, or clears it where there is no reason for it; returns whether that is new."""
        if why == self._shown.get((kind, source), ""):
            return False
        self._shown[kind, source] = why
        if why:
            self._alarms.raise_(kind, text(why=why, **values), source, severity=Severity.HIGH)
        else:
            self._alarms.clear(kind, source)
        return True

    def _look_at_questions(self) -> None:
        """Questions of jobs are alarms of those jobs; the others are alarms of their own."""
        of_jobs = {job.question for job in tuple(self._waiting.values())}
        now = {question.id: question for question in self._session.questions.open if question.id not in of_jobs}
        for number in tuple(self._asked):
            if number not in now:
                self._alarms.clear(AlarmKind.QUESTION, self._asked.pop(number))
        for number, question in now.items():
            if number not in self._asked:
                self._asked[number] = source = f"{question.asker} (question {number})"
                self._alarms.raise_(
                    AlarmKind.QUESTION,
                    question.text,
                    source,
                    severity=Severity.HIGH,
                    choices=question.options,
                    question=number,
                )

    def _look_at_records(self) -> None:
        """Records that cannot be read are left out of all lists; jobs are not executed, either."""
        files = (self._session.jobs.store.unreadable, *self._records)
        for name, fault in [record for file in files for record in dict(file).items()]:
            text = Message(
                "{file}: {reason}; it is left out: 'skiros data check' lists what is damaged; restore a backup",
                file=fault.path.name,
                reason=fault.reason,
            )
            self._alarms.raise_(AlarmKind.RECORD, text, name, severity=Severity.HIGH)

    def _look_at_cameras(self) -> None:
        world = self._session.world
        for camera in world.instances(v.CAMERA):
            error = world.value(camera, v.SIGHT_ERROR)
            off = f"{1e3 * error:.0f}" if isinstance(error, float) else ""
            self._show(AlarmKind.CAMERA, camera, off, _OFF, camera=camera)

    def _look_at_plugins(self) -> None:
        faults = {f"{fault.group}/{fault.name}": str(fault) for fault in by_cause(self._session.catalogue.faults)}
        faults |= {f"signal provider {name}": why for name, why in self._session.runtime.signals.faults.items()}
        faults |= {f"device {id_}": why for id_, why in dict(self._session.cycle.board.guard.off).items()}
        for source, text in faults.items():
            self._alarms.raise_(AlarmKind.PLUGIN, text, source, severity=Severity.LOW)
        for alarm in self._alarms.active:
            if alarm.kind is AlarmKind.PLUGIN and alarm.source not in faults:
                self._alarms.clear(AlarmKind.PLUGIN, alarm.source)

    # ------------------------------------------------------------------ told

    def _job(self, job: Job) -> None:
        """In the thread that changed the job."""
        if job.choices and job.state.is_open:
            self._waiting[job.id] = job
            self._alarms.raise_(
                AlarmKind.JOB,
                Message("job {job}: {detail}", job=job.id, detail=job.detail)
                if job.question is None
                else Message("job {job} is {detail}", job=job.id, detail=job.detail),
                job.id,
                severity=Severity.HIGH,
                choices=job.choices,
                job=job.id,
                question=job.question,
            )
        elif self._waiting.pop(job.id, None) is not None:
            self._alarms.clear(AlarmKind.JOB, job.id)

    def _module(self, event: ModuleEvent) -> None:
        source = f"{event.module} of {event.agent}"
        if event.status is Status.ERROR and event.code == BROKEN:
            text = Message("{source} is broken: {text}", source=source, text=event.text)
            self._alarms.raise_(AlarmKind.MODULE, text, source, severity=Severity.MEDIUM, lasts=False)
        elif event.status is Status.TERMINATED:  # it works again
            self._alarms.clear(AlarmKind.MODULE, source)

    def _task(self, task: TaskHandle) -> None:
        def hear(entry: TraceEntry) -> None:
            report = task.report
            if self._session.cycle.halted:  # there is an alarm of that
                return
            if entry.what is TraceEventKind.FINISHED and report is not None and report.fault:
                text = Message("{name} ended before its time: {fault}", name=task.name, fault=report.fault)
                self._alarms.raise_(AlarmKind.TASK, text, task.name, lasts=False)

        task.trace.subscribe(hear)

    def _overrun(self, overrun: Overrun) -> None:
        """In the watchdog's thread: the control thread cannot tell itself."""
        self._alarms.raise_(AlarmKind.HALTED, _HALTED(why=overrun), severity=Severity.HIGH)

    def _stuck(self, task: WatchedTask) -> None:
        """In the watchdog's thread."""
        text = Message(
            "{name} holds the control cycle and does not come back: the station has to be restarted", name=task.name
        )
        self._alarms.raise_(AlarmKind.CYCLE, text, severity=Severity.CRITICAL)

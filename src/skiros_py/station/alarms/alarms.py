"""Alarms: what stopped a robot, or waits for a person, as one list (in the manner of ISA-18.2)."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from typing import Any

from skiros_py.api.alarms import AlarmAnswer, AlarmInfo, AlarmKind, AlarmPage, Severity
from skiros_py.api.wire import moment
from skiros_py.errors import StaleVersion, UnknownName, WrongState
from skiros_py.station.events.log import EventLog, Kind
from skiros_py.station.requests import LIBRARY, Author, addressed
from skiros_py.station.session import Session

_KEPT = 1000
"""So many alarms that are over are kept; those that are active all are."""


class Alarms:
    """The alarms of one server: all active ones, and the last thousand that are over; for any thread.

    Args:
        events: Receives every change.
        session: Returns the open session, whose jobs and questions wait for answers.
        clock: Returns the wall time [s since 1970].
    """

    def __init__(
        self, events: EventLog, session: Callable[[], Session], clock: Callable[[], float] = time.time
    ) -> None:
        self._events = events
        self._session = session
        self._clock = clock
        self._guard = threading.RLock()
        self._active: dict[tuple[AlarmKind, str], AlarmInfo] = {}
        self._known: dict[str, AlarmInfo] = {}
        self._over: dict[str, None] = {}
        self._count = 0

    # ------------------------------------------------------------------ reading

    @property
    def active(self) -> tuple[AlarmInfo, ...]:
        """The active alarms, oldest first."""
        with self._guard:
            return tuple(self._active.values())

    def all(self, *, active: bool | None = None, limit: int = 100, after: int = 0) -> AlarmPage:
        """Lists alarms, oldest first.

        Args:
            active: True for active ones only, False for the others only.
            limit: Maximum number of alarms.
            after: Only those with a higher number.
        """
        with self._guard:
            known = tuple(self._known.values())
        rest = [alarm for alarm in known if active in (None, alarm.active) and _number(alarm) > after]
        page = rest[:limit]
        return AlarmPage(items=tuple(page), next=str(_number(page[-1])) if len(rest) > limit else None)

    def get(self, id_: str) -> AlarmInfo:
        """Describes an alarm.

        Raises:
            NotFound: There is none with this id, or it ended long ago.
        """
        with self._guard, addressed("UnknownAlarm"):
            if id_ not in self._known:
                raise UnknownName("alarm", id_, [alarm.id for alarm in self._active.values()])
            return self._known[id_]

    # ------------------------------------------------------------------ coming and going

    def raise_(
        self,
        kind: AlarmKind,
        text: str,
        source: str = "",
        *,
        severity: Severity = Severity.MEDIUM,
        lasts: bool = True,
        choices: Sequence[str] = (),
        job: str = "",
        question: int | None = None,
    ) -> AlarmInfo:
        """Raises an alarm. One of that kind and source that is active already is the same alarm, with another text.

        Args:
            kind: What it is about.
            text: What there is, in the operator's words.
            source: What it comes from.
            severity: How soon somebody has to look.
            lasts: True where its source also clears it; else it is over when it is acknowledged.
            choices: The answers that it waits for.
            job: Id of the job that waits.
            question: Id of the question that is asked.
        """
        with self._guard:
            known = self._active.get((kind, source))
            base = known or self._new(kind, source, lasts=lasts)
            asks = {"choices": tuple(choices), "job": job, "question": question}
            alarm = base.model_copy(update={"severity": severity, "text": text, **asks})
            return alarm if alarm == known else self._keep(alarm, "changed" if known else "raised")

    def clear(self, kind: AlarmKind, source: str = "") -> None:
        """Ends the alarm of that kind and source, if it is active: its reason is gone."""
        with self._guard:
            known = self._active.get((kind, source))
            if known is not None:
                self._keep(known, "cleared", until=moment(self._clock()))

    def clear_all(self, *kinds: AlarmKind) -> None:
        """Ends all active alarms of some kinds."""
        with self._guard:
            for kind, source in tuple(self._active):
                if kind in kinds:
                    self.clear(kind, source)

    # ------------------------------------------------------------------ acknowledging and answering

    def acknowledge(self, id_: str, author: Author = LIBRARY) -> AlarmInfo:
        """Records that a person has seen it; one that does not last is over then. Repeating it has no effect.

        Raises:
            NotFound: There is none with this id.
        """
        with self._guard:
            known = self.get(id_)
            if known.acknowledged is not None:
                return known
            now = moment(self._clock())
            until = now if known.active and not known.lasts else known.until
            return self._keep(known, "acknowledged", acknowledged=now, by=author.name, until=until)

    def answer(self, id_: str, answer: AlarmAnswer, author: Author = LIBRARY) -> AlarmInfo:
        """Passes an answer on to the job or the robot that waits for it, which also acknowledges the alarm.

        Raises:
            NotFound: There is no such alarm.
            UnknownName: It does not offer that answer.
            WrongState: Nothing waits for that answer any more.
        """
        if job := self.get(id_).job:
            self._answer_job(id_, job, answer, author.name)
        else:
            self._answer_question(id_, answer, author.name)
        with self._guard:
            known = self.acknowledge(id_, author)
            self._tell(known, "answered", answer=answer.answer, by=author.name)
            return known

    def require_choice(self, id_: str, answer: str, question: int | None = None) -> AlarmInfo:
        """Returns an alarm that may be answered so.

        Args:
            id_: Its id.
            answer: The answer.
            question: The question that is answered; None for whatever it asks.

        Raises:
            UnknownName: There is none of that id, or it does not offer that answer.
            WrongState: It is over, asks nothing, or asks something else.
        """
        alarm = self.get(id_)
        if not alarm.active:
            raise WrongState("alarm {alarm} is over: it waits for no answer any more", alarm=id_)
        if not alarm.choices:
            raise WrongState("alarm {alarm} asks nothing: acknowledge it", alarm=id_)
        if question is not None and question != alarm.question:
            raise WrongState(
                "alarm {alarm} does not wait for the answer to question {question} (any more)",
                alarm=id_,
                question=question,
            )
        if answer not in alarm.choices:
            raise UnknownName("answer", answer, alarm.choices, where=f"of alarm {id_}")
        return alarm

    def _answer_job(self, id_: str, job_id: str, answer: AlarmAnswer, by: str) -> None:
        """Gives an answer to a job, which may have gone on and ask something else while this alarm is looked at.

        Raises:
            UnknownName: The alarm does not offer that answer.
            WrongState: The job waits for it no longer.
        """
        jobs = self._session().jobs
        job = jobs.open.get(job_id)  # before the alarm, which is then of this version or a later one
        now = self.require_choice(id_, answer.answer, answer.question)
        if job is None or job.question != now.question:
            raise WrongState("job '{job}' does not wait for that answer any more: look what it asks now", job=job_id)
        try:
            jobs.answer(job_id, answer.answer, by=by, expects=job.version)
        except StaleVersion:
            raise WrongState("job '{job}' has gone on meanwhile: look what it asks now", job=job_id) from None

    def _answer_question(self, id_: str, answer: AlarmAnswer, by: str) -> None:
        """Gives an answer to a robot.

        Raises:
            UnknownName: The alarm does not offer that answer.
            WrongState: It waits for it no longer.
        """
        now = self.require_choice(id_, answer.answer, answer.question)
        assert now.question is not None, "alarms that offer choices are those of jobs and of questions"
        try:
            self._session().questions.answer(now.question, answer.answer, by=by)
        except UnknownName as error:
            raise WrongState("the question is not open any more: {error}", error=error) from None

    # ------------------------------------------------------------------ keeping

    def _new(self, kind: AlarmKind, source: str, *, lasts: bool) -> AlarmInfo:
        self._count += 1
        return AlarmInfo(
            id=f"{self._events.epoch}-{self._count}",
            kind=kind,
            severity=Severity.MEDIUM,
            text="",
            source=source,
            active=True,
            state="unacknowledged",
            lasts=lasts,
            since=datetime.fromtimestamp(self._clock(), UTC),
        )

    def _keep(self, alarm: AlarmInfo, what: str, **changes: Any) -> AlarmInfo:
        """Keeps an alarm with changes, its state after ISA-18.2, and announces it."""
        alarm = alarm.model_copy(update=changes)
        seen, active = alarm.acknowledged is not None, alarm.until is None
        state = ("acknowledged" if seen else "unacknowledged") if active else "normal" if seen else "returned"
        alarm = alarm.model_copy(update={"active": active, "state": state})
        key = alarm.kind, alarm.source
        self._known[alarm.id] = alarm
        if alarm.active:
            self._active[key] = alarm
        elif key in self._active and self._active[key].id == alarm.id:
            del self._active[key]
            self._over[alarm.id] = None
            if len(self._over) > _KEPT:
                oldest = next(iter(self._over))
                del self._over[oldest], self._known[oldest]
        self._tell(alarm, what)
        return alarm

    def _tell(self, alarm: AlarmInfo, what: str, **more: object) -> None:
        data = alarm.model_dump(mode="json") | more
        self._events.append(Kind.ALARM, what, alarm.id, job=alarm.job, data=data)


def _number(alarm: AlarmInfo) -> int:
    """Returns the number of an alarm since the start of the server, which is part of its id."""
    return int(alarm.id.rpartition("-")[2])

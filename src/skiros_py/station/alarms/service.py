"""Use cases: alarms, which say what stopped a robot, or waits for a person."""

from __future__ import annotations

from skiros_py.api.alarms import AlarmAnswer, AlarmInfo, AlarmPage
from skiros_py.errors import StaleVersion, UnknownName, WrongState
from skiros_py.station.alarms.alarms import Alarm, alarm_info
from skiros_py.station.requests import LIBRARY, Author, Service, addressed

_UNKNOWN = "UnknownAlarm"


class AlarmService(Service):
    """Lists, acknowledges and answers alarms."""

    def all(self, *, active: bool | None = None, limit: int = 100, after: int = 0) -> AlarmPage:
        """Lists alarms, oldest first: all active ones, and the last thousand that are over.

        Args:
            active: True for active ones only, False for the others only.
            limit: How many at most.
            after: Only those with a higher number.
        """
        alarms = [one for one in self._station.alarm_book.all if active is None or one.active is active]
        rest = [alarm for alarm in alarms if alarm.number > after]
        page = rest[:limit]
        further = str(page[-1].number) if len(rest) > limit else None
        return AlarmPage(items=tuple(map(alarm_info, page)), next=further)

    def get(self, id_: str) -> AlarmInfo:
        """Describes an alarm.

        Raises:
            NotFound: There is none of that id.
        """
        with addressed(_UNKNOWN):
            return alarm_info(self._station.alarm_book.alarm(id_))

    def acknowledge(self, id_: str, author: Author = LIBRARY) -> AlarmInfo:
        """Notes that somebody has seen an alarm; it goes when its reason does.

        Raises:
            NotFound: There is none of that id.
        """
        with addressed(_UNKNOWN):
            return alarm_info(self._station.alarm_book.acknowledge(id_, author.name))

    def answer(self, id_: str, answer: AlarmAnswer, author: Author = LIBRARY) -> AlarmInfo:
        """Passes an answer on to the job or the robot that waits for it.

        Raises:
            NotFound: There is no such alarm.
            UnknownName: It does not offer that answer.
            WrongState: Nothing waits for that answer any more.
        """
        with addressed(_UNKNOWN):
            alarm = self._station.alarm_book.alarm(id_)
        if alarm.job:
            self._answer_job(alarm, answer, author.name)
        else:
            self._answer_question(alarm, answer, author.name)
        return alarm_info(self._station.alarm_book.note_answer(id_, answer.answer, author.name))

    def _answer_job(self, alarm: Alarm, answer: AlarmAnswer, by: str) -> None:
        """Gives an answer to a job, which may have gone on and ask something else while this alarm is looked at.

        Raises:
            UnknownName: The alarm does not offer that answer.
            WrongState: The job waits for it no longer.
        """
        jobs = self._station.session.jobs
        job = jobs.open.get(alarm.job)  # before the alarm, which is then of this version or a later one
        now = self._station.alarm_book.require_choice(alarm.id, answer.answer, answer.question)
        if job is None or job.question != now.question:
            raise WrongState(f"job '{alarm.job}' does not wait for that answer any more: look what it asks now")
        try:
            jobs.answer(alarm.job, answer.answer, by=by, expects=job.version)
        except StaleVersion:
            raise WrongState(f"job '{alarm.job}' has gone on meanwhile: look what it asks now") from None

    def _answer_question(self, alarm: Alarm, answer: AlarmAnswer, by: str) -> None:
        """Gives an answer to a robot.

        Raises:
            UnknownName: The alarm does not offer that answer.
            WrongState: It waits for it no longer.
        """
        now = self._station.alarm_book.require_choice(alarm.id, answer.answer, answer.question)
        assert now.question is not None, "alarms that offer choices are those of jobs and of questions"
        try:
            self._station.session.questions.answer(now.question, answer.answer, by=by)
        except UnknownName as error:
            raise WrongState(f"the question is not open any more: {error}") from None

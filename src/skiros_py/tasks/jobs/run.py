"""One running job: the task that pursues its goal, and its records; and jobs cut off by the end of the program."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Future
from contextlib import suppress

from skiros_py.errors import DiskFault, UnknownName, WrongState
from skiros_py.execution.runtime import Runtime
from skiros_py.messages import Message
from skiros_py.planning.domain.actions import with_defaults
from skiros_py.planning.plan import Step
from skiros_py.skills.inference.inferring import applying
from skiros_py.skills.outcome import Failure
from skiros_py.skills.outcome import Outcome as StepOutcome
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.handle import TaskHandle
from skiros_py.tasks.help_from_people import write_by_hand
from skiros_py.tasks.jobs.job import Actual, Intent, Job, MaterialActual, Outcome, Trigger
from skiros_py.tasks.jobs.queue import JobBook
from skiros_py.tasks.report import GoalReport
from skiros_py.tasks.trace import StepRun, TraceEntry
from skiros_py.world.change import PlacementEdit
from skiros_py.world.element import Placement
from skiros_py.world.index import Index
from skiros_py.world.vocabulary import LOT, MANIPULATABLE
from skiros_py.world.world import World


def moved(world: World, job: Job, intents: Iterable[Intent]) -> tuple[MaterialActual, ...]:
    """Returns the parts a job has moved so far: those already recorded, and the changes since :attr:`Job.seen`.

    Only parts that one of its own steps names count, since other jobs may run concurrently. Parts back at their
    original place are left out.

    Args:
        world: The live world model.
        job: The job.
        intents: The steps that were started for it.
    """
    if job.seen is None:
        return job.materials
    now = world.snapshot()
    named = {name for intent in intents for name in intent.arguments.values() if _may_be_part(now, name)}
    said = {material.element: material for material in job.materials}
    moves = {part: (material.origin, material.place) for part, material in said.items()}
    edits = (edit for change in world.log.about(named, job.seen) for edit in change.edits)
    for edit in edits:
        if isinstance(edit, PlacementEdit) and edit.element in named:
            origin = moves[edit.element][0] if edit.element in moves else _place(edit.old)
            moves[edit.element] = origin, _place(edit.new)
    away = {part: ends for part, ends in sorted(moves.items()) if ends[0] != ends[1]}
    return tuple(_actual(now, part, ends, said.get(part)) for part, ends in away.items())


def _may_be_part(now: Index, name: str) -> bool:
    """Returns True for parts and for removed elements, which may have been parts."""
    return not now.has(name) or now.ontology.is_a(now.element(name).type, MANIPULATABLE)


def _place(placement: Placement | None) -> str:
    return "" if placement is None else placement.place


def _actual(now: Index, part: str, ends: tuple[str, str], said: MaterialActual | None) -> MaterialActual:
    origin, place = ends
    if now.has(part):
        element, lot = now.element(part), str(now.value(part, LOT) or "")
        return MaterialActual(
            element=part, class_=element.type, label=element.label, lot=lot, origin=origin, place=place
        )
    known = said or MaterialActual(element=part, class_="", label=part, origin=origin, place=place)
    return known.model_copy(update={"origin": origin, "place": place})


RETRY, BY_HAND, ABORT = "retry", "done by hand", "abort"
"""The user's options: continue from the current world model; the step was done by hand; give the job up."""

CUT_OFF = "unknown: it was cut off, and replanned"
"""Recorded outcome of a cut-off step once the user has reviewed it and resumed the job."""

WAITS = Message("waits for its turn")
"""Detail text of a resumed job while others are running."""


def hold_what_was_cut_off(book: JobBook, world: World) -> None:
    """Holds every job that was started but not finished when the program ended, until the user answers.

    Jobs that already wait for the user are unchanged: nothing was running for them.
    """
    for job in book.open.values():
        if job.state.has_begun:
            intents = book.store.intents(job.id)
            moving = [intent for intent in intents if intent.ended is None]
            if job.id in book.unseen and (not moving or BY_HAND in job.choices):
                continue
            choices = (RETRY, BY_HAND, ABORT) if moving else (RETRY, ABORT)
            asks = {"detail": _detail(moving), "choices": choices, "question": None}
            materials = moved(world, job, intents)
            book.move(job, Trigger.HOLD, "the program ended", materials=materials, seen=None, **asks)


def hold_what_was_halted(book: JobBook, job: Job, why: str) -> Job:
    """Holds a job until the user answers because the system was halted; everything it moved is at rest."""
    detail = Message("everything was halted ({why}): look, reset, then answer", why=why)
    return book.move(job, Trigger.HOLD, why, detail=detail, choices=(RETRY, ABORT), question=None, seen=None)


def _detail(moving: Sequence[Intent]) -> str:
    steps = ", ".join(f"{intent.skill} ({', '.join(intent.arguments.values())})" for intent in moving)
    if steps:
        return Message("the program ended while {steps} was under way: look, then answer", steps=steps)
    return Message("the program ended between two steps: look, then answer")


def done_by_hand(world: World, skills: Mapping[str, SkillDescription], intent: Intent, by: str) -> None:
    """Writes a step's effects into the world.

    Args:
        world: The live world model.
        skills: The available skills by name.
        intent: The step.
        by: Who reports it as done.

    Raises:
        UnknownName: The skill is no longer available, so its effects are unknown.
        WorldError: The world model rejects the effects.
    """
    if intent.skill not in skills:
        raise UnknownName("skill", intent.skill, skills)
    skill = skills[intent.skill]
    values = with_defaults(skill, intent.arguments)
    done = (condition.bind(values) for condition in applying(skill.post, values))
    write_by_hand(world, done, by, Message("{skill} was done by hand", skill=intent.skill))


_BETWEEN_WRITES = 1.0
"""Wall time between two writes of the trace, since each waits for the disk [s]."""


class JobRun:
    """The run of a job; used in the control thread.

    Args:
        task: Pursues the goal.
        runtime: Where the task runs.
        book: Records the job's progress.

    Attributes:
        ending: How the job ends once it is at rest, if it was ended by a command; None otherwise.
        paused: True while it is paused by a command.
        aside: True while it is set aside without a slot: nothing of it moves.
    """

    def __init__(self, task: TaskHandle, runtime: Runtime, book: JobBook) -> None:
        self.ending: Outcome | None = None
        self.paused = False
        self.aside = False
        self._task = task
        self._runtime = runtime
        self._book = book
        self._store = book.store
        self._trigger, self._comment = Trigger.STOP, ""
        self._numbers: dict[int, int] = {}
        self._ends: dict[int, str] = {}
        self._entries: list[TraceEntry] = []
        self._written = time.monotonic()
        self._seen: tuple[object, ...] = ()
        task.trace.subscribe(self._entries.append)
        task.before_step(self._intend)
        task.after_step(self._settle)

    # ------------------------------------------------------------------ commands

    def pause(self) -> None:
        """Pauses the job; if it waits for an answer, it pauses once the answer has arrived."""
        self.paused = True
        self._task.pause()

    def resume(self) -> None:
        """Resumes the job."""
        self.paused = False
        if not self.aside:
            self._task.resume()

    def set_aside(self) -> None:
        """Sets the job aside: when its question is answered, it waits for a slot."""
        self.aside = True
        self._task.pause()

    def take_place(self) -> None:
        """Gives the job a slot and resumes it, unless it is paused."""
        self.aside = False
        if not self.paused:
            self._task.resume()

    def stop(self) -> None:
        """Stops the job."""
        self._task.stop(self._comment or Message("the job is {outcome}", outcome=self.ending))

    def end_as(self, trigger: Trigger, outcome: Outcome, comment: str) -> None:
        """Sets how the job ends once it is at rest; the last call counts."""
        self.ending, self._trigger, self._comment = outcome, trigger, comment

    @property
    def asks(self) -> bool:
        """True while it waits for an answer."""
        return self._task.question is not None

    def answer(self, choice: str, *, by: str, asked: int | None) -> None:
        """Answers its open question; may be called in any thread.

        Args:
            choice: One of the answers that it offers.
            by: Who answers.
            asked: Id of the question that this answers.

        Raises:
            WrongState: There is no open question, or it is a different one by now.
        """
        question = self._task.question
        if question is None or question.id != asked:
            if question is None:
                raise WrongState("job '{job}' waits for no answer any more", job=self._task.name)
            asks = {"job": self._task.name, "text": question.text}
            raise WrongState("job '{job}' asks something else by now: {text}", **asks)
        try:
            self._runtime.questions.answer(question.id, choice, by=by)
        except UnknownName:  # already answered, but the task has not processed it yet
            raise WrongState("job '{job}' has its answer already", job=self._task.name) from None

    # ------------------------------------------------------------------ what is written down

    def _intend(self, run: StepRun) -> Future[None]:
        self._numbers[run.number] = self._store.intend(self._task.name, run.step.skill, run.step.arguments)
        return self._store.sync()

    def _settle(self, run: StepRun, outcome: StepOutcome) -> None:
        ended = Message("failed: {reason}", reason=outcome.reason) if isinstance(outcome, Failure) else "done"
        self._settle_as(run.number, ended)

    def _settle_as(self, number: int, ended: str) -> None:
        self._ends[self._numbers.pop(number)] = ended
        with suppress(DiskFault):  # it is stored as soon as the disk can be written
            self._write_ends()

    def _write_ends(self) -> None:
        for number, ended in tuple(self._ends.items()):
            self._store.settle(self._task.name, number, ended)
            del self._ends[number]

    @property
    def has_news(self) -> bool:
        """True if something has changed that :meth:`follow` stores."""
        return self._task.done or self._look() != self._seen

    def follow(self, job: Job) -> bool:
        """Stores what has changed.

        Args:
            job: The job as it is now.

        Returns:
            True if it is over or cut off.
        """
        task, seen = self._task, self._look()
        if task.done:
            for number in tuple(self._numbers):  # stopped in the middle of these steps, and at rest
                self._settle_as(number, "stopped")
            self.write_trace()  # before the end is announced: readers then see the whole trace
            self._finish(self._with_moves(job))
            return True
        if seen != self._seen:
            self._note(self._with_moves(job), tuple(map(str, self._steps)))
            self._seen = seen
        return False

    def _look(self) -> tuple[object, ...]:
        return self._status, self._task.question, self._steps, self.paused

    @property
    def _status(self) -> str:
        """Its current activity, in words."""
        if self.paused or not self.aside:
            return self._task.status
        return self._task.phase if self.asks else WAITS

    @property
    def _steps(self) -> tuple[Step, ...]:
        plan = self._task.plan
        return tuple(plan.steps) if plan is not None else ()

    def _with_moves(self, job: Job) -> Job:
        """Returns the job with the parts it has moved so far; same version, since it was not published yet."""
        version = self._runtime.world.version
        materials = moved(self._runtime.world, job, self._store.intents(job.id))
        return job.model_copy(update={"materials": materials, "seen": version})

    def _note(self, job: Job, plan: Sequence[str]) -> None:
        """Publishes its current activity; waiting for the user is a state of the job."""
        question = self._task.question
        if question is not None:
            asks = {
                "detail": Message("held: {text}", text=question.text),
                "choices": question.options,
                "question": question.id,
            }
            self._book.move(job, Trigger.HOLD, question.text, plan=plan, **asks)
        elif job.choices and not self.paused:
            self._book.move(job, Trigger.RESUME, "answered", detail=self._status, choices=(), question=None, plan=plan)
        else:
            detail = "paused" if self.paused else self._status
            self._book.change(job.but(detail=detail, choices=(), question=None, plan=plan))

    def write_trace(self) -> None:
        """Stores the trace periodically, and when the job is over; and ends of steps that could not be stored."""
        self._write_ends()
        if self._entries and (self._task.done or time.monotonic() - self._written > _BETWEEN_WRITES):
            entries = tuple(self._entries)
            self._store.add_trace(self._task.name, [entry.as_json() for entry in entries])
            del self._entries[: len(entries)]
            self._written = time.monotonic()

    # ------------------------------------------------------------------ the end

    def _finish(self, job: Job) -> None:
        halted = self._runtime.cycle.halted
        report = self._task.report
        if self.ending is not None:
            self._close(job, self._trigger, self.ending, report)
        elif halted:
            hold_what_was_halted(self._book, job, halted)
        elif report is None or report.stopped:
            self._close(job, Trigger.STOP, Outcome.STOPPED, report)
        else:
            outcome = _outcome(report)
            gone = outcome in (Outcome.FAILED, Outcome.NO_PLAN)
            self._close(job, Trigger.FAIL if gone else Trigger.FINISH, outcome, report)

    def _close(self, job: Job, trigger: Trigger, outcome: Outcome, report: GoalReport | None) -> None:
        conditions = report.conditions if report is not None else ()
        actuals = tuple(Actual(condition=c.condition, reached=c.believed, reason=c.reason) for c in conditions)
        fault = (report.fault,) if report is not None and report.fault else ()
        why = (*(report.no_plan if report is not None else ()), *fault)
        reasons = why or tuple(dict.fromkeys(c.reason for c in conditions if c.reason))
        over = {"outcome": outcome, "detail": "", "choices": (), "question": None}
        self._book.move(job, trigger, self._comment, actuals=actuals, reasons=reasons, **over)


def _outcome(report: GoalReport) -> Outcome:
    reached = sum(c.believed for c in report.conditions)
    if reached == len(report.conditions):
        return Outcome.SUCCEEDED if report.steps else Outcome.ALREADY_SATISFIED
    if report.no_plan and not report.steps:
        return Outcome.NO_PLAN
    return Outcome.PARTIALLY_SUCCEEDED if reached else Outcome.FAILED

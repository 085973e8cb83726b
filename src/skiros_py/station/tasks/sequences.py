"""Use cases: sequences of steps that a person edits and runs."""

from __future__ import annotations

import secrets
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from skiros_py.api.tasks import (
    CheckedStep,
    InsertStep,
    MoveStep,
    NewSequence,
    RunSequence,
    SequenceInfo,
    Sequences,
    SequenceSummary,
    TaskInfo,
    WantedStep,
)
from skiros_py.errors import Busy, Refused, SkirosError, UnknownName, UsageError, WrongState
from skiros_py.planning.plan import NoPlan, Plan, Step
from skiros_py.skills.skill import SkillDescription
from skiros_py.station.documents import SEQUENCE, Document
from skiros_py.station.jobs.accounts import plan_of
from skiros_py.station.requests import ANY_VERSION, LIBRARY, Author, Seen, addressed, require_seen
from skiros_py.station.session import Session
from skiros_py.tasks.sequences import StepCheck, StepSequence, check_steps
from skiros_py.world.index import Index

if TYPE_CHECKING:
    from skiros_py.station.station import Station


@dataclass(frozen=True, slots=True)
class Workbench:
    """The world and the skills at one moment, against which steps are parsed and checked.

    Attributes:
        view: The world.
        skills: The offered skills, by name.
    """

    view: Index
    skills: dict[str, SkillDescription]

    @classmethod
    def of(cls, session: Session) -> Workbench:
        """Returns the workbench of a session; does not block; callable from any thread."""
        return cls(session.world.snapshot(), {c.skill.name: c.skill for c in session.tasks.capabilities})

    def read(self, step: WantedStep) -> Step:
        """Parses a step.

        Raises:
            UsageError: It names a skill, parameter or element that does not exist.
        """
        wanted = Step(step.skill, MappingProxyType(dict(step.arguments)))
        return StepSequence(self.view, self.skills, (wanted,)).steps[0]

    def check(self, steps: Sequence[Step]) -> tuple[StepCheck, ...]:
        """Checks steps in turn; a step with names that no longer exist is reported and skipped."""
        faults = {number: fault for number, step in enumerate(steps) if (fault := self._fault(step))}
        checks = iter(check_steps(self.view, [s for n, s in enumerate(steps) if n not in faults], self.skills))
        return tuple(
            StepCheck(step, (faults[number],)) if number in faults else next(checks)
            for number, step in enumerate(steps)
        )

    def _fault(self, step: Step) -> str:
        try:
            StepSequence(self.view, self.skills, (step,))
        except SkirosError as error:
            return str(error)
        return ""


def require_works(session: Session, steps: Sequence[Step]) -> None:
    """Requires that steps can be run in the present world.

    Raises:
        Refused: A step cannot work.
    """
    checks = Workbench.of(session).check(steps)
    broken = [f"step {n} ({c.step.skill}): {'; '.join(c.problems)}" for n, c in enumerate(checks) if not c.works]
    if broken:
        why = " / ".join(broken)
        raise Refused("CannotWork", f"it cannot work: {why}; mend it, or run it anyway", broken=broken)


_MOST = 500
"""Maximum number of sequences; beyond it some have to be deleted first."""
_MOST_STEPS = 100
_ONCE = RunSequence(iterate=1, anyway=False)
_PLANNING = 30.0
"""Time limit of planning when a sequence is created from a goal [s]."""


class SequenceService:
    """Stores sequences as documents, checks them against the present world, runs them as tasks.

    Args:
        station: The station.
    """

    def __init__(self, station: Station) -> None:
        self._station = station

    def all(self) -> Sequences:
        """Lists the sequences, by id."""
        return Sequences(items=tuple(map(_summary, self._station.documents.all(SEQUENCE))))

    def create(self, wanted: NewSequence) -> SequenceInfo:
        """Creates an empty sequence, or one from given steps or from a plan: for a goal, of a job, a task or a preview.

        Raises:
            WrongState: There is one with this id, or there are too many.
            UsageError: It refers to something that does not exist.
            Refused: There is no plan from which to create it.
        """
        documents = self._station.documents
        if len(documents.all(SEQUENCE)) >= _MOST:
            raise WrongState(f"there are {_MOST} sequences already: delete some that nobody needs")
        steps = self._beginning(wanted)
        id_ = wanted.id or f"sequence-{secrets.token_hex(4)}"
        if documents.get(SEQUENCE, id_) is not None:
            raise WrongState(f"there is a sequence '{id_}' already: change that one, or choose another id")
        return self._info(documents.put(SEQUENCE, id_, _data(wanted.title, steps), expects=0))

    def get(self, id_: str) -> SequenceInfo:
        """Describes a sequence, with every step checked against the present world.

        Raises:
            NotFound: There is none with this id.
        """
        return self._info(self._find(id_))

    def delete(self, id_: str, seen: Seen | None = ANY_VERSION) -> None:
        """Deletes a sequence; its active runs continue.

        Raises:
            NotFound: There is none with this id.
            StaleVersion: It was changed since it was seen.
        """
        document = self._find(id_)
        require_seen(seen, document.version)
        self._station.documents.remove(SEQUENCE, id_, expects=document.version)

    def insert_step(self, id_: str, wanted: InsertStep, seen: Seen | None = ANY_VERSION) -> SequenceInfo:
        """Adds a step before another one, or at the end."""
        step = self._read(wanted)

        def edit(steps: list[Step]) -> None:
            at = len(steps) if wanted.at is None else wanted.at
            if at > len(steps):
                raise UsageError(f"at: from 0 to {len(steps)}, the end, not {at}")
            steps.insert(at, step)

        return self._edit(id_, seen, edit)

    def change_step(self, id_: str, number: int, wanted: WantedStep, seen: Seen | None = ANY_VERSION) -> SequenceInfo:
        """Replaces a step."""
        step = self._read(wanted)

        def edit(steps: list[Step]) -> None:
            steps[_index(steps, number)] = step

        return self._edit(id_, seen, edit)

    def remove_step(self, id_: str, number: int, seen: Seen | None = ANY_VERSION) -> SequenceInfo:
        """Removes a step."""

        def edit(steps: list[Step]) -> None:
            del steps[_index(steps, number)]

        return self._edit(id_, seen, edit)

    def move_step(self, id_: str, number: int, wanted: MoveStep, seen: Seen | None = ANY_VERSION) -> SequenceInfo:
        """Moves a step to another place."""

        def edit(steps: list[Step]) -> None:
            step = steps.pop(_index(steps, number))
            if wanted.to > len(steps):
                raise UsageError(f"to: from 0 to {len(steps)}, the end, not {wanted.to}")
            steps.insert(wanted.to, step)

        return self._edit(id_, seen, edit)

    def run(self, id_: str, request: RunSequence = _ONCE, author: Author = LIBRARY) -> TaskInfo:
        """Runs the steps without planning.

        Raises:
            NotFound: There is none with this id.
            Refused: A step cannot work, and running it anyway was not requested.
            WrongState: Everything is halted.
        """
        steps = _steps(self._find(id_))
        return self._station.tasks.run_steps(steps, request.iterate, author, anyway=request.anyway)

    # ------------------------------------------------------------------ steps of a new sequence

    def _beginning(self, wanted: NewSequence) -> Sequence[Step]:
        station = self._station
        if wanted.goal is not None:
            return self._planned(tuple(wanted.goal))
        if wanted.preview is not None:
            return _of_plan(station.preview_book.find(wanted.preview).plan, f"preview {wanted.preview}")
        if wanted.task is not None:
            return _of_plan(station.task_book.find(wanted.task).plan, f"'{wanted.task}'")
        if wanted.job is not None:
            return self._of_job(wanted.job)
        bench = Workbench.of(station.session)
        return tuple(bench.read(step) for step in wanted.steps or [])

    def _of_job(self, id_: str) -> Sequence[Step]:
        """Returns the steps of the last plan of a job: from its task if known, otherwise from the stored job.

        Raises:
            UnknownName: There is no such job.
            WrongState: It has no plan, or the plan is stored incompletely.
        """
        book = self._station.task_book
        if book.job_of(id_) == id_ and (plan := book.find(id_).plan) is not None:
            return plan.steps
        jobs = self._station.session.jobs
        kept = plan_of(jobs.job(id_), jobs.trace(id_)).steps
        if not all(one.arguments for one in kept):  # a power cut may lose the trace, so that only the names are left
            raise WrongState(f"of the plan of job '{id_}' only the names of the steps are kept: plan its goal again")
        if not kept:
            raise WrongState(f"job '{id_}' has no plan")
        return [Step(one.skill, MappingProxyType(dict(one.arguments))) for one in kept]

    def _planned(self, goal: tuple[str, ...]) -> Sequence[Step]:
        """Plans for a goal, and waits for the plan.

        Raises:
            Refused: There is no plan.
            Busy: It takes too long.
            UsageError: The goal cannot be parsed.
        """
        session = self._station.session
        preview = self._station.preview_book.ask(session, goal, session.tasks.capabilities)
        if not preview.ended.wait(_PLANNING):
            raise Busy(
                f"planning takes longer than {_PLANNING:g} s: make the sequence of preview {preview.id} when it is done"
            )
        outcome = preview.planned.outcome if preview.planned is not None else None
        if isinstance(outcome, Plan):
            return outcome.steps
        reasons = outcome.reasons if isinstance(outcome, NoPlan) else (preview.fault,)
        raise Refused("NoPlan", f"there is no plan: {'; '.join(reasons)}", reasons=list(reasons))

    # ------------------------------------------------------------------ documents

    def _find(self, id_: str) -> Document:
        with addressed():
            return self._station.documents.find(SEQUENCE, id_)

    def _info(self, document: Document) -> SequenceInfo:
        checks = Workbench.of(self._station.session).check(_steps(document))
        return SequenceInfo(
            **_summary(document).model_dump(),
            works=bool(checks) and all(check.works for check in checks),
            steps=tuple(CheckedStep.model_validate(check.as_json()) for check in checks),
        )

    def _read(self, step: WantedStep) -> Step:
        return Workbench.of(self._station.session).read(step)

    def _edit(self, id_: str, seen: Seen | None, edit: Callable[[list[Step]], None]) -> SequenceInfo:
        document = self._find(id_)
        require_seen(seen, document.version)
        steps = _steps(document)
        edit(steps)
        data = _data(document.data["title"], steps)
        return self._info(self._station.documents.put(SEQUENCE, id_, data, expects=document.version))


def _summary(document: Document) -> SequenceSummary:
    data = document.data
    return SequenceSummary(id=document.name, title=data["title"], version=document.version, count=len(data["steps"]))


def _steps(document: Document) -> list[Step]:
    return [Step(one["skill"], MappingProxyType(dict(one["arguments"]))) for one in document.data["steps"]]


def _data(title: str, steps: Sequence[Step]) -> dict[str, Any]:
    if len(steps) > _MOST_STEPS:
        raise UsageError(f"a sequence has at most {_MOST_STEPS} steps, not {len(steps)}")
    return {"title": title, "steps": [{"skill": s.skill, "arguments": dict(s.arguments)} for s in steps]}


def _of_plan(plan: Plan | None, what: str) -> Sequence[Step]:
    if plan is None:
        raise WrongState(f"{what} has no plan")
    return plan.steps


def _index(steps: Sequence[Step], number: int) -> int:
    with addressed():
        if not 0 <= number < len(steps):
            raise UnknownName("step", str(number), [str(n) for n in range(len(steps))])
    return number

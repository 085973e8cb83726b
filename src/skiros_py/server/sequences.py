"""Sequences of steps: kept as documents, checked against the world as it is now, and run as tasks."""

from __future__ import annotations

import secrets
from collections.abc import Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from skiros_py.api.jobs import JobPolicy
from skiros_py.api.sequences import CheckedStep, NewSequence, SequenceInfo, SequenceSummary
from skiros_py.api.tasks import WantedStep
from skiros_py.errors import Busy, SkirosError, UnknownName, UsageError, WrongState
from skiros_py.planning.plan import NoPlan, Plan, Step
from skiros_py.server.problems import Problem
from skiros_py.server.services import Services
from skiros_py.skills.skill import SkillDescription
from skiros_py.station.documents import SEQUENCE, Document
from skiros_py.station.jobs.accounts import plan_of
from skiros_py.station.session import Session
from skiros_py.station.tasks.book import KeptTask
from skiros_py.tasks.policy import Policy
from skiros_py.tasks.sequences import StepCheck, StepSequence, check_steps
from skiros_py.world.index import Index

__all__ = [
    "KIND",
    "Workbench",
    "begin_goal",
    "begin_steps",
    "create",
    "data_of",
    "index",
    "require_works",
    "sequence_info",
    "steps_in",
    "steps_of",
    "summary",
]

KIND = SEQUENCE
"""Kind of their documents."""
_MOST = 500
"""Sequences that a server keeps; somebody has to throw some away before there are more."""
_MOST_STEPS = 100
_PLAIN = JobPolicy()
_PLANNING = 30.0
"""How long a plan may take that a sequence is made of [s]."""


@dataclass(frozen=True, slots=True)
class Workbench:
    """What steps are read and checked with: the world and the skills, as they were at one moment.

    Attributes:
        view: The world.
        skills: The skills that somebody offers, by name.
    """

    view: Index
    skills: dict[str, SkillDescription]

    @classmethod
    def of(cls, session: Session) -> Workbench:
        """Looks at a station; quick, and for any thread."""
        return cls(session.world.snapshot(), {c.skill.name: c.skill for c in session.tasks.capabilities})

    def read(self, step: WantedStep) -> Step:
        """Reads a step.

        Raises:
            UsageError: It names a skill, parameter or element that does not exist.
        """
        wanted = Step(step.skill, MappingProxyType(dict(step.arguments)))
        return StepSequence(self.view, self.skills, (wanted,)).steps[0]

    def check(self, steps: Sequence[Step]) -> tuple[StepCheck, ...]:
        """Checks steps in turn; one that names what is there no more is said to, and passed over."""
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


def steps_of(session: Session, wanted: Sequence[WantedStep]) -> tuple[Step, ...]:
    """Reads steps.

    Raises:
        UsageError: One names a skill, parameter or element that does not exist.
    """
    bench = Workbench.of(session)
    return tuple(bench.read(step) for step in wanted)


# ---------------------------------------------------------------------- as documents


def steps_in(document: Document) -> list[Step]:
    """Returns the steps of a document."""
    return [Step(one["skill"], MappingProxyType(dict(one["arguments"]))) for one in document.data["steps"]]


def data_of(title: str, steps: Sequence[Step]) -> dict[str, Any]:
    """Writes a sequence as a document.

    Raises:
        UsageError: It is too long.
    """
    if len(steps) > _MOST_STEPS:
        raise UsageError(f"a sequence has at most {_MOST_STEPS} steps, not {len(steps)}")
    return {"title": title, "steps": [{"skill": s.skill, "arguments": dict(s.arguments)} for s in steps]}


def create(services: Services, wanted: NewSequence) -> Document:
    """Makes a sequence.

    Raises:
        WrongState: There is one of that id, or there are too many.
        UsageError: Something of it does not exist.
        Problem: There is no plan to make it of.
    """
    if len(services.documents.all(KIND)) >= _MOST:
        raise WrongState(f"there are {_MOST} sequences already: delete some that nobody needs")
    steps = _beginning(services, wanted)
    id_ = wanted.id or f"sequence-{secrets.token_hex(4)}"
    if services.documents.get(KIND, id_) is not None:
        raise WrongState(f"there is a sequence '{id_}' already: change that one, or choose another id")
    return services.documents.put(KIND, id_, data_of(wanted.title, steps), expects=0)


def _beginning(services: Services, wanted: NewSequence) -> Sequence[Step]:
    if wanted.goal is not None:
        return _planned(services, tuple(wanted.goal))
    if wanted.preview is not None:
        return _of_plan(services.previews.find(wanted.preview).plan, f"preview {wanted.preview}")
    if wanted.task is not None:
        return _of_plan(services.tasks.find(wanted.task).plan, f"'{wanted.task}'")
    if wanted.job is not None:
        return _of_job(services, wanted.job)
    return steps_of(services.session, wanted.steps or [])


def _of_job(services: Services, id_: str) -> Sequence[Step]:
    """Returns the steps of the last plan of a job: as its task has it, else as it is kept of the job.

    Raises:
        UnknownName: There is no such job.
        WrongState: It has no plan, or not all of it is kept.
    """
    if services.tasks.job_of(id_) == id_ and (plan := services.tasks.find(id_).plan) is not None:
        return plan.steps
    jobs = services.session.jobs
    kept = plan_of(jobs.job(id_), jobs.trace(id_)).steps
    if not all(one.arguments for one in kept):  # a power cut may take the trace, then there are the names alone
        raise WrongState(f"of the plan of job '{id_}' only the names of the steps are kept: plan its goal anew")
    if not kept:
        raise WrongState(f"job '{id_}' has no plan")
    return [Step(one.skill, MappingProxyType(dict(one.arguments))) for one in kept]


def _of_plan(plan: Plan | None, what: str) -> Sequence[Step]:
    if plan is None:
        raise WrongState(f"{what} has no plan")
    return plan.steps


def _planned(services: Services, goal: tuple[str, ...]) -> Sequence[Step]:
    """Plans for a goal, and waits for that.

    Raises:
        Problem: There is no plan.
        Busy: It takes too long.
        UsageError: The goal cannot be understood.
    """
    session = services.session
    preview = services.previews.ask(session, goal, session.tasks.capabilities)
    if not preview.ended.wait(_PLANNING):
        raise Busy(
            f"planning takes longer than {_PLANNING:g} s: make the sequence of preview {preview.id} when it is done"
        )
    outcome = preview.planned.outcome if preview.planned is not None else None
    if isinstance(outcome, Plan):
        return outcome.steps
    reasons = outcome.reasons if isinstance(outcome, NoPlan) else (preview.fault,)
    raise Problem(409, "NoPlan", f"there is no plan: {'; '.join(reasons)}", reasons=list(reasons))


# ---------------------------------------------------------------------- as told


def summary(document: Document) -> SequenceSummary:
    """Tells what a sequence is."""
    data = document.data
    return SequenceSummary(id=document.name, title=data["title"], version=document.version, count=len(data["steps"]))


def sequence_info(session: Session, document: Document) -> SequenceInfo:
    """Tells what a sequence is, with every step checked as things are now."""
    checks = Workbench.of(session).check(steps_in(document))
    return SequenceInfo(
        **summary(document).model_dump(),
        works=bool(checks) and all(check.works for check in checks),
        steps=tuple(CheckedStep.model_validate(check.as_json()) for check in checks),
    )


# ---------------------------------------------------------------------- run


def require_works(session: Session, steps: Sequence[Step]) -> None:
    """Sees that steps can be run.

    Raises:
        Problem: One cannot work as far as anybody knows.
    """
    checks = Workbench.of(session).check(steps)
    broken = [f"step {n} ({c.step.skill}): {'; '.join(c.problems)}" for n, c in enumerate(checks) if not c.works]
    if broken:
        why = " / ".join(broken)
        raise Problem(409, "CannotWork", f"it cannot work: {why}; mend it, or run it anyway", broken=broken)


def begin_steps(
    services: Services,
    steps: Sequence[Step],
    iterate: int | None,
    by: str,
    *,
    anyway: bool,
    policy: JobPolicy = _PLAIN,
) -> KeptTask:
    """Begins to run steps.

    Raises:
        Problem: There are none; or they cannot work as far as anybody knows, and nobody wants them anyway.
        UsageError: One names what does not exist.
        WrongState: Everything was halted.
    """
    if not steps:  # rounds without steps take no time: the control cycle would never come out of them
        raise Problem(409, "CannotWork", "the sequence has no steps: add one")
    if not anyway:
        require_works(services.session, steps)

    def begin(session: Session) -> KeptTask:
        _require_ready(session)
        sequence = StepSequence(session.world, Workbench.of(session).skills, steps)
        # What speaks against it was said above: the control thread has no time to look once more.
        task = session.tasks.execute(sequence, iterate=iterate, policy=_policy(policy), anyway=True)
        return services.tasks.note(task, by=by)

    return services.control.call(begin)


def begin_goal(services: Services, goal: Sequence[str], policy: JobPolicy, by: str) -> KeptTask:
    """Begins to pursue a goal.

    Raises:
        UsageError: It cannot be understood.
        WrongState: Everything was halted.
    """
    conditions = services.session.parse(goal)

    def begin(session: Session) -> KeptTask:
        _require_ready(session)
        return services.tasks.note(session.tasks.begin(conditions, policy=_policy(policy)), by=by)

    return services.control.call(begin)


def _policy(policy: JobPolicy) -> Policy:
    return Policy(**policy.model_dump())


def _require_ready(session: Session) -> None:
    try:
        session.runtime.require_ready()
    except UsageError as error:
        raise WrongState(str(error)) from None


def index(steps: Sequence[Step], number: int) -> int:
    """Returns the index of a step.

    Raises:
        UnknownName: There is none.
    """
    if not 0 <= number < len(steps):
        raise UnknownName("step", str(number), [str(n) for n in range(len(steps))])
    return number

"""Jobs cut off by the end of the program wait for the user: no step is repeated automatically."""

from __future__ import annotations

from collections.abc import Sequence

from skiros_py.errors import UnknownName
from skiros_py.planning.domain.needs import with_defaults
from skiros_py.planning.problem.task import Capability
from skiros_py.skills.inference import applying
from skiros_py.tasks.jobs.book import JobBook
from skiros_py.tasks.jobs.job import Intent, Job
from skiros_py.tasks.jobs.moves import moved
from skiros_py.tasks.jobs.states import Trigger
from skiros_py.tasks.jobs.store import JobStore
from skiros_py.tasks.person import write_by_hand
from skiros_py.world.world import World

RETRY, BY_HAND, ABORT = "retry", "done by hand", "abort"
"""The user's options: continue from the current world model; the step was done by hand; give the job up."""

CUT_OFF = "nobody knows: it was cut off, and planned anew"
"""Recorded outcome of a cut-off step once the user has reviewed it and resumed the job."""

WAITS = "waits for its turn"
"""Detail text of a resumed job while others are running."""


def hold_what_was_cut_off(book: JobBook, store: JobStore, world: World) -> None:
    """Holds every job that was started but not finished when the program ended, until the user answers.

    Jobs that already wait for the user are unchanged: nothing was running for them.
    """
    for job in book.open.values():
        if job.state.has_begun:
            intents = store.intents(job.id)
            moving = [intent for intent in intents if intent.ended is None]
            if job.id in book.unseen and (not moving or BY_HAND in job.choices):
                continue
            choices = (RETRY, BY_HAND, ABORT) if moving else (RETRY, ABORT)
            asks = {"detail": _detail(moving), "choices": choices, "question": None}
            materials = moved(world, job, intents)
            book.move(job, Trigger.HOLD, "the program ended", materials=materials, seen=None, **asks)


def hold_what_was_halted(book: JobBook, job: Job, why: str) -> Job:
    """Holds a job until the user answers because the system was halted; everything it moved is at rest."""
    detail = f"everything was halted ({why}): look, reset, then answer"
    return book.move(job, Trigger.HOLD, why, detail=detail, choices=(RETRY, ABORT), question=None, seen=None)


def _detail(moving: Sequence[Intent]) -> str:
    steps = ", ".join(f"{intent.skill} ({', '.join(intent.arguments.values())})" for intent in moving)
    when = f"while {steps} was under way" if steps else "between two steps"
    return f"the program ended {when}: look, then answer"


def done_by_hand(world: World, capabilities: Sequence[Capability], intent: Intent, by: str) -> None:
    """Writes a step's effects into the world.

    Args:
        world: The live world model.
        capabilities: The available skills.
        intent: The step.
        by: Who reports it as done.

    Raises:
        UnknownName: The skill is no longer available, so its effects are unknown.
        WorldError: The world model rejects the effects.
    """
    skills = {capability.skill.name: capability.skill for capability in capabilities}
    if intent.skill not in skills:
        raise UnknownName("skill", intent.skill, skills)
    skill = skills[intent.skill]
    values = with_defaults(skill, intent.arguments)
    done = (condition.bind(values) for condition in applying(skill.post, values))
    write_by_hand(world, done, by, f"{intent.skill} was done by hand")

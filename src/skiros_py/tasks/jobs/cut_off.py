"""What was under way when the program ended waits for a person: nothing is done twice by itself."""

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
"""What a person may answer: go on from what is believed now; a person has done the step; give the job up."""

CUT_OFF = "nobody knows: it was cut off, and planned anew"
"""How a step ended that was cut off, when a person has looked and wants the job to go on."""

WAITS = "waits for its turn"
"""What a job says that shall go on, while others are under way."""


def hold_what_was_cut_off(book: JobBook, store: JobStore, world: World) -> None:
    """Lets every job wait for a person that had begun and was not over when the program ended.

    What waits for one already stays as it is: nothing of it was under way.
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
    """Lets a job wait for a person because everything was halted; everything it moved stands."""
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
        capabilities: The skills that are there.
        intent: The step.
        by: Who says that it is done.

    Raises:
        UnknownName: Nobody has the skill any more, so nobody knows its effects.
        WorldError: The effects cannot be so.
    """
    skills = {capability.skill.name: capability.skill for capability in capabilities}
    if intent.skill not in skills:
        raise UnknownName("skill", intent.skill, skills)
    skill = skills[intent.skill]
    values = with_defaults(skill, intent.arguments)
    done = (condition.bind(values) for condition in applying(skill.post, values))
    write_by_hand(world, done, by, f"{intent.skill} was done by hand")

"""What was under way when the program ended waits for a person: nothing is done twice by itself."""

from __future__ import annotations

from collections.abc import Sequence

from skiros_py.tasks.jobs.book import JobBook
from skiros_py.tasks.jobs.job import Intent
from skiros_py.tasks.jobs.states import Trigger
from skiros_py.tasks.jobs.store import JobStore

__all__ = ["ABORT", "BY_HAND", "RETRY", "hold_what_was_cut_off"]

RETRY, BY_HAND, ABORT = "retry", "done by hand", "abort"
"""What a person may answer: go on from what is believed now; a person has done the step; give the job up."""


def hold_what_was_cut_off(book: JobBook, store: JobStore) -> None:
    """Lets every job wait for a person that had begun and was not over when the program ended."""
    for job in tuple(book.jobs.values()):
        if job.state.has_begun:
            moving = [intent for intent in store.intents(job.id) if intent.ended is None]
            choices = (RETRY, BY_HAND, ABORT) if moving else (RETRY, ABORT)
            book.move(job, Trigger.HOLD, "the program ended", detail=_detail(moving), choices=choices)


def _detail(moving: Sequence[Intent]) -> str:
    steps = ", ".join(f"{intent.skill} ({', '.join(intent.arguments.values())})" for intent in moving)
    when = f"while {steps} was under way" if steps else "between two steps"
    return f"the program ended {when}: look, then answer"

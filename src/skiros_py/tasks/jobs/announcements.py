"""Every new state of a job, numbered, for whoever passes it on to others; kept with the job in one transaction."""

from __future__ import annotations

import sqlite3
from dataclasses import dataclass

from skiros_py.tasks.jobs.job import Job

CANCELLED, CLEARED = "cancelled", "cleared"
"""What is announced of a job that is removed, before it began and after its end."""

MOST_ANNOUNCEMENTS = 100_000
"""So many are kept where nobody passes them on; the oldest go first."""


_LONGEST_GOAL = 2000
"""Of goals that are longer the beginning is told [characters]: whoever ordered knows them."""


@dataclass(frozen=True, slots=True)
class Announcement:
    """A job came to a new state, or is there no more.

    Attributes:
        number: Counts announcements without gaps, over restarts as well.
        wall: When [s since 1970].
        job: The job as it was then; a large one without its plan, and with the beginning of a very long goal.
        trigger: What led to it: a value of :class:`~skiros_py.tasks.jobs.Trigger`, "cancelled" or "cleared".
    """

    number: int
    wall: float
    job: Job
    trigger: str


def keep_announcement(connection: sqlite3.Connection, job: Job, data: str, trigger: str) -> None:
    """Keeps what happened to a job.

    Args:
        connection: The file, in a transaction.
        job: The job.
        data: The same as text.
        trigger: What happened.
    """
    values = (job.changed, trigger, data if len(data) <= _LONGEST_GOAL else _brief(job).model_dump_json())
    number = connection.execute("INSERT INTO announcements (wall, trigger, data) VALUES (?, ?, ?)", values).lastrowid
    assert number is not None
    connection.execute("DELETE FROM announcements WHERE number <= ?", (number - MOST_ANNOUNCEMENTS,))


def _brief(job: Job) -> Job:
    """Returns a job without what would fill the file: each of its states is told."""
    goal = job.order.goal
    if sum(map(len, goal)) > _LONGEST_GOAL:
        goal = (f"{goal[0][:_LONGEST_GOAL]}…",)
    return job.model_copy(update={"plan": (), "order": job.order.model_copy(update={"goal": goal})})

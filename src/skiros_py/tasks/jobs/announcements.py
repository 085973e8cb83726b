"""Numbered announcements of job state changes, for forwarding; stored with the job in one transaction."""

from __future__ import annotations

import sqlite3
from dataclasses import dataclass

from skiros_py.tasks.jobs.job import Job

CANCELLED, CLEARED = "cancelled", "cleared"
"""Announced for a job that is removed: before its start, and after its end."""

MOST_ANNOUNCEMENTS = 100_000
"""Maximum number kept if they are not forwarded; the oldest are dropped first."""


_LONGEST_GOAL = 2000
"""Longer goals are truncated in announcements [characters]: the client that ordered has the full text."""


@dataclass(frozen=True, slots=True)
class Announcement:
    """A job changed state or was removed.

    Attributes:
        number: Counts announcements without gaps, over restarts as well.
        wall: When [s since 1970].
        job: The job at that time; a large one without its plan and with a truncated goal.
        trigger: What led to it: a value of :class:`~skiros_py.tasks.jobs.Trigger`, "cancelled" or "cleared".
    """

    number: int
    wall: float
    job: Job
    trigger: str


def keep_announcement(connection: sqlite3.Connection, job: Job, data: str, trigger: str) -> None:
    """Stores an announcement.

    Args:
        connection: The file, in a transaction.
        job: The job.
        data: The job as JSON text.
        trigger: What happened.
    """
    values = (job.changed, trigger, data if len(data) <= _LONGEST_GOAL else _brief(job).model_dump_json())
    number = connection.execute("INSERT INTO announcements (wall, trigger, data) VALUES (?, ?, ?)", values).lastrowid
    assert number is not None
    connection.execute("DELETE FROM announcements WHERE number <= ?", (number - MOST_ANNOUNCEMENTS,))


def _brief(job: Job) -> Job:
    """Returns a job without its bulky fields: every state change is stored."""
    goal = job.order.goal
    if sum(map(len, goal)) > _LONGEST_GOAL:
        goal = (f"{goal[0][:_LONGEST_GOAL]}…",)
    return job.model_copy(update={"plan": (), "order": job.order.model_copy(update={"goal": goal})})

"""Every new state of a job, numbered, for whoever passes it on to others; kept with the job in one transaction."""

from __future__ import annotations

import sqlite3
from dataclasses import dataclass

from skiros_py.tasks.jobs.job import Job

__all__ = ["CANCELLED", "CLEARED", "MOST_ANNOUNCEMENTS", "Announcement", "keep_announcement"]

CANCELLED, CLEARED = "cancelled", "cleared"
"""What is announced of a job that is removed, before it began and after its end."""

MOST_ANNOUNCEMENTS = 100_000
"""So many are kept where nobody passes them on; the oldest go first."""


@dataclass(frozen=True, slots=True)
class Announcement:
    """A job came to a new state, or is there no more.

    Attributes:
        number: Counts announcements without gaps, over restarts as well.
        wall: When [s since 1970].
        job: The job as it was then.
        trigger: What led to it: a value of :class:`~skiros_py.tasks.jobs.Trigger`, "cancelled" or "cleared".
    """

    number: int
    wall: float
    job: Job
    trigger: str


def keep_announcement(connection: sqlite3.Connection, data: str, trigger: str, wall: float) -> None:
    """Keeps what happened to a job."""
    values = (wall, trigger, data)
    number = connection.execute("INSERT INTO announcements (wall, trigger, data) VALUES (?, ?, ?)", values).lastrowid
    assert number is not None
    connection.execute("DELETE FROM announcements WHERE number <= ?", (number - MOST_ANNOUNCEMENTS,))

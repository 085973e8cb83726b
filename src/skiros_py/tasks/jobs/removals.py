"""Which jobs were removed: an order that comes once more, late, does not bring one back to life."""

from __future__ import annotations

import sqlite3

from skiros_py.tasks.jobs.job import Job

REMEMBERED = 7 * 24 * 3600.0
"""How long it is known that there was a job [s]."""


def keep_removal(connection: sqlite3.Connection, job: Job) -> None:
    """Keeps what a job was that is removed: its order and how it ended; and forgets what is old."""
    brief = job.model_copy(update={"plan": (), "actuals": (), "materials": (), "reasons": (), "choices": ()})
    connection.execute("DELETE FROM removed WHERE wall < ?", (job.changed - REMEMBERED,))
    values = (job.id, job.changed, brief.model_dump_json())
    connection.execute("INSERT OR REPLACE INTO removed (id, wall, data) VALUES (?, ?, ?)", values)
